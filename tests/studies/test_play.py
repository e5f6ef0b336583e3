"""Cases of the study of play."""

import pytest

from studies.play import JOINTS, MOTIONS


@pytest.mark.parametrize("name", MOTIONS)
def test_all_joints_are_cases_without_friction_of_pins(name):
    """Friction and play of pins exclude each other."""
    motion = MOTIONS[name]
    cases = {joints: JOINTS[joints](motion.make()) for joints in motion.joints}
    assert all(case.track.pin.is_ideal for case in cases.values())
    widths = {joints: case.gear.pin_play for joints, case in cases.items() if joints.startswith("play")}
    assert None not in widths.values()
    assert len({(play.radial, play.stiffness) for play in widths.values()}) == len(widths)
