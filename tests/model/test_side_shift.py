"""Loads that shift to a side over time: resultants, balances, and flexible shoes like rigid ones."""

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, FlexibleShoes, LoadCycle, Phase, simulate
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import floating_shoe, side_weights
from exudyn_crawler.results.balance import energy_balance, shoe_imbalance
from exudyn_crawler.results.loads.actions import actions, shoe_mass
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from tests.modal_loads import modal_loads
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

LOAD, SHIFT, END = 386.4e3, 0.3, 0.04
LEANING = LoadCycle(
    phases=(
        Phase(name="even", end=0.0, loads=(LOAD,) * 3),
        Phase(name="swing", end=END, loads=(LOAD,) * 3, side_shift=SHIFT),
    )
)

FEW = FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=(2,), fixed_modes=2)


def leaning(base, **changes):
    few = {"track.shoe_count": 3, "solver.residual": 1e-3}
    return base.with_(few, loads=LEANING, drive=Drive.translation(), **changes)


@pytest.fixture(scope="module")
def rigid():
    return simulate(leaning(Case.translation()), END)


@pytest.fixture(scope="module")
def flexible():
    return simulate(leaning(Case.stress(SMALL_SHOE), flexible=FEW), END)


def test_rest_is_that_of_the_loads_at_the_start():
    """However soon they change."""
    soon = LoadCycle(phases=tuple(phase.with_(end=phase.end / 100.0) for phase in LEANING.phases))
    even = LoadCycle.constant([LOAD] * 3)
    case = leaning(Case.translation())
    expected, *found = (static_equilibrium(case.with_(loads=loads)) for loads in (even, LEANING, soon))
    for at_rest in found:
        assert at_rest == pytest.approx(expected, abs=1e-9)


def test_a_load_shifts_between_the_phases():
    assert LEANING.side_shift.value([0.0, 0.5 * END, END]) == pytest.approx([0.0, 0.5 * SHIFT, SHIFT])
    assert LoadCycle.shovel_cycle().side_shift.values == (0.0,) * 5


@pytest.mark.parametrize("name", ["rigid", pytest.param("flexible", marks=pytest.mark.slow)])
def test_balances_hold_while_a_load_shifts(name, request):
    """The moment tells where the load acts; a flexible shoe's own has parts that are not stored."""
    history = request.getfixturevalue(name)
    balance, stiff = shoe_imbalance(history), [1, 2, 3] if name == "rigid" else [1, 3]
    assert float(np.abs(balance.force).max()) < 2.0
    assert float(np.abs(balance.moment.sel(shoe=stiff)).max()) < 2.0
    (load,) = (one for one in actions(history, 2) if one.kind == "load")
    frames = rotation_matrices(history.angles.sel(shoe=2).values)
    place = np.einsum("tji,tj->ti", frames, load.point - history.position.sel(shoe=2).values)
    middle = shoe_mass(history.case, 2).load_point
    assert place[0] == pytest.approx(middle, abs=1e-9)
    assert place[-1, 1] == pytest.approx(middle[1] + SHIFT, abs=1e-9)


def test_work_of_a_load_that_shifts_is_accounted_for(rigid):
    balance = energy_balance(rigid)
    assert float(np.abs(balance.imbalance).max()) < 0.02 * float(np.abs(balance.elastic_contact).max())


def test_the_ground_presses_more_on_the_side_that_the_load_leans_to(rigid):
    roll = rigid.angles.sel(shoe=2, axis="x").values
    # with the unit below it, but for the lateral force that its lean and the hold of the front shoe make
    assert roll[0] == pytest.approx(float(rigid.unit_tilt.sel(unit=7)[0]), rel=0.02)
    assert roll[-1] - roll[0] < -1e-3  # the left side down


def test_pressure_that_grows_to_a_side_has_its_resultant_there():
    floating = floating_shoe(leaning(Case.stress(SMALL_SHOE), flexible=FEW))
    reduced, weights = floating.reduced, floating.reduced.weights("whole top")
    right, left = side_weights(weights, reduced.nodes)
    assert right + left == pytest.approx(2.0 * weights, abs=1e-15)
    places = np.array([one @ reduced.nodes / one.sum() for one in (right, left)])
    assert places.mean(axis=0) == pytest.approx(floating.load_point, abs=1e-12)
    assert places[1, 1] - places[0, 1] > 0.6
    assert floating.beside[1] == pytest.approx(1.0, rel=1e-12)


def test_modal_loads_follow_the_shift(flexible):
    """Those of the shifted load are those of its two parts, as the run has them."""
    whole, loads = unit_loads(flexible.case).whole, modal_loads(flexible, 2)
    case = flexible.case.with_(loads=LoadCycle.constant([LOAD] * 3))
    difference = loads - modal_loads(flexible.__class__(case=case, dataset=flexible.dataset), 2)
    right, left = side_weights(whole.weights("whole top"), whole.nodes)
    places = [one @ whole.nodes / one.sum() for one in (right, left)]
    reach = 0.5 * (places[1] - places[0])[1]
    force = rotation_matrices(flexible.angles.sel(shoe=2).values)[-1].T @ np.array([0.0, 0.0, -LOAD])
    wanted = 0.5 * SHIFT / reach * force @ (whole.mean_rows(left) - whole.mean_rows(right))
    assert np.abs(difference[0]).max() < 1e-9 * np.abs(loads[0]).max()
    assert difference[-1] == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
