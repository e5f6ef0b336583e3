"""Force and moment of a shovel on the side frame of one track."""

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.case import MachineCycle, Undercarriage, ph4100c
from exudyn_crawler.case.parameters.undercarriage import MachinePhase, Pose
from exudyn_crawler.errors import ParameterError

FRAME = Undercarriage.ph4100c()
DOWN = np.array([0.0, 0.0, -1.0])
NOTHING = (0.0, 0.0, 0.0)
SHOVEL, PAYLOAD = ph4100c.SHOVEL, 9e4
WHOLE = SHOVEL["mass"] + PAYLOAD
LEVER = (SHOVEL["front"] + PAYLOAD) * 15.0 + SHOVEL["upper"] * SHOVEL["upper_place"][0]
"""kg m, by hand: payload and front at 15 m to the one side, the upper structure 2.5 m to the other."""


def pose(swing, payload=PAYLOAD):
    return Pose(f"at {swing:g}", 1.0, swing, 15.0, 5.0, payload)


def resultant(swing, side=1.0):
    """Vertical force on the frame (N, downward) with its weight, and x and y where it acts, m."""
    (phase,) = MachineCycle.shovel(poses=[pose(swing)], side=side).phases
    weight = FRAME.mass * ph4100c.GRAVITY * DOWN
    force, moment = np.array(phase.force) + weight, np.array(phase.moment) + np.cross(FRAME.com, weight)
    return -force[2], moment[1] / -force[2], -moment[0] / -force[2]


@pytest.mark.parametrize("swing", [0.7, np.pi / 2])
def test_both_tracks_carry_the_whole(swing):
    carried = resultant(swing)[0] + resultant(swing, side=-1.0)[0]
    assert carried == pytest.approx(WHOLE * ph4100c.GRAVITY)


def test_shares_are_those_of_statics():
    share = 0.5 * WHOLE + LEVER / ph4100c.TRACK_DISTANCE
    assert resultant(np.pi / 2)[0] == pytest.approx(share * ph4100c.GRAVITY)


def test_straight_ahead_the_weight_moves_ahead_and_the_tracks_share_alike():
    carried, x, y = resultant(0.0)
    assert carried == pytest.approx(0.5 * WHOLE * ph4100c.GRAVITY)
    assert x == pytest.approx(LEVER / WHOLE)
    assert y == pytest.approx(0.0, abs=1e-9)


def test_papers_machine_can_stand():
    case = Case.rolled().with_(machine=MachineCycle.shovel())
    force, moment = case.machine_wrench(np.linspace(0.0, 40.0, 9))
    assert force.shape == moment.shape == (9, 3)
    assert np.ptp(force[:, 2]) > 1e6


def test_wrench_is_joined_by_steps():
    cycle = MachineCycle(
        phases=(
            MachinePhase(name="a", end=0.0, force=NOTHING, moment=NOTHING),
            MachinePhase(name="b", end=2.0, force=(0.0, 0.0, -4.0), moment=(0.0, 8.0, 0.0)),
        )
    )
    force, moment = cycle.wrench([0.0, 1.0, 5.0])
    np.testing.assert_allclose(force[:, 2], [0.0, -2.0, -4.0])
    np.testing.assert_allclose(moment[:, 1], [0.0, 4.0, 8.0])


def test_machine_that_tips_over_a_track_and_times_that_do_not_increase_are_refused():
    with pytest.raises(ValueError, match="the machine tips sideways at the end of"):
        MachineCycle.shovel(poses=[pose(np.pi / 2, payload=1e6)])
    with pytest.raises(ParameterError, match="the phases' ends must increase"):
        MachineCycle.shovel(poses=[pose(0.0, payload=0.0), pose(0.1, payload=0.0)])


@pytest.mark.parametrize(
    ("force", "moment", "said"),
    [
        ((0.0, 0.0, 7e6), NOTHING, "it lifts the side frame"),
        (
            NOTHING,
            (0.0, 3e7, 0.0),
            "it tips: its weight acts at x = .* m, rollers are from -4.375 to 4.375 m",
        ),
        (NOTHING, (3e6, 0.0, 0.0), "the side frame tips"),
    ],
)
def test_cycles_in_which_a_roller_would_pull_are_refused(force, moment, said):
    phase = MachinePhase(name="wrong", end=1.0, force=force, moment=moment)
    with pytest.raises(ParameterError, match=said):
        Case.rolled().with_(machine=MachineCycle(phases=(phase,)))


def test_machine_without_a_frame_is_refused():
    with pytest.raises(ParameterError, match="machine must be None without an undercarriage"):
        Case.translation().with_(machine=MachineCycle.shovel())
