"""Export to ParaView, and of loads to other finite-element programs."""

import re
import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest

import fem
from fem.interfaces import rigid_motion_of_centers
from tests.fem.bodies import beam_interfaces, static_stress
from tests.fem.calculix_reference import run, stresses_of


def test_vtu_of_a_frame(tmp_path: Path, small: fem.ReducedBody, history: np.ndarray) -> None:
    fem.write_frame_vtu(tmp_path / "frame.vtu", small, history[3])
    fem.write_modes_vtu(tmp_path / "modes.vtu", small, [0, 2])
    frame, modes = (meshio.read(tmp_path / f"{name}.vtu").point_data for name in ("frame", "modes"))
    np.testing.assert_allclose(frame["von mises"], small.von_mises(history[3])[0], rtol=1e-12)
    np.testing.assert_allclose(modes["stress 2"], small.stress_modes[:, :, 2])


def balanced_loads(beam: fem.ElasticBody) -> tuple[np.ndarray, np.ndarray]:
    """Pull and twist of the beam's ends and a push on its nodes, balanced by inertia: (n, 3), (2, 6)."""
    centers = np.array([[-3e4, 0.0, 2e3, 500.0, 0.0, 0.0], [5e4, 1e3, 0.0, 0.0, -700.0, 900.0]])
    forces = np.zeros_like(beam.mesh.nodes)
    forces[40] = (100.0, -300.0, 200.0)
    at = rigid_motion_of_centers(beam_interfaces(beam), beam.center_of_mass)
    resultant = beam.rigid_modes.T @ forces.ravel() + at.T @ centers.ravel()
    moved = beam.mass_matrix @ beam.rigid_modes
    relief = moved @ np.linalg.solve(beam.rigid_modes.T @ moved, resultant)
    return forces - relief.reshape(-1, 3), centers


def read_deck(path: Path) -> dict[str, list[list[str]]]:
    """Cards of a deck by keyword and their data, without remarks."""
    cards: dict[str, list[list[str]]] = {}
    for line in path.read_text().splitlines():
        if line.startswith("*") and not line.startswith("**"):
            data = cards.setdefault(line, [])
        elif not line.startswith("**"):
            data.append([part.strip() for part in line.split(",") if part.strip()])
    return cards


@pytest.mark.parametrize("program", ["calculix", "abaqus"])
def test_what_a_deck_says_is_in_balance(tmp_path: Path, beam: fem.ElasticBody, program: fem.Program) -> None:
    interfaces = beam_interfaces(beam)
    forces, centers = balanced_loads(beam)
    path = tmp_path / "beam.inp"
    fem.write_load_deck(path, beam, interfaces, forces, centers, program=program, remarks=["a beam"])
    cards = read_deck(path)
    places = {int(row[0]): np.array(row[1:], dtype=float) for row in cards["*NODE, NSET=ALL"]}
    rotations = {int(found[1]) for name in cards if (found := re.search(r"ROT NODE=(\d+)", name)) is not None}
    assert len(rotations) == (2 if program == "calculix" else 0)
    force, moment = np.zeros(3), np.zeros(3)
    for node, axis, value in cards["*CLOAD"]:
        one = np.zeros(3)
        one[(int(axis) - 1) % 3] = float(value)
        if int(node) in rotations or int(axis) > 3:
            moment += one
        else:
            force += one
            moment += np.cross(places[int(node)], one)
    assert np.abs(force).max() < 1e-6
    assert np.abs(moment).max() < 1e-6
    # and the body is held where no rigid body is
    held = {int(node) for node, _ in cards["*BOUNDARY"]}
    tied = {int(row[0]) for name in cards if name.startswith("*NSET") for row in cards[name]}
    assert len(cards["*BOUNDARY"]) == 6
    assert not held & tied
    assert path.read_text().startswith("** a beam\n")


def test_what_cannot_be_a_deck_is_refused(tmp_path: Path, beam: fem.ElasticBody) -> None:
    forces, centers = balanced_loads(beam)
    path = tmp_path / "beam.inp"
    with pytest.raises(ValueError, match="loads must be in balance, got sums"):
        fem.write_load_deck(path, beam, beam_interfaces(beam), forces, 1.001 * centers)
    with pytest.raises(ValueError, match="program must be one of"):
        fem.write_load_deck(path, beam, beam_interfaces(beam), forces, centers, program="other")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"rigid spiders, got others for \['left', 'right'\]"):
        fem.write_load_deck(path, beam, beam_interfaces(beam, "averaging"), forces, centers)
    assert not path.exists()


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not on this machine")
def test_calculix_finds_the_stress_of_the_static_solution(tmp_path: Path, beam: fem.ElasticBody) -> None:
    interfaces = beam_interfaces(beam)
    forces, centers = balanced_loads(beam)
    fem.write_load_deck(tmp_path / "beam.inp", beam, interfaces, forces, centers)
    run(tmp_path, "beam")
    table = stresses_of((tmp_path / "beam.frd").read_text())
    found = np.array([table[node + 1] for node in range(len(forces))])
    expected = static_stress(fem.Partition(beam, interfaces), forces, centers)
    # six digits in CalculiX's file
    assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)
