"""A pendulum on an excavator on sand: two closed tracks with a hundred shoes."""

import numpy as np
import pytest

from exudyn_crawler import StepProfile, add_track, read_case, solve_dynamic
from exudyn_crawler.model.exudyn import items
from tests.coupled.models import add_pendulum, add_sensor, model, settings

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
    case = excavator
    _container, mbs = model()
    track = add_track(mbs, case, carried_mass=BOB, carried_com=(0.0, 0.0, HEIGHT))
    bob = add_pendulum(mbs, track, BOB, LENGTH, HEIGHT, 0.2)
    angles = add_sensor(mbs, bob, "Rotation")
    load = mbs.AddSensor(items.SensorLoad(loadNumber=track.car.force, storeInternal=True))
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 1.0))
    time, _, swing, _ = mbs.GetSensorStoredData(angles).T
    k = int(np.flatnonzero(np.diff(np.sign(swing)))[0])
    quarter = time[k] - swing[k] * (time[k + 1] - time[k]) / (swing[k + 1] - swing[k])
    angle = abs(swing[0])
    gravity = np.linalg.norm(track.gravity)
    radius = LENGTH + 1.0 / (6.0 * LENGTH)
    period = 2.0 * np.pi * np.sqrt(radius / gravity) * (1.0 + angle**2 / 16.0 + 11.0 * angle**4 / 3072.0)
    assert 4.0 * quarter == pytest.approx(period, rel=1e-3)
    own = mbs.GetObject(track.body)["mass"] * gravity
    pull = mbs.GetSensorStoredData(load)[:, 3].max() - own
    lowest = BOB * gravity + BOB * LENGTH * 2.0 * gravity * (1.0 - np.cos(angle)) / radius
    assert pull == pytest.approx(lowest, rel=1e-3)
    steps = len(time) - 1
    assert track.block.iterations < 1.1 * steps


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
