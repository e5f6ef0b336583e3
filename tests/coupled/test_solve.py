"""A user's model on a track: known answers of the whole, and of its parts."""

import numpy as np
import pytest

from exudyn_crawler import add_track, restore_state, solve_dynamic, store_state
from exudyn_crawler.case import Part
from exudyn_crawler.coupled.rest import TENSOR, Mass
from exudyn_crawler.coupled.step import CoupledStep
from exudyn_crawler.model.exudyn import exu, items
from tests.coupled.models import (
    STEP,
    add_box,
    add_hinge,
    add_pendulum,
    add_sensor,
    model,
    settings,
    still_case,
)
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

LENGTH = 3.0  # m, of the pendulum
HEIGHT = 5.0  # m, of its pivot above the car body
BOB = 1500.0  # kg, a hundredth of the frame's


def test_pendulum_swings_with_its_period_and_pulls_with_its_force():
    """On a frame that hardly yields: a hundred times as heavy, on rollers."""
    case = still_case()
    _container, mbs = model()
    track = add_track(mbs, case, carried_mass=BOB, carried_com=(0.0, 0.0, HEIGHT))
    bob = add_pendulum(mbs, track, BOB, LENGTH, HEIGHT, 0.25)
    angles = add_sensor(mbs, bob, "Rotation")
    load = mbs.AddSensor(items.SensorLoad(loadNumber=track.car.force, storeInternal=True))
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 1.0))
    time, _, swing, _ = mbs.GetSensorStoredData(angles).T
    k = int(np.flatnonzero(np.diff(np.sign(swing)))[0])
    quarter = time[k] - swing[k] * (time[k + 1] - time[k]) / (swing[k + 1] - swing[k])
    angle = abs(swing[0])
    gravity = np.linalg.norm(track.gravity)
    radius = LENGTH + 1.0 / (6.0 * LENGTH)  # a cube of 1 m
    period = 2.0 * np.pi * np.sqrt(radius / gravity) * (1.0 + angle**2 / 16.0 + 11.0 * angle**4 / 3072.0)
    assert 4.0 * quarter == pytest.approx(period, rel=1e-3)
    # the support of the frame's Exudyn body, less its own weight
    own = mbs.GetObject(track.body)["mass"] * gravity
    pull = mbs.GetSensorStoredData(load)[k : k + 2, 3].max() - own
    lowest = BOB * gravity + BOB * LENGTH * 2.0 * gravity * (1.0 - np.cos(angle)) / radius
    assert pull == pytest.approx(lowest, rel=2e-3)


def test_upper_structure_is_the_same_as_mass_and_as_a_body_locked_to_the_car_body():
    case = small_case()
    case = case.with_(solver=case.solver.with_(residual=1e-5))
    mass, side, com = 20e3, 1e-3, np.array([0.4, 0.2, 2.0])
    own = mass * side**2 / 6.0 * np.eye(3)
    whole = Mass.of([case.gear.frame, Part(mass, com, own)])
    middle = whole.first / whole.mass
    inertia = whole._replace(second=whole.second - whole.mass * np.outer(middle, middle)).inertia
    changes = {"mass": whole.mass, "com": tuple(middle), "inertia": tuple(inertia[k] for k in TENSOR)}
    one = case.with_({f"gear.{name}": value for name, value in changes.items()})
    motions = []
    for given, carried in ((one, 0.0), (case, mass)):
        _container, mbs = model()
        track = add_track(mbs, given, carried_mass=carried, carried_com=com)
        if carried:
            body = add_box(mbs, track, mass, com, side)
            mbs.CreateGenericJoint(itemNumbers=[track.body, body], position=track.place(com), useGlobalFrame=True)
        mbs.Assemble()
        solve_dynamic(mbs, settings(case, 0.1))
        motions.append(track.block.state)
    for found, expected in zip(*motions, strict=True):
        print(np.abs(found - expected).max() , np.abs(expected).max())
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def swinging(case):
    """A pendulum on a frame."""
    container, mbs = model()
    track = add_track(mbs, case, carried_mass=BOB, carried_com=(0.0, 0.0, HEIGHT))
    bob = add_pendulum(mbs, track, BOB, LENGTH, HEIGHT, 0.25)
    mbs.Assemble()
    return container, mbs, track, bob


def test_another_process_goes_on_bit_for_bit():
    case = small_case()
    ends = []
    _one, first, *_ = swinging(case)
    solve_dynamic(first, settings(case, 0.02))
    stored = {name: values.copy() for name, values in store_state(first).items()}
    for mbs in (first, swinging(case)[1]):
        restore_state(mbs, stored) if mbs is not first else None
        solve_dynamic(mbs, settings(case, 0.05, 0.02))
        ends.append(store_state(mbs))
    assert ends[0].keys() == ends[1].keys()
    for name, values in ends[0].items():
        np.testing.assert_array_equal(values, ends[1][name], err_msg=name)


def test_step_that_failed_is_tried_again_and_no_controller_is_called_twice(monkeypatch):
    """As if Newton's method had failed once; the run then has two half steps in place of one."""
    case = small_case()
    solve = CoupledStep._solve
    calls, tries = [], []

    def failing(self):
        tries.append(self)
        return len(tries) != 4 and solve(self)

    runs = []
    for fails in (False, True):
        container, mbs, track, bob = swinging(case)
        mbs.SetPreStepUserFunction(lambda _mbs, time: calls.append(time) is None)
        if fails:
            calls.clear()
            monkeypatch.setattr(CoupledStep, "_solve", failing)
        solve_dynamic(mbs, settings(case, 0.02))
        position = mbs.GetObjectOutputBody(bob, exu.OutputVariableType.Position, [0, 0, 0])
        runs.append((position, track.history.position.values))
        del container
    steps = round(0.02 / STEP)
    assert len(tries) == steps + 2
    assert np.unique(calls).size == len(calls) == steps + 1
    for found, expected in zip(*runs, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-6)
        assert np.abs(found - expected).max() > 0.0
