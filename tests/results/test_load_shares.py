"""Shares of single loads in a stress: closed forms, their sum, and a shoe that one load alone acts on."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.results.loads.unit_loads import unit_loads
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.hot_spots import load_shares, shares
from tests.modal_loads import modal_loads

SHOE = 7
NODES = np.arange(0, 3000, 500)
OTHERS = {
    "machine load": ("joint_force", "joint_torque", "pin_force", "pin_torque", "contact"),
    "ground": ("joint_force", "joint_torque", "pin_force", "pin_torque", "shoe_load"),
}
"""Variables of what acts on a middle shoe beside one load; "contact" stands for all of a contact's."""
CONTACT = ("normal_force", "friction_force", "friction_torque", "area")


def test_shares_of_uniaxial_stresses_are_those_of_their_sum():
    parts = {"pull": np.array([[3e6, 0, 0, 0, 0, 0]]), "push": np.array([[-1e6, 0, 0, 0, 0, 0]])}
    found = shares(parts)
    assert found["pull"] == pytest.approx(1.5)
    assert found["push"] == pytest.approx(-0.5)


def test_share_of_shear_beside_tension_is_that_of_the_squares():
    tension, shear = 5e6, 4e6
    found = shares(
        {"tension": np.array([[tension, 0, 0, 0, 0, 0]]), "shear": np.array([[0, 0, 0, shear, 0, 0]])}
    )
    assert found["shear"] == pytest.approx(3.0 * shear**2 / (tension**2 + 3.0 * shear**2))
    assert found["tension"] + found["shear"] == pytest.approx(1.0)


def test_pressure_from_all_sides_has_no_share():
    found = shares({"squeeze": np.full((1, 6), -1e6) * [1, 1, 1, 0, 0, 0], "tension": np.eye(1, 6) * 2e6})
    assert found["squeeze"] == pytest.approx(0.0)
    assert found["tension"] == pytest.approx(1.0)


def test_shares_of_no_stress_are_zero():
    assert shares({"nothing": np.zeros((2, 6))})["nothing"].tolist() == [0.0, 0.0]


def variants(history):
    """A history with static fields and without."""
    flexible = history.case.flexible_shoes()
    for fields in (False, True):
        yield History(history.case.with_(flexible=flexible.with_(static_fields=fields)), history.dataset)


def test_shares_of_the_loads_of_a_run_add_up_to_one(flexible_run):
    history, _, tables = flexible_run
    rows = np.resize([3, 20, history.time.size - 1], len(NODES))
    for one in variants(history):
        found = load_shares(stress_basis(one), 13, NODES, rows)
        assert set(found) == {
            f"share of {load}" for load in ("pins", "machine load", "ground", "drive", "inertia")
        }
        assert found.sum(axis=1).to_numpy() == pytest.approx(1.0, abs=1e-9)
    table = tables[13]
    rows = np.searchsorted(history.time.values, table["time"].to_numpy())
    again = load_shares(stress_basis(history), 13, table["node"].to_numpy(), rows)
    for name, own in again.items():
        assert table[name].to_numpy() == pytest.approx(own.to_numpy())


@pytest.mark.parametrize("load", list(OTHERS))
def test_a_load_that_acts_alone_has_all_of_the_stress(flexible_run, load):
    """Its modes have come to rest under it, so that there is no inertia, either."""
    dataset = flexible_run[0].dataset.isel(time=[-1]).copy(deep=True)
    for name in OTHERS[load]:
        for one in CONTACT if name == "contact" else (name,):
            dataset[one] = 0.0 * dataset[one]
    for history in variants(History(flexible_run[0].case, dataset)):
        inside = unit_loads(history.case).integrated.inside
        still = modal_loads(history, SHOE) @ inside / (2.0 * np.pi * history.frequency.values) ** 2
        history.modal_coordinate.loc[{"flexible_shoe": SHOE}] = still
        rows = np.zeros(len(NODES), dtype=int)
        found = load_shares(stress_basis(history, [SHOE]), SHOE, NODES, rows)
        assert found[f"share of {load}"].to_numpy() == pytest.approx(1.0, abs=1e-9)
        assert np.abs(found.drop(columns=f"share of {load}").to_numpy()).max(initial=0.0) < 1e-9
