"""A user's model on a track: known answers of the whole, and of its parts."""

import numpy as np
import pytest

from exudyn_crawler import add_track, restore_state, solve_dynamic, store_state
from exudyn_crawler.case import Part
from exudyn_crawler.coupled.rest import TENSOR, Mass
from exudyn_crawler.coupled.step import CoupledStep
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.exudyn import exu
from exudyn_crawler.results.balance import energy_balance
from exudyn_crawler.results.history import states
from tests.coupled.models import (
    STEP,
    add_box,
    add_hinge,
    add_pendulum,
    cuboid,
    model,
    settings,
    still_case,
    swing,
)
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

LENGTH = 3.0  # m, of the pendulum
HEIGHT = 5.0  # m, of its pivot above the car body
BOB = 1500.0  # kg, a hundredth of the frame's


def test_pendulum_swings_with_its_period_and_pulls_with_its_force():
    """On a frame that hardly yields: a hundred times as heavy, on rollers."""
    found = swing(still_case(), BOB, LENGTH, HEIGHT, 0.25)
    assert found.period == pytest.approx(found.known_period, rel=1e-3)
    lowest = slice(found.lowest, found.lowest + 2)
    assert found.pulls[lowest].max() == pytest.approx(found.known_pull, rel=2e-3)


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
            mbs.CreateGenericJoint(
                itemNumbers=[track.body, body], position=track.place(com), useGlobalFrame=True
            )
        mbs.Assemble()
        solve_dynamic(mbs, settings(case, 0.02))
        motions.append(track.block.state)
    (found, rates, _), (expected, expected_rates, _) = motions
    assert np.abs(expected_rates).max() > 1.0
    # small differences of the start's creep grow, as rollers pass over edges
    assert np.abs(found - expected).max() < 1e-8
    assert np.abs(rates - expected_rates).max() < 1e-6


def swinging(case):
    """A pendulum on a frame."""
    container, mbs = model()
    track = add_track(mbs, case, carried_mass=BOB, carried_com=(0.0, 0.0, HEIGHT))
    bob = add_pendulum(mbs, track, BOB, LENGTH, HEIGHT, 0.25)
    mbs.Assemble()
    return container, mbs, track, bob


@pytest.mark.parametrize("on_sand", [False, True])
def test_another_process_goes_on_bit_for_bit(on_sand):
    """Also on ground that remembers."""
    case = small_case().on_cells(BekkerSoil.lete_sand()) if on_sand else small_case()
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


def test_two_machines_pull_each_other_alike():
    """A spring between two frames that look at each other: the same state mirrored, equal forces."""
    case = still_case()
    _container, mbs = model()
    mirrored = {"position": [40.0, 0.0, 0.0], "heading": np.pi}
    tracks = [add_track(mbs, case), add_track(mbs, case, name="other", **mirrored)]
    hook = [1.0, 0.0, 0.5]
    length = np.linalg.norm(tracks[0].place(hook) - tracks[1].place(hook))
    pull = 2e5  # N
    spring = mbs.CreateSpringDamper(
        itemNumbers=[track.body for track in tracks],
        localPosition0=hook,
        localPosition1=hook,
        referenceLength=length - 0.5,
        stiffness=pull / 0.5,
        damping=1e4,
    )
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 0.05))
    one, other = (track.block for track in tracks)
    assert np.abs(one.state[0]).max() > 1e-3
    for found, expected in zip(one.state[:2], other.state[:2], strict=True):
        assert np.abs(found - expected).max() < 1e-9
    assert one.wrench == pytest.approx(other.wrench, rel=1e-6, abs=0.1)
    forces = [mbs.GetLoad(track.car.force)["loadVector"] for track in tracks]
    assert forces[0][0] == pytest.approx(-forces[1][0], rel=1e-6)
    # what is missing moves Exudyn's part of the car body
    force = mbs.GetObjectOutput(spring, exu.OutputVariableType.Force)
    assert -forces[0][0] == pytest.approx(force[0], rel=0.02)
    assert force[0] > 0.4 * pull


def test_falling_mass_gives_its_momentum_to_the_ground():
    """A mass falls onto a spring of the car body; impulses of ground and weight change the momentum."""
    case = still_case()
    _container, mbs = model()
    track = add_track(mbs, case)
    mass, height, radius = 10e3, 2.0, 0.1
    body = add_box(mbs, track, mass, [0.5, 0.0, height])
    mbs.CreateCartesianSpringDamper(
        itemNumbers=[track.body, body],
        localPosition0=[0.5, 0.0, height - radius],
        stiffness=[0.0, 0.0, 2e6],
        damping=[0.0, 0.0, 2e4],
    )
    mbs.Assemble()
    rows = []
    mbs.SetPostStepUserFunction(lambda *_: rows.append((track.history, speed(mbs, body)[2])) is None)
    solve_dynamic(mbs, settings(case, 0.06))
    carried = [row.dataset.isel(time=0) for row, _ in rows]
    forces = [row.contacts_by_shoe().contact_force.isel(time=0) for row, _ in rows]
    ground = np.array([one.sel(axis="z").sum() for one in forces])
    momentum = np.array(
        [
            case.gear.mass * at_com(one, case.gear.com)[2]
            + case.shoe.mass * one.velocity.sel(axis="z").sum()
            + mass * v
            for one, (_, v) in zip(carried, rows, strict=True)
        ]
    )
    weight = (case.gear.mass + case.track.shoe_count * case.shoe.mass + mass) * np.linalg.norm(track.gravity)
    given = STEP * (0.5 * (ground[1:] + ground[:-1]) - weight).sum()
    assert abs(momentum[-1] - momentum[0]) > 2e3
    assert momentum[-1] - momentum[0] == pytest.approx(given, rel=1e-3)


def speed(mbs, body):
    """Velocity of a body's origin."""
    return mbs.GetObjectOutputBody(body, exu.OutputVariableType.Velocity, [0.0, 0.0, 0.0])


def at_com(motion, com):
    """Velocity of the frame's COM by its motion in a history."""
    turn = rotation_matrices(motion.side_frame_angles.values[None])[0]
    return motion.side_frame_velocity.values + np.cross(motion.side_frame_angular_velocity.values, turn @ com)


def test_boom_that_slews_at_a_constant_rate_pulls_by_its_centripetal_force():
    """About a vertical axis; its weight and pull, and their moments, turn with it; no torque slews it."""
    case = still_case()
    _container, mbs = model()
    mass, arm, height, rate = 2e3, 4.0, 2.0, 1.0
    track = add_track(mbs, case, carried_mass=mass, carried_com=(arm, 0.0, height))
    up = track.axes.T @ [0.0, 0.0, 1.0]
    ahead = np.cross([0.0, 1.0, 0.0], up)
    about = track.at(arm * ahead + height * up)
    about["initialVelocity"] = about["initialVelocity"] + [0.0, arm * rate, 0.0]
    about["initialAngularVelocity"] = about["initialAngularVelocity"] + [0.0, 0.0, rate]
    boom = mbs.CreateRigidBody(inertia=cuboid(mass, 0.2), **about)
    add_hinge(mbs, track, [track.body, boom], height * up, up)
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 0.3))
    kind = exu.OutputVariableType
    place, spin = (mbs.GetObjectOutputBody(boom, k, [0, 0, 0]) for k in (kind.Position, kind.AngularVelocity))
    assert spin[2] == pytest.approx(rate, rel=5e-3)
    arms = place - mbs.GetObjectOutputBody(track.body, kind.Position, height * up)
    origin = mbs.GetObjectOutputBody(track.body, kind.Position, [0, 0, 0])
    assert np.arctan2(arms[1], arms[0]) == pytest.approx(0.3 * rate, rel=2e-3)
    pull = mass * (track.gravity + rate**2 * arms)
    # beside the weight of the car body's part that is Exudyn's
    own = mbs.GetObject(track.body)
    weight = own["mass"] * track.gravity
    center = mbs.GetObjectOutputBody(track.body, kind.Position, own["centerOfMass"])
    force, torque = np.split(track.block.wrench, 2)
    assert force - weight == pytest.approx(pull, abs=0.02 * np.linalg.norm(pull[:2]))
    moment = np.cross(place - origin, pull) + np.cross(center - origin, weight)
    assert torque == pytest.approx(moment, abs=1e-2 * mass * 9.81 * arm)


def test_energy_that_the_pendulum_loses_goes_into_the_track():
    """The imbalance of the track's energy is the change of that of the bodies on its frame."""
    case = small_case()
    _container, mbs = model()
    mass, height = 20e3, 4.0
    track = add_track(mbs, case, carried_mass=mass, carried_com=(0.0, 0.0, height))
    bob = add_pendulum(mbs, track, mass, LENGTH, height, 0.6)
    mbs.Assemble()
    rows, energies = [], []

    def energy():
        kind = exu.OutputVariableType
        asked = kind.Position, kind.AngularVelocity
        place, spin = (mbs.GetObjectOutputBody(bob, one, [0, 0, 0]) for one in asked)
        velocity = speed(mbs, bob)
        return 0.5 * mass * velocity @ velocity + mass / 12.0 * spin @ spin - mass * track.gravity @ place

    def store(*_):
        rows.append(track.block.system.state())
        energies.append(energy())
        return True

    mbs.SetPostStepUserFunction(store)
    solve_dynamic(mbs, settings(case, 0.2))
    balance = energy_balance(states.system_history(track.block.system, np.array(rows)))
    change = np.array(energies) - energies[0]
    assert np.abs(change).max() > 1e3
    # the balance of the track by itself closes as well
    assert np.abs(balance.imbalance.values - change).max() < 1e-3 * float(balance.frame_kinetic.max())
