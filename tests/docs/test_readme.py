"""Every line of README's blocks of commands runs as it stands, one after the other, after `make demo`."""

import os
import re
import shlex
import subprocess
import sys
import tomllib

import pytest

from tests.docs.test_examples import PAGES, ROOT, fences_of

LINES = [
    line.partition("#")[0].strip()
    for fence in fences_of(ROOT / "README.md")
    if fence.info == "sh"
    for line in fence.content.splitlines()
]
OWN = "exudyn-crawler "
PAGE = "exudyn-crawler app"
"""Ends only when its user ends it."""


def test_every_line_is_of_a_kind_that_is_run():
    kinds = [line for line in LINES if not line.startswith((OWN, "make ")) and line != ". .venv/bin/activate"]
    assert kinds == []
    assert LINES[0] == "make demo"
    assert PAGE in LINES


def test_every_file_of_a_line_was_written_by_one_before_it_and_none_twice():
    written = set()
    for line in (line for line in LINES if line.startswith(OWN)):
        name, *words = shlex.split(line)[1:]
        files = {word for word in words if word.endswith(".toml")}
        assert files <= written, line
        made = f"{words[0]}.toml" if name == "init" else None
        made = files.pop().replace(".toml", "_shoe.toml") if name == "shoe" else made
        assert made not in written, line
        written |= {made} - {None}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_extras_that_a_page_names_can_be_installed(page):
    """The package is not published: its extras come from a checkout."""
    text = page.read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert not re.findall(r"pip install '?exudyn-crawler", text)
    assert {*re.findall(r"pip install -e '?\.\[(\w+)\]", text)} <= {*project["optional-dependencies"]}


@pytest.mark.slow
@pytest.mark.simulation
def test_all_lines_run(tmp_path):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    for line in LINES:
        words = shlex.split(line)
        if words[0] == "make":
            # studies have tests of their own, and a clone an environment
            subprocess.run(["make", "--dry-run", words[1]], cwd=ROOT, check=True, capture_output=True)
        elif line == PAGE:
            call = [sys.executable, "-u", "-m", "exudyn_crawler", "app", "--no-browser"]
            with subprocess.Popen(
                call, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True
            ) as page:
                assert page.stdout.readline().startswith("http://127.0.0.1:")
                page.terminate()
        elif line.startswith(OWN):
            call = [sys.executable, "-m", "exudyn_crawler", *words[1:]]
            done = subprocess.run(
                call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
