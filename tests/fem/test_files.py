"""Files of reduced bodies, the folder that keeps them, pictures and decks of loads for other programs."""

import io
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from subprocess import PIPE
from unittest.mock import Mock

import meshio
import numpy as np
import pytest

import fem
from fem.body.interfaces import rigid_motion_of_centers
from fem.files import hdf5
from fem.files.hdf5 import Disk
from meshes import STEEL
from tests.fem.bodies import beam_interfaces, static_stress
from tests.fem.calculix_reference import run, stresses_of
from tests.fem.refusals import refused


def test_file_round_trip_and_stale_cache(tmp_path, small):
    mesh, path = small.mesh, tmp_path / "beam.h5"
    fem.save_reduced(path, small, "abc")
    back = fem.load_reduced(path, mesh, "abc")
    for name in ("frequencies", "modes", "stress_modes", "pilots", "inertia", "ritz"):
        np.testing.assert_array_equal(getattr(back, name), getattr(small, name))
    assert fem.load_reduced(path).mesh.digest == mesh.digest
    assert [i.name for i in back.interfaces] == ["left", "right"]
    refused("these parameters", fem.load_reduced, path, digest="abd", error=fem.StaleCacheError)
    with pytest.raises(fem.StaleCacheError, match="belong to this mesh"):
        fem.load_reduced(path, replace(mesh, nodes=1.01 * mesh.nodes))


def test_broken_files_are_named(tmp_path, small):
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()
    modes = whole.index(small.modes[0].tobytes())
    for broken, words in (
        (b"", "an HDF5 file"),
        (b"nothing", "an HDF5 file"),
        (whole[: len(whole) // 2], "an HDF5 file"),
        (whole[:100] + b"x" * 5000 + whole[5100:], "whole|an HDF5 file"),
        (whole[: modes + 64] + bytes(8) + whole[modes + 72 :], "whole"),
    ):
        path.write_bytes(broken)
        refused(rf"beam\.h5 must be ({words})", fem.load_reduced, path)


@pytest.mark.parametrize("size", [1, 3, 8, 1000])
def test_a_pattern_is_found_across_the_parts_of_a_file(monkeypatch, size):
    monkeypatch.setattr(hdf5, "SEARCHED_BYTES", size)
    content = b"GCO" + hdf5.HEAP + b"G" + 2 * hdf5.HEAP + b"GCOL"
    assert list(hdf5._places(io.BytesIO(content), hdf5.HEAP)) == [3, 12, 20]


def test_a_file_that_finds_no_room_leaves_the_old_one(tmp_path, small, monkeypatch):
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()
    monkeypatch.setattr("os.replace", Mock(side_effect=OSError(28, "No space left on device")))
    refused("No space left", fem.save_reduced, path, small.with_modes([0]), error=OSError)
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_fills_while_a_file_is_written_is_named_and_the_old_file_stays(
    tmp_path, small, monkeypatch
):
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()
    written = []

    def full(self, content, write=Disk.write):
        written.append(len(content))
        if len(written) == 5:
            self.failure = OSError(28, "No space left on device")
        return write(self, content)

    monkeypatch.setattr(Disk, "write", full)
    refused("No space left", fem.save_reduced, path, small.with_modes([0]), error=OSError)
    assert len(written) >= 5
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]


IN_A_PROCESS = """
import sys
import fem
from meshes import STEEL
from tests.fem.bodies import beam_interfaces
body = fem.ElasticBody(fem.load_reduced(sys.argv[2]).mesh, STEEL)
print("ready", flush=True)
sys.stdin.readline()
kept = fem.cached_craig_bampton(sys.argv[1], body, beam_interfaces(body), 20)
print(kept.existed, len(kept.body.frequencies))
"""


@pytest.mark.simulation
def test_a_reduction_is_taken_only_if_all_matches(tmp_path, beam):
    ends, averaging = beam_interfaces(beam), beam_interfaces(beam, "averaging")
    first, again = (fem.cached_craig_bampton(tmp_path, beam, ends, 4) for _ in range(2))
    assert (first.existed, again.existed, again.path) == (False, True, first.path)
    np.testing.assert_array_equal(first.body.modes, again.body.modes)
    softer = fem.ElasticBody(beam.mesh, fem.Material(1e9, 0.3, 7800.0))
    moved = fem.ElasticBody(replace(beam.mesh, nodes=1.01 * beam.mesh.nodes), STEEL)
    renamed = fem.ElasticBody(beam.mesh.with_surfaces({"end": beam.mesh.surface("left")}), STEEL)
    asked = [(beam, ends, 5), (beam, ends, 4, {"push": beam.mesh.nodes}), (beam, averaging, 4)]
    asked += [(body, ends, 4) for body in (softer, moved, renamed)]
    others = [fem.cached_craig_bampton(tmp_path, *one) for one in asked]
    assert not any(other.existed for other in others)
    assert len({first.path, *(other.path for other in others)}) == 7
    assert fem.cached_files(tmp_path)[-1].parent == tmp_path
    assert len(fem.cached_files(tmp_path)) == 7


@pytest.mark.simulation
def test_two_processes_that_want_the_same_at_once(tmp_path, small):
    """One of them reduces, the other waits and takes it; neither sees half a file."""
    root, given, folder = Path(__file__).parents[2], tmp_path / "beam.h5", tmp_path / "kept"
    fem.save_reduced(given, small)
    command = [sys.executable, "-c", IN_A_PROCESS, folder, given]
    start = partial(subprocess.Popen, command, cwd=root, stdin=PIPE, stdout=PIPE, text=True)
    with start() as one, start() as other:
        for process in (one, other):
            assert process.stdout.readline() == "ready\n"
        for process in (one, other):
            print("go", file=process.stdin, flush=True)
        answers = sorted(process.communicate(timeout=60)[0].strip() for process in (one, other))
    assert answers == ["False 26", "True 26"]
    (path,) = fem.cached_files(folder)
    np.testing.assert_allclose(fem.load_reduced(path).frequencies, small.frequencies, rtol=1e-9)


def test_a_broken_file_is_computed_again_with_a_warning(tmp_path, beam):
    ends = beam_interfaces(beam)
    kept = fem.cached_craig_bampton(tmp_path, beam, ends, 4)
    kept.path.write_bytes(kept.path.read_bytes()[:5000])
    lines: list[str] = []
    again = fem.cached_craig_bampton(tmp_path, beam, ends, 4, warn=lines.append)
    assert not again.existed
    (line,) = lines
    assert line.startswith(f"the reduction is computed again: {kept.path} must be")
    assert fem.cached_craig_bampton(tmp_path, beam, ends, 4).existed


def test_a_folder_that_cannot_be_written_to_costs_the_cache_only(tmp_path, beam, monkeypatch):
    lines: list[str] = []
    taken = tmp_path / "file"
    taken.write_text("no folder")
    kept = fem.cached_craig_bampton(taken, beam, beam_interfaces(beam), 4, warn=lines.append)
    assert len(kept.body.frequencies) == 10
    assert [str(taken) in line for line in lines] == [True, True]
    monkeypatch.setattr("fem.files.cache.LIMIT", 0)
    fem.cached_craig_bampton(tmp_path, beam, beam_interfaces(beam), 4)
    assert fem.cached_files(tmp_path) == []


def test_vtu_of_a_frame(tmp_path, small, history):
    fem.write_frame_vtu(tmp_path / "frame.vtu", small, history[3])
    fem.write_modes_vtu(tmp_path / "modes.vtu", small, [0, 2])
    frame, modes = (meshio.read(tmp_path / f"{name}.vtu").point_data for name in ("frame", "modes"))
    np.testing.assert_allclose(frame["von mises"], small.von_mises(history[3])[0], rtol=1e-12)
    np.testing.assert_allclose(modes["stress 2"], small.stress_modes[:, :, 2])


def balanced_loads(beam: fem.ElasticBody) -> tuple[list[fem.Interface], np.ndarray, np.ndarray]:
    """The beam's ends, a push on its nodes (n, 3), pull and twist of its ends (2, 6): balanced by inertia."""
    ends = beam_interfaces(beam)
    centers = np.array([[-3e4, 0.0, 2e3, 500.0, 0.0, 0.0], [5e4, 1e3, 0.0, 0.0, -700.0, 900.0]])
    forces = np.zeros_like(beam.mesh.nodes)
    forces[40] = (100.0, -300.0, 200.0)
    at = rigid_motion_of_centers(ends, beam.center_of_mass)
    resultant = beam.rigid_modes.T @ forces.ravel() + at.T @ centers.ravel()
    moved = beam.mass_matrix @ beam.rigid_modes
    relief = moved @ np.linalg.solve(beam.rigid_modes.T @ moved, resultant)
    return ends, forces - relief.reshape(-1, 3), centers


def read_deck(path: Path) -> dict[str, list[list[str]]]:
    """Cards of a deck by keyword and their data, without remarks."""
    cards: dict[str, list[list[str]]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("*") and not line.startswith("**"):
            data = cards.setdefault(line, [])
        elif not line.startswith("**"):
            data.append([part.strip() for part in line.split(",") if part.strip()])
    return cards


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
@pytest.mark.parametrize("program", ["calculix", "abaqus"])
def test_what_a_deck_says_is_in_balance(tmp_path, beam, program, spider):
    path = tmp_path / "beam.inp"
    _, forces, centers = balanced_loads(beam)
    ends = beam_interfaces(beam, spider)
    fem.write_load_deck(path, beam, ends, forces, centers, program=program, remarks=["a beam"])
    cards = read_deck(path)
    places = {int(row[0]): np.array(row[1:], dtype=float) for row in cards["*NODE, NSET=ALL"]}
    rotations = {int(found[1]) for name in cards if (found := re.search(r"ROT NODE=(\d+)", name)) is not None}
    assert len(rotations) == (2 if (program, spider) == ("calculix", "rigid") else 0)
    force, moment = np.zeros(3), np.zeros(3)
    for node, axis, value in cards["*CLOAD"]:
        one = float(value) * np.eye(3)[(int(axis) - 1) % 3]
        if int(node) in rotations or int(axis) > 3:
            moment += one
        else:
            force += one
            moment += np.cross(places[int(node)], one)
    assert np.abs([force, moment]).max() < 1e-6
    # and the body is held where no rigid body is
    held = {int(node) for node, _ in cards["*BOUNDARY"]}
    tied = {int(row[0]) for name in cards if name.startswith("*NSET") for row in cards[name]}
    assert len(cards["*BOUNDARY"]) == 6
    assert not held & tied
    assert path.read_text().startswith("** a beam\n")


def test_what_cannot_be_a_deck_is_refused(tmp_path, beam):
    ends, forces, centers = balanced_loads(beam)
    write, path = fem.write_load_deck, tmp_path / "beam.inp"
    refused("loads must be in balance, got sums", write, path, beam, ends, forces, 1.001 * centers)
    refused("program must be one of", write, path, beam, ends, forces, centers, program="other")
    assert not path.exists()


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not on this machine")
def test_calculix_finds_the_stress_of_the_static_solution(tmp_path, beam):
    ends, forces, centers = balanced_loads(beam)
    fem.write_load_deck(tmp_path / "beam.inp", beam, ends, forces, centers)
    run(tmp_path, "beam")
    table = stresses_of((tmp_path / "beam.frd").read_text())
    found = np.array([table[node + 1] for node in range(len(forces))])
    expected = static_stress(fem.Partition(beam, ends), forces, centers)
    # six digits in CalculiX's file
    assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)
