"""Road wheels on sprung arms: statics of their springs, heave of what they carry, loads on a step."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.case import MachineCycle, MachinePhase, StepProfile
from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.model.compiled_system import compiled_system
from tests.model.both import check_matrix_at_rest
from tests.rolled import ROLLERS, small_case

pytestmark = pytest.mark.simulation

REACH, RISE, GRAVITY = 0.8, 0.1, 9.81
INERTIA = (10.0, 20.0, 20.0, 0.0, 0.0, 0.0)
MASS = small_case().gear.mass
MOMENT = MASS * GRAVITY / 3.0 * REACH
"""N m, of a third of the frame's weight."""
STIFFNESS = 12.0 * MOMENT


def arms_of(**changes):
    """Light trailing arms of the three rollers, which carry even shares where these are at their places."""
    values = {"mass": 20.0, "inertia": INERTIA, "torque": MOMENT, "stiffness": STIFFNESS} | changes
    return tuple(Arm(roller=k, pivot=(x + REACH, RISE), **values) for k, x in enumerate(ROLLERS, start=1))


def on_floor(heights=None, **changes):
    """The small case on its arms, on a floor that hardly gives way, with its COM above its middle."""
    case = small_case(arms=arms_of(**changes), rolling_resistance=0.0, com=(0.0, 0.0, 1.0))
    case = case.on_cells(RockFloor.hard_floor(), heights or Heights())
    return case.with_(drive=case.drive.with_(speed=StepProfile.constant(0.0)))


def vertical(history):
    """Loads of the rollers, N."""
    return np.abs(history.roller_force.sum("rail").sel(axis="z").transpose(..., "roller").values)


def test_wheels_stand_at_their_places_where_springs_bear_even_shares():
    """Less what 20 kg of an arm, whose COM is at its pivot, take off: nothing."""
    rest = simulate(on_floor(), 2e-3, progress=False)
    assert rest.arm.values.tolist() == ["arm 1", "arm 2", "arm 3"]
    assert np.abs(rest.arm_angle.values[0]).max() < 2e-3
    assert vertical(rest)[0] == pytest.approx(np.full(3, MASS * GRAVITY / 3.0), rel=0.02)


def test_static_deflection_is_the_moment_over_the_stiffness_of_the_torsion_bar():
    """Springs without the torque for it let the frame down by what the moment of its weight turns them."""
    softer = 0.7 * MOMENT
    rest = simulate(on_floor(torque=softer), 2e-3, progress=False)
    angle = rest.arm_angle.values[0]
    load = vertical(rest)[0]
    # of the wheel's axis behind the pivot, as the arm has turned
    lever = REACH * np.cos(angle) + RISE * np.sin(angle)
    pitch = rest.side_frame_angles.values[0, 1]
    assert abs(pitch) < 1e-3
    assert softer + STIFFNESS * angle == pytest.approx(load * lever, rel=2e-3)
    assert angle.mean() == pytest.approx(0.3 / 12.0, rel=0.05)
    start = simulate(on_floor(), 2e-3, progress=False)
    sunk = start.side_frame_position.values[0, 2] - rest.side_frame_position.values[0, 2]
    assert sunk == pytest.approx(REACH * (angle - start.arm_angle.values[0]).mean(), rel=0.02)


def test_frame_heaves_with_the_frequency_of_its_mass_on_the_springs():
    """Three springs of k / L2 below the mass, which a short push sets in motion."""
    case = on_floor()
    pushes = ((0.0, 0.0), (0.02, -0.3 * MASS * GRAVITY), (0.04, 0.0))
    phases = [
        MachinePhase(name=f"push {end}", end=end, force=(0.0, 0.0, push), moment=(0.0, 0.0, 0.0))
        for end, push in pushes
    ]
    case = case.with_(machine=MachineCycle(phases=phases))
    history = simulate(case, 1.7, progress=False)
    height = history.side_frame_position.values[:, 2]
    time = history.time.values
    late = time > 0.06
    swing = height[late] - height[late].mean()
    up = np.flatnonzero((swing[1:] >= 0.0) & (swing[:-1] < 0.0))
    crossed = time[late][up] - swing[up] * np.diff(time[late])[up] / np.diff(swing)[up]
    period = np.diff(crossed).mean()
    expected = 2.0 * math.pi * math.sqrt(MASS * REACH**2 / (3.0 * STIFFNESS))
    assert len(crossed) > 2
    assert period == pytest.approx(expected, rel=0.03)


STEP = Heights(parts=(Ridge(x=11.4, height=0.06, width=0.3, flank=0.4),))
"""Below the rear roller."""


def test_wheels_share_the_load_over_a_step_by_the_moments_of_their_springs():
    """Fixed in the frame the second wheel hangs free there; on arms loads are those of the springs."""
    rest = simulate(on_floor(STEP), 2e-3, progress=False)
    angle = rest.arm_angle.values[0]
    assert angle[0] > angle[1] + 0.02
    turn = rest.side_frame_angles.values[0, 1] + angle
    force = np.abs(rest.roller_force.sum("rail").transpose("time", "roller", "axis").values[0])
    lever = REACH * np.cos(turn) + RISE * np.sin(turn)
    # along the ridge's flank the rail pushes along, too, at the height of the axis below the pivot
    high = RISE * np.cos(turn) - REACH * np.sin(turn)
    moment = MOMENT + STIFFNESS * angle
    assert np.abs(moment - force[:, 2] * lever) == pytest.approx(
        np.abs(force[:, 0] * high), abs=0.01 * MOMENT
    )
    case = on_floor(STEP)
    fixed = simulate(case.with_({"gear.arms": ()}), 2e-3, progress=False)
    assert vertical(fixed)[0, 1] == 0.0
    assert vertical(rest)[0].min() > 0.5 * MASS * GRAVITY / 3.0


def test_bump_stop_takes_what_is_beyond_its_angle():
    """Springs of a tenth of the moment let the arms down on their stops."""
    stop = 0.05
    rest = simulate(
        on_floor(torque=0.1 * MOMENT, stop=stop, stop_stiffness=50.0 * MOMENT), 2e-3, progress=False
    )
    angle = rest.arm_angle.values[0].mean()
    moment = 0.1 * MOMENT + STIFFNESS * angle + 50.0 * MOMENT * (angle - stop)
    assert moment == pytest.approx(MOMENT * (math.cos(angle) + RISE / REACH * math.sin(angle)), rel=5e-3)
    assert stop < angle < 0.07


def test_newtons_matrix_is_the_derivative_of_the_residual_with_arms():
    """But for what it leaves out: treads' forces turn, which a light body feels most."""
    case = small_case(arms=arms_of(damping=1e4, mass=2e3, inertia=(100.0, 800.0, 800.0, 0.0, 0.0, 0.0)))
    check_matrix_at_rest(case, 18, 2e-3)


def test_a_leading_arm_is_lifted_the_other_way():
    """Arms of both kinds bear the same weight with the same springs."""
    leading = tuple(arm.with_(pivot=(x - REACH, RISE)) for arm, x in zip(arms_of(), ROLLERS, strict=True))
    trailing = on_floor(torque=0.8 * MOMENT)
    other = trailing.with_({"gear.arms": tuple(arm.with_(torque=0.8 * MOMENT) for arm in leading)})
    angles = [simulate(case, 2e-3, progress=False).arm_angle.values[0] for case in (trailing, other)]
    assert angles[1] == pytest.approx(-angles[0][::-1], rel=0.05)


def test_arms_of_two_tracks_are_bodies_in_the_order_of_their_names():
    rollers = Case.shovel().gear.rollers
    arms = tuple(
        Arm(
            roller=k,
            pivot=(rollers[k - 1] + 0.3, 0.1),
            mass=500.0,
            inertia=INERTIA,
            torque=1e5,
            stiffness=1e6,
        )
        for k in (1, 2)
    )
    case = Case.shovel().with_({"gear.arms": arms})
    layout = compiled_system(case).layout
    assert layout.bodies == case.gear.bodies
    assert layout.bodies[-4:] == ("right arm 1", "right arm 2", "left arm 1", "left arm 2")
    wheels = compiled_system(case).tables.forces.wheels
    last = len(layout.bodies) + layout.shoes
    carriers = {name: wheels.frames[k] for k, name in enumerate(case.gear.wheel_names)}
    assert carriers["right roller 2"] == last - 3
    assert carriers["left roller 1"] == last - 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"roller": 9}, r"gear.arms\[1\].roller must be in 1..7, got 9"),
        ({"roller": 1}, r"gear.arms\[1\].roller must be free, gear.arms\[0\] has roller 1"),
        ({"pivot": (0.0, 0.1), "roller": 4}, r"gear.arms\[1\].pivot must be behind or ahead of its roller"),
    ],
)
def test_arms_that_cannot_be_are_refused(changes, words):
    arms = [arm.with_(pivot=(9.0, 0.1)) for arm in arms_of()[:2]]
    with pytest.raises(ParameterError, match=words):
        Case.closed().with_({"gear.arms": (arms[0], arms[1].with_(changes))})
