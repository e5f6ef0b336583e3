"""What a newcomer runs first, as from a shell."""

import resource
import subprocess
import sys

import pytest

CALL = [sys.executable, "-m", "exudyn_crawler", "demo"]


def processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.slow
def test_the_demo_makes_its_page_within_20_s_and_compiles_nothing_that_the_installation_did(tmp_path):
    subprocess.run([*CALL, "--prepare"], cwd=tmp_path, check=True)
    assert not list(tmp_path.iterdir())
    before = processor_time()
    done = subprocess.run(CALL, cwd=tmp_path, check=True, capture_output=True, text=True)
    assert processor_time() - before < 20.0
    assert "compile the equations" not in done.stderr
    assert "peak stress" in done.stdout
    assert "exudyn-crawler init" in done.stdout.splitlines()[-1]
    page = (tmp_path / "results/demo/report.html").read_text(encoding="utf-8")
    assert "Track in motion" in page
    assert "Flexible shoes in 3D" in page
