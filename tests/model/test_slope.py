"""Ground that slopes: gravity, weights and machine loads lean, and friction holds the track or does not."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, LoadCycle, SphereContact, simulate
from exudyn_crawler.case import statics
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.results.balance import energy_balance, shoe_imbalance, track_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.rest import STEADY_DRAGS
from studies.grounds import plain
from studies.sliding import check_sliding, steady_sliding
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

FREE = Drive.translation().with_(on=())
SLIDES = pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.UnbalancedWarning")
"""Starts from rest that is none, where no friction at the start holds what leans."""


def on_slope(grade, side_slope, base=None):
    """Three shoes that nothing but the ground holds."""
    few = {"track.shoe_count": 3, "terrain.grade": grade, "terrain.side_slope": side_slope}
    return (base or Case.translation()).with_(few, loads=LoadCycle.propel(3), drive=FREE)


def carried(history):
    """Force of the ground on the track (times, 3) and what the track weighs with its load (3,), N."""
    case = history.case
    ground = (history.normal_force + history.friction_force).sum("contact").values
    load = case.loads.loads(0.0).sum() + case.track.shoe_count * case.shoe.mass * case.gravity
    return ground, load * case.terrain.down


@pytest.fixture(scope="module")
def creeping():
    # most of the checks are as exact as the solver
    return simulate(on_slope(0.1, -0.05).with_({"solver.residual": 1e-3}), 1.0)


def test_gravity_leans_by_grade_and_side_slope():
    assert Case.translation().gravity_vector().tolist() == [0.0, 0.0, -9.81]
    for slopes in ((0.1, -0.05), (-0.3, 0.2)):
        gravity = on_slope(*slopes).gravity_vector()
        assert np.linalg.norm(gravity) == pytest.approx(9.81, rel=1e-12)
        # uphill along x and to the left is against gravity, by the sine of the angle of slope
        assert gravity[:2] == pytest.approx(-9.81 * np.sin(np.arctan(slopes)), rel=1e-12)


def test_at_the_start_the_ground_carries_the_whole_weight(creeping):
    ground, weight = carried(creeping)
    # but what the search's drag takes of a track that slips
    momentum = creeping.case.shoe.mass * creeping.velocity.values[0].sum(axis=0)
    drag = STEADY_DRAGS[0] * np.linalg.norm(momentum)
    assert ground[0] == pytest.approx(-weight, abs=drag)
    assert drag < 2e-4 * np.linalg.norm(weight)


def test_a_track_on_a_slope_balances_its_leaning_weight(creeping):
    _, weight = carried(creeping)
    for imbalance in (track_imbalance(creeping), shoe_imbalance(creeping)):
        assert np.abs(imbalance.force.values).max() < 1e-6 * np.linalg.norm(weight)


def test_a_track_that_creeps_hands_its_whole_weight_to_the_ground(creeping):
    ground, weight = carried(creeping)
    late = creeping.time.values > 0.5
    # it still bounces by less than this
    assert ground[late].mean(axis=0) == pytest.approx(-weight, rel=2e-3)
    stiction = creeping.case.contact.stiction_speed
    slip = creeping.velocity.values[late].mean(axis=(0, 1))
    assert -stiction < slip[0] < 0.0 < slip[1] < stiction  # down the grade and to the left, which is lower


def slick(grade, side_slope):
    """The same on ground of little friction, which does not fall with slip."""
    friction = {"contact.static_friction": 0.1, "contact.dynamic_friction": 0.1}
    return on_slope(grade, side_slope).with_(friction)


@SLIDES
def test_work_on_a_slope_is_accounted_for():
    balance = energy_balance(simulate(slick(0.13, -0.05), 0.2))
    fallen = float(balance.machine_load.max())
    assert fallen > 1e4
    assert float(np.abs(balance.imbalance).max()) < 0.01 * fallen


@SLIDES
@pytest.mark.parametrize("axis", [0, 1])
def test_a_track_slides_where_the_slope_exceeds_friction(axis):
    speeds = {}
    for slope in (0.08, 0.13):
        history = simulate(slick(*(slope * np.eye(2)[axis])), 0.4)
        velocity = history.velocity.isel(axis=axis).mean("shoe")
        speeds[slope] = [-float(velocity.sel(time=time, method="nearest")) for time in (0.2, 0.4)]
    assert max(speeds[0.08]) < 0.01
    assert speeds[0.13][0] > 0.1  # beyond all that friction has
    # the machine's load pushes, but its inertia is not in the model
    mass, angle = Case.translation().shoe.mass, math.atan(0.13)
    pull = (386.4e3 + mass * 9.81) * (math.sin(angle) - 0.1 * math.cos(angle)) / mass
    assert (speeds[0.13][1] - speeds[0.13][0]) / 0.2 == pytest.approx(pull, rel=0.05)


@pytest.mark.slow
def test_both_formulations_of_the_terrain_agree_on_a_slope():
    case = on_slope(0.1, -0.05)
    reduced, whole = (simulate(case.with_(terrain_formulation=f), 0.02) for f in ("reduced", "constrained"))
    assert whole.position.values == pytest.approx(reduced.position.values, abs=1e-5)


@SLIDES
def test_spheres_carry_the_leaning_weight():
    history = simulate(on_slope(0.1, -0.05, Case.translation().with_(contact=SphereContact.oil_sand())), 0.1)
    _, weight = carried(history)
    assert np.abs(track_imbalance(history).force.values).max() < 1e-5 * np.linalg.norm(weight)


def test_flexible_shoes_carry_the_leaning_weight():
    few = {"flexible.shoes": (2,), "flexible.fixed_modes": 2, "solver.residual": 1e-3}
    history = simulate(on_slope(0.1, -0.05, Case.stress(SMALL_SHOE).with_(few)), 0.05)
    ground, weight = carried(history)
    assert np.abs(shoe_imbalance(history).force.values).max() < 1e-6 * np.linalg.norm(weight)
    # the flexible shoe weighs what its mesh does; it bounces
    assert ground[-1] == pytest.approx(-weight, rel=0.03)


@pytest.mark.parametrize("grade", [-0.2, 0.2])
def test_a_whole_track_rests_on_a_slope(grade):
    """Each shoe's own friction holds it: were it the links, their pull would lift the front shoe."""
    case = Case.translation().with_({"terrain.grade": grade, "terrain.side_slope": 0.1})
    contact = ground_contact(case)
    q = static_equilibrium(case)
    normal = contact.forces(q, np.zeros_like(q))[2 : 6 * 13 : 6]
    assert normal.sum() == pytest.approx(13 * statics.mean_load(case), rel=1e-6)
    assert normal == pytest.approx(np.full(13, statics.mean_load(case)), rel=0.3)


def test_a_track_is_pulled_up_a_grade_by_friction_and_weight():
    base = on_slope(0.0, 0.0, plain(Case.translation())).with_(drive=Drive.translation())
    level, uphill = (steady_sliding(base.with_({"terrain.grade": grade}), 0.1) for grade in (0.0, 0.1))
    # the last link pulls all shoes but the front one
    shoe = 386.4e3 + base.shoe.mass * base.gravity
    lean = shoe * math.sin(math.atan(0.1))
    flatter = 0.3 * shoe * (1.0 - math.cos(math.atan(0.1)))
    assert uphill.tension[-1] - level.tension[-1] == pytest.approx(2.0 * (lean - flatter), rel=0.1)
    with pytest.raises(ValueError, match=r"terrain\.side_slope must be 0"):
        check_sliding(on_slope(0.0, 0.1), 0.1)
