"""Bogies: two rollers on a body that swings share their load as statics say, wherever their rails lie."""

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.case import StepProfile
from exudyn_crawler.case.gear.running_gear import Bogie
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.model.compiled_system import compiled_system
from tests.model.both import check_matrix_at_rest
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

BOGIE = Bogie(rollers=(1, 2), pivot=(-0.6, 0.0), mass=2e3, inertia=(100.0, 800.0, 800.0, 0.0, 0.0, 0.0))
REAR_PIVOT = BOGIE.with_(pivot=(-0.9, 0.0))
"""Its rear roller is at a third of the distance of its front one."""
RIDGE = Heights(parts=(Ridge(x=11.4, height=0.06, width=0.3, flank=0.4),))
"""Below the rear roller."""
SLOW = StepProfile(times=(0.0, 0.2), values=(0.0, 0.1))


def over_a_ridge(*bogies):
    """Three rollers of which the rear one stands on a ridge and rolls slowly on, without resistance."""
    case = small_case(bogies=bogies, rolling_resistance=0.0).on_cells(RockFloor.hard_floor(), RIDGE)
    return case.with_(drive=case.drive.with_(speed=SLOW))


def loads(history):
    """Forces of rails on the rollers across the line of the first two: array (times, rollers), N."""
    angle = history.side_frame_angles.sel(axis="y").values
    if history.has("bogie_angle"):
        angle = angle + history.bogie_angle.isel(bogie=0).values
    across = np.stack((np.sin(angle), np.zeros_like(angle), np.cos(angle)), axis=-1)
    force = history.roller_force.sum("rail").transpose("time", "roller", "axis").values
    return np.einsum("tra,ta->tr", force, across)


@pytest.fixture(scope="module")
def passed():
    """Passes over the ridge with a bogie, and with rollers that are fixed in the frame."""
    return [simulate(over_a_ridge(*bogies), 1.0, progress=False) for bogies in ((BOGIE,), ())]


def test_rollers_of_a_bogie_are_loaded_alike_at_rest_on_a_ridge(passed):
    """The moment about the pivot is zero; fixed in the frame the second roller hangs free."""
    with_bogie, without = (np.abs(loads(history)[0]) for history in passed)
    assert with_bogie[0] == pytest.approx(with_bogie[1], rel=1e-6)
    assert without[1] == 0.0 < without[0]


def test_rollers_of_a_bogie_are_loaded_alike_while_they_pass_a_ridge_slowly(passed):
    """Their difference is what turns the bogie, whose inertia is small."""
    with_bogie, without = (np.abs(loads(history)[:, :2]) for history in passed)
    apart = np.abs(with_bogie[:, 0] - with_bogie[:, 1]) / with_bogie.sum(axis=1)
    assert np.sqrt(np.mean(apart**2)) < 5e-4
    assert np.all(np.abs(without[:, 0] - without[:, 1]) > 0.5 * without.sum(axis=1))
    angle = passed[0].bogie_angle.isel(bogie=0)
    assert angle[0] > 0.02  # nose down: its rear roller is on the ridge


def test_loads_of_a_bogies_rollers_are_inverse_to_their_distances_from_the_pivot():
    history = simulate(over_a_ridge(REAR_PIVOT), 2e-3, progress=False)
    rear, front, _ = np.abs(loads(history)[0])
    assert rear * 0.3 == pytest.approx(front * 0.9, rel=1e-6)


def test_rollers_carry_bogies_too():
    """Weight of frame and bogie, which is 7e-3 of it, on even ground; what creeps on is slow."""
    case = small_case(bogies=(BOGIE,))
    history = simulate(case, 2e-3, progress=False)
    weight = (case.gear.mass + BOGIE.mass) * case.gravity
    carried = history.roller_force.sel(axis="z").isel(time=0).sum().item()
    assert np.abs(carried) == pytest.approx(weight, rel=1e-3)


def test_newtons_matrix_is_the_derivative_of_the_residual_with_bogies():
    """But for what it leaves out: treads' forces turn, which a light body feels most."""
    case = small_case(bogies=(BOGIE.with_(pivot=(-0.6, 0.2)),))
    check_matrix_at_rest(case, 12, 2e-3)


def test_bogies_of_two_tracks_are_bodies_in_the_order_of_their_names():
    rollers = Case.shovel().gear.rollers
    bogie = BOGIE.with_(pivot=(0.5 * (rollers[0] + rollers[1]), 0.1))
    case = Case.shovel().with_({"gear.bogies": (bogie,)})
    layout = compiled_system(case).layout
    assert layout.bodies == case.gear.bodies
    assert layout.bodies[-2:] == ("right bogie 1", "left bogie 1")
    places = case.gear.bogie_reference(case)[:, 1] - case.gear.frame_start(case)[1]
    np.testing.assert_allclose(places, case.gear.middles)
    wheels = compiled_system(case).tables.forces.wheels
    last = len(layout.bodies) + layout.shoes
    carriers = {name: wheels.frames[k] for k, name in enumerate(case.gear.wheel_names)}
    assert carriers["right roller 1"] == carriers["right roller 2"] == last - 2
    assert carriers["left roller 1"] == carriers["left roller 2"] == last - 1
    assert carriers["left roller 3"] == layout.shoes
