"""Stress at one node by unit loads: from files as from memory, against the recovery of all nodes."""

from pathlib import Path

import numpy as np
import pytest

import fem
from fem import UnitLoads
from tests.fem.bodies import beam_interfaces


@pytest.fixture(scope="module")
def fields(beam: fem.ElasticBody, small: fem.ReducedBody) -> fem.StaticFields:
    ends = beam_interfaces(beam)
    loads = {
        "joints": UnitLoads.at_centers(len(beam.mesh.nodes), ends),
        "push": UnitLoads.spread(np.eye(len(beam.mesh.nodes), 2, -7), ends),
    }
    return fem.static_fields(fem.Partition(beam, ends), small, loads)


@pytest.fixture
def files(tmp_path: Path, small: fem.ReducedBody, fields: fem.StaticFields) -> tuple[Path, Path]:
    reduction, beside = tmp_path / "beam.h5", tmp_path / "beam.fields.h5"
    fem.save_reduced(reduction, small)
    fem.save_fields(beside, fields)
    return reduction, beside


def test_a_unit_has_the_stress_of_its_static_answer(
    beam: fem.ElasticBody, small: fem.ReducedBody, fields: fem.StaticFields
) -> None:
    """What modes and fields of a load make together, recovered at all nodes."""
    answered = small.modes @ fields.held(small.frequencies).T + fields.displacements
    expected = beam.stress(answered)
    for node in (0, 7, len(beam.mesh.nodes) - 1):
        found = fem.unit_stress(small, fields, node)
        np.testing.assert_allclose(found, expected[node].T, atol=1e-9 * np.abs(expected).max())


def test_files_say_the_same_as_what_they_hold(
    files: tuple[Path, Path], small: fem.ReducedBody, fields: fem.StaticFields
) -> None:
    reduction, beside = files
    for node in (0, 7):
        found = fem.unit_stress_in(reduction, beside, node)
        np.testing.assert_array_equal(found, fem.unit_stress(small, fields, node))
        of_modes = fem.unit_stress_in(reduction, None, node)
        np.testing.assert_array_equal(of_modes, fem.unit_stress(small, None, node))
    places = fem.places_in(reduction)
    np.testing.assert_array_equal(places.nodes, small.nodes)
    np.testing.assert_array_equal(places.spider_nodes, small.spider_nodes)


def test_altered_rows_are_refused(
    files: tuple[Path, Path], small: fem.ReducedBody, fields: fem.StaticFields
) -> None:
    reduction, beside = files
    for path, row in ((reduction, small.stress_modes[7]), (beside, fields.displacements[7])):
        whole = path.read_bytes()
        at = whole.index(row.tobytes())
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        with pytest.raises(ValueError, match=f"{path.name} must be whole, got a broken file"):
            fem.unit_stress_in(reduction, beside, 7)
        path.write_bytes(whole)
    with pytest.raises(ValueError, match="must be a 'fem static fields 2' file"):
        fem.unit_stress_in(reduction, reduction, 7)
    beside.unlink()
    with pytest.raises(FileNotFoundError, match=r"beam\.fields"):
        fem.unit_stress_in(reduction, beside, 7)
