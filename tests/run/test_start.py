"""Start of a run: at rest, or creeping as steadily as a friction that needs slip holds a track."""

import numpy as np
import pytest
from scipy.optimize import brentq

from exudyn_crawler import Case, Drive, LoadCycle, StepProfile, simulate
from exudyn_crawler.case import Heights, statics
from exudyn_crawler.errors import UnbalancedWarning
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.laws import Coulomb, friction_per_slip
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.results.history.summary import unbalanced
from tests.results.test_machine_answers import SHEET
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

STILL = StepProfile.constant(0.0)
GRADE = {"terrain.grade": 0.1}


def parked(case):
    """Case whose drive stands still."""
    return case.with_(drive=case.drive.with_(speed=STILL))


def three_shoes(grade, side_slope=0.0):
    """Three dragged shoes that nothing but the ground holds."""
    slopes = {"track.shoe_count": 3, "terrain.grade": grade, "terrain.side_slope": side_slope}
    free = Drive.translation().with_(on=())
    return Case.translation().with_(slopes, loads=LoadCycle.propel(3), drive=free)


def creep_speed(case):
    """Slip at which the friction curve has the slope's part of the normal force, m/s."""
    contact, down = case.contact, case.terrain.down
    law = Coulomb(
        contact.static_friction, contact.dynamic_friction, contact.stiction_speed, contact.friction_speed
    )
    wanted = np.hypot(down[0], down[1]) / -down[2]
    return brentq(lambda v: friction_per_slip(law, v) * v - wanted, 0.0, contact.stiction_speed)


CASES = {
    "dragged": three_shoes(0.1, -0.05),
    "rolled": parked(small_case().with_(GRADE)),
    "closed": parked(Case.closed().with_(GRADE)),
}


@pytest.fixture(scope="module", params=CASES)
def start(request):
    """First 0.3 s on a slope, of a track that its friction holds."""
    return simulate(CASES[request.param], 0.3, progress=False)


def test_a_track_on_a_slope_starts_in_balance_and_stays_as_it_was(start):
    """Without slip it would begin with the fall of 0.1 g that friction then stops."""
    shoes = np.linalg.norm(start.acceleration.values, axis=-1)
    # of dragged shoes the drag of the search is left
    assert shoes[0].max() < 2e-3 * start.case.gravity
    assert shoes.max() < 4e-3 * start.case.gravity
    tension = np.linalg.norm(start.joint_force.values, axis=-1).max(axis=1)
    # links of free shoes hardly pull
    assert np.ptp(tension) < 2e-3 * max(tension[0], statics.mean_load(start.case))


def test_it_creeps_down_as_fast_as_the_friction_curve_says(start):
    """All shoes at once, at the slip whose friction is the slope's part of the weight."""
    velocity = start.velocity.values[[0, -1]]
    downhill = start.case.terrain.down[:2] / np.linalg.norm(start.case.terrain.down[:2])
    speed = (velocity[..., :2] @ downhill).mean(axis=1)
    # units that lean under the track push it by some 300 N a shoe, and rollers by their resistance
    assert speed == pytest.approx(creep_speed(start.case), rel=0.1)


def test_a_closed_track_starts_in_balance_on_level_ground_too():
    """It began with 1.1 m/s2, where what held it had no slip yet."""
    history = simulate(parked(Case.closed()), 4e-3, progress=False)
    assert np.linalg.norm(history.acceleration.values, axis=-1).max() < 1e-4 * history.case.gravity


def test_both_formulations_start_alike_on_a_slope():
    compiled, engine, units = (
        simulate(three_shoes(0.1).with_(changes), 4e-3, progress=False)
        for changes in ({}, {"formulation": "engine"}, {"terrain_formulation": "constrained"})
    )
    for other, near in ((engine, 1e-9), (units, 1e-6)):
        assert other.position.values[0] == pytest.approx(compiled.position.values[0], abs=near)
        assert other.velocity.values[0] == pytest.approx(compiled.velocity.values[0], abs=near)
        greatest = np.linalg.norm(other.acceleration.values[0], axis=-1).max()
        assert greatest < 2e-3 * compiled.case.gravity


def test_a_track_that_slides_starts_from_rest_and_warns():
    """A slope of 0.13 is more than a friction of 0.1 holds."""
    slick = {"contact.static_friction": 0.1, "contact.dynamic_friction": 0.1}
    with pytest.warns(UnbalancedWarning, match=r"^residual force at the start: .* kN on shoe \d, "):
        history = simulate(three_shoes(0.13).with_(slick), 4e-3, progress=False)
    assert np.abs(history.velocity.values[0]).max() == 0.0
    _, force = unbalanced(history)
    weight = 3 * (386.4e3 + history.case.shoe.mass * history.case.gravity)
    assert force > 0.01 * weight


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_machine_that_hangs_in_the_air_warns():
    """On a relief of 45 degrees its frame, which is level, is above the rails: all of its weight falls."""
    steep = small_case().on_cells(BekkerSoil.lete_sand(), Heights(slope_x=1.0))
    with pytest.warns(UnbalancedWarning, match="kN on side frame, ") as warned:
        history = simulate(steep, 4e-3, progress=False)
    body, force = unbalanced(history)
    assert body == "side frame"
    assert f"{1e-3 * force:.4g} kN" in str(warned[0].message)


def test_a_drive_that_has_to_stand_holds_as_a_brake():
    """A machine whose drive has a torque limit stays on a grade; without a brake it would roll back."""
    case = derived(SHEET).case
    changes = GRADE | {"gear.torque_limit": 5e4}
    history = simulate(parked(case.with_(changes)), 0.4, progress=False)
    place = history.side_frame_position.sel(axis="x")
    late = place[-1] - place.sel(time=0.2, method="nearest")
    assert abs(float(late)) < 0.2 * 1e-4
    held = float(np.abs(history.drive_moment.isel(time=-1)).sum())
    weight = 35371.0 * case.gravity
    assert held > 0.09 * weight * case.gear.tumbler.radius(case.track.pitch)
