"""Stress at a place: the node nearest to it, and the same numbers as the recovery of all nodes."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.results.stress.basis import TOLERANCE, stress_basis
from exudyn_crawler.results.stress.recovery import node_stress, node_table


def test_the_highest_node_has_the_stress_that_the_recovery_found(flexible_run):
    history, stress, hot_spots = flexible_run
    first = hot_spots[13].iloc[0]
    found = node_stress(history, 13, node=int(first["node"]))
    # one shoe's loads have other directions than those of two: either leaves fields out up to its tolerance
    assert float(found.von_mises.max()) == pytest.approx(first["value"], abs=2.0 * TOLERANCE)
    assert float(found.time[int(found.von_mises.values.argmax())]) == pytest.approx(first["time"])
    assert found.attrs["in_spider"] == bool(stress.in_spider[int(first["node"])])
    assert found.attrs["distance_m"] == 0.0


def test_the_nearest_node_is_found_and_its_distance_told(flexible_run):
    history, stress, _ = flexible_run
    node = 200
    place = stress.node_position.values[node]
    found = node_stress(history, 7, near=place + np.array([0.0, 1e-4, 0.0]))
    assert found.attrs["node"] == node
    assert found.attrs["distance_m"] == pytest.approx(1e-4, rel=1e-9)
    assert found.place.values == pytest.approx(place)


def test_principal_stresses_belong_to_the_tensor(flexible_run):
    found = node_stress(flexible_run[0], 7, near=(0.0, 0.0, 0.1))
    one, two, three = (found.principal.sel(order=k).values for k in (1, 2, 3))
    assert (one >= two).all()
    assert (two >= three).all()
    trace = found.stress.sel(component=["xx", "yy", "zz"]).sum("component").values
    assert one + two + three == pytest.approx(trace, abs=1.0)
    mises = np.sqrt(0.5 * ((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2))
    assert mises == pytest.approx(found.von_mises.values, rel=1e-9)
    columns = node_table(found)
    assert columns["von Mises in MPa"].to_numpy() == pytest.approx(mises / 1e6)
    assert columns["principal 3 in MPa"].to_numpy() == pytest.approx(three / 1e6)
    assert list(columns)[:2] == ["time in s", "xx in MPa"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"shoe": 5, "near": (0, 0, 0)}, r"of \[7, 13\], got 5"),
        ({"shoe": 7}, "near or node must be given"),
        ({"shoe": 7, "near": (0, 0)}, "near must be three finite numbers"),
        ({"shoe": 7, "near": (0, 0, np.nan)}, "near must be three finite numbers"),
        (
            {"shoe": 7, "near": (250, -500, 60)},
            r"near must be at the shoe, in m .*, 560\.5 m from the nearest",
        ),
        ({"shoe": 7, "node": 10**9}, "node must be in 0"),
        ({"shoe": 7, "node": -1}, "node must be in 0"),
    ],
)
def test_what_is_no_place_is_refused(flexible_run, options, words):
    with pytest.raises(ValueError, match=words):
        node_stress(flexible_run[0], **options)


def test_a_file_has_the_numbers_of_its_history(flexible_run, tmp_path):
    """Those in memory are those of the file: single precision of the contacts included."""
    path = flexible_run[0].save(tmp_path / "history.nc")
    found, expected = (node_stress(one, 13, near=(0.2, -0.3, 0.1)) for one in (path, flexible_run[0]))
    np.testing.assert_array_equal(found.time, expected.time)
    np.testing.assert_allclose(found.stress, expected.stress, rtol=1e-12, atol=1e-3)
    assert found.attrs == expected.attrs


def test_without_static_fields_the_modes_alone_answer(modes_alone):
    basis = stress_basis(modes_alone, [13])
    expected = basis.shapes.stress(basis.coordinates[13], np.array([200]))[:, 0]
    np.testing.assert_allclose(node_stress(modes_alone, 13, node=200).stress, expected, rtol=1e-9, atol=1e-3)


def test_a_history_without_its_mesh_is_named(flexible_run, tmp_path):
    history = flexible_run[0]
    flexible = history.case.flexible_shoes().with_(mesh=str(tmp_path / "gone.msh"))
    moved = History(history.case.with_(flexible=flexible), history.dataset).save(tmp_path / "moved.nc")
    with pytest.raises(FileNotFoundError, match="no mesh file"):
        node_stress(moved, 13, node=0)


def test_rigid_runs_have_no_stress(translation):
    with pytest.raises(ValueError, match="shoe must be a flexible one of the history, of none, got 13"):
        node_stress(translation, 13, near=(0, 0, 0))
