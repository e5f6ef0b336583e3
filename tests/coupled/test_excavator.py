"""A pendulum on an excavator on sand: two closed tracks with a hundred shoes."""

import pytest

from exudyn_crawler import StepProfile, add_track, read_case, solve_dynamic
from tests.coupled.models import model, settings, swing

pytestmark = [pytest.mark.simulation, pytest.mark.slow]

LENGTH, HEIGHT, BOB = 3.0, 5.0, 1500.0  # m, m, kg


@pytest.fixture(scope="module")
def excavator(tmp_path_factory):
    """Machine of the library whose drive stands still."""
    path = tmp_path_factory.mktemp("excavator") / "excavator.toml"
    path.write_text('name = "excavator"\nduration = 1.0\n\n[datasheet]\nbase = "pc300lc"\n')
    case = read_case(path).case
    return case.with_(drive=case.drive.with_(speed=StepProfile.constant(0.0)))


def test_pendulum_on_an_excavator_takes_the_iterations_of_the_machine_alone(excavator):
    found = swing(excavator, BOB, LENGTH, HEIGHT, 0.2)
    assert found.period == pytest.approx(found.known_period, rel=1e-3)
    assert found.pulls.max() == pytest.approx(found.known_pull, rel=1e-3)
    assert found.track.block.iterations < 1.1 * found.steps


def test_motors_have_the_commanded_torques_then_the_commanded_speeds(excavator):
    _container, mbs = model()
    track = add_track(mbs, excavator)
    mbs.Assemble()
    track.set_torques([9e3, -6e3])
    solve_dynamic(mbs, settings(excavator, 0.05))
    torques = track.history.drive_moment.isel(time=0)
    assert torques.values == pytest.approx([9e3, -6e3], rel=1e-6)
    # the right track drives forward, the left one backward: a turn to the left
    assert track.history.side_frame_angular_velocity.sel(axis="z").item() > 1e-3
    track.set_speeds([0.2, 0.2])
    solve_dynamic(mbs, settings(excavator, 0.3, 0.05))
    speeds = track.history.tumbler_speed.isel(time=0).values
    chain = excavator.track
    assert speeds == pytest.approx(0.2 / excavator.gear.travel_per_angle(chain), rel=0.05)
    assert track.history.side_frame_velocity.sel(axis="x").item() == pytest.approx(0.2, rel=0.2)
