"""The tutorial, command by command in an empty folder, as a user types it."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs/tutorial.md"
BLOCK = re.compile(r"^```(toml|text|sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LEFT = (
    "results/mine/report.html",
    "results/turn/report.html",
    "mine_shoe.toml",
    "results/mine_shoe/report.html",
    "results/turn_shoe/report.html",
    "results/duty/life.html",
    "results/chain/wear.html",
)
"""Files that the page speaks of."""


@pytest.mark.slow
@pytest.mark.simulation
def test_commands_of_the_tutorial_go_from_a_datasheet_to_a_life_and_wear(tmp_path):
    pytest.importorskip("netgen")
    for language, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if language != "sh":
            (tmp_path / re.match(r"# (\w+\.(?:toml|csv))\n", text)[1]).write_text(text)
            continue
        for line in text.splitlines():
            program, *words = shlex.split(line, comments=True)
            assert program == "exudyn-crawler"
            done = subprocess.run(
                [sys.executable, "-m", "exudyn_crawler", *words],
                cwd=tmp_path,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, done.stdout + done.stderr
    assert [name for name in LEFT if not (tmp_path / name).is_file()] == []
