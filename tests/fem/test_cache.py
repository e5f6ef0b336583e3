"""Reductions cached on disk: used only if all matches, safe among processes, computed again if broken."""

import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from subprocess import PIPE

import numpy as np
import pytest

import fem
from meshes import STEEL
from tests.fem.bodies import beam_interfaces

IN_A_PROCESS = """
import sys
import fem
from meshes import STEEL
from tests.fem.bodies import beam_interfaces
body = fem.ElasticBody(fem.load_reduced(sys.argv[2]).mesh, STEEL)
print("ready", flush=True)
sys.stdin.readline()
kept = fem.cached_craig_bampton(sys.argv[1], body, beam_interfaces(body), 20)
print(kept.found, len(kept.body.frequencies))
"""


@pytest.mark.simulation
def test_a_reduction_is_taken_only_if_all_matches(tmp_path: Path, beam: fem.ElasticBody) -> None:
    ends, averaging = beam_interfaces(beam), beam_interfaces(beam, "averaging")
    first = fem.cached_craig_bampton(tmp_path, beam, ends, 4)
    again = fem.cached_craig_bampton(tmp_path, beam, ends, 4)
    assert (first.found, again.found) == (False, True)
    assert first.path == again.path
    np.testing.assert_array_equal(first.body.modes, again.body.modes)
    softer = fem.ElasticBody(beam.mesh, fem.Material(1e9, 0.3, 7800.0))
    moved = fem.ElasticBody(replace(beam.mesh, nodes=1.01 * beam.mesh.nodes), STEEL)
    renamed = fem.ElasticBody(beam.mesh.with_surfaces({"end": beam.mesh.surface("left")}), STEEL)
    asked = [(beam, ends, 5), (beam, ends, 4, {"push": beam.mesh.nodes}), (beam, averaging, 4)]
    asked += [(body, ends, 4) for body in (softer, moved, renamed)]
    others = [fem.cached_craig_bampton(tmp_path, *one) for one in asked]
    assert not any(other.found for other in others)
    assert len({first.path, *(other.path for other in others)}) == 7
    assert fem.cached_files(tmp_path)[-1].parent == tmp_path
    assert len(fem.cached_files(tmp_path)) == 7


@pytest.mark.simulation
def test_two_processes_that_want_the_same_at_once(tmp_path: Path, small: fem.ReducedBody) -> None:
    """One of them reduces, the other waits and takes it; neither sees half a file."""
    given = tmp_path / "beam.h5"
    fem.save_reduced(given, small)
    folder = tmp_path / "kept"
    command = [sys.executable, "-c", IN_A_PROCESS, str(folder), str(given)]
    start = partial(
        subprocess.Popen, command, cwd=Path(__file__).parents[2], stdin=PIPE, stdout=PIPE, text=True
    )
    with start() as one, start() as other:
        for process in (one, other):
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
        for process in (one, other):
            assert process.stdin is not None
            process.stdin.write("go\n")
            process.stdin.flush()
        answers = sorted(process.communicate(timeout=60)[0].strip() for process in (one, other))
    assert answers == ["False 26", "True 26"]
    (path,) = fem.cached_files(folder)
    np.testing.assert_allclose(fem.load_reduced(path).frequencies, small.frequencies, rtol=1e-9)


def test_a_broken_file_is_computed_again_with_a_warning(tmp_path: Path, beam: fem.ElasticBody) -> None:
    ends = beam_interfaces(beam)
    kept = fem.cached_craig_bampton(tmp_path, beam, ends, 4)
    kept.path.write_bytes(kept.path.read_bytes()[:5000])
    lines: list[str] = []
    again = fem.cached_craig_bampton(tmp_path, beam, ends, 4, warn=lines.append)
    assert not again.found
    (line,) = lines
    assert line.startswith(f"the reduction is computed again: {kept.path} must be")
    assert fem.cached_craig_bampton(tmp_path, beam, ends, 4).found


def test_a_folder_that_cannot_be_written_to_costs_the_cache_only(
    tmp_path: Path, beam: fem.ElasticBody, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[str] = []
    taken = tmp_path / "file"
    taken.write_text("no folder")
    kept = fem.cached_craig_bampton(taken, beam, beam_interfaces(beam), 4, warn=lines.append)
    assert len(kept.body.frequencies) == 10
    assert [str(taken) in line for line in lines] == [True, True]
    monkeypatch.setattr("fem.cache.LIMIT", 0)
    fem.cached_craig_bampton(tmp_path, beam, beam_interfaces(beam), 4)
    assert fem.cached_files(tmp_path) == []
