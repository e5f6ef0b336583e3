"""Bodies that turn all round, upright and beyond, against closed forms: tables of hinged rigid bodies."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.packed import nothing, pack
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.bodies import Bodies, second_moment
from exudyn_crawler.model.elimination import fronts_of
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.joints.drive import Speeds
from exudyn_crawler.model.joints.hold import Held
from exudyn_crawler.model.joints.pin import ROWS, Pins
from exudyn_crawler.model.kinds import Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.newton import Limits, step
from exudyn_crawler.model.tables import SYSTEM, FrontRows, Search, System, Tables, Workspace

pytestmark = pytest.mark.simulation

RADIUS = 0.9
"""Spectral radius of the integration."""
STILL = (0.0, 0.0, 0.0)


def hinged(masses, inertias, pins, held=()):
    """Rigid bodies in a row without ground; `pins` are the places of each in the bodies behind and ahead.

    All coordinates of the `held` bodies are held.
    """
    count = len(masses)
    joined = [(k, k + 1) for k in range(len(pins))]
    size, first, rigid = 6 * count, 6 * np.arange(count), np.full(count, -1)
    holds = [(b, k) for b in held for k in range(6)]
    first_row = ROWS * len(pins)
    rows = np.arange(first_row + 2 + len(holds))
    bodies = np.array([0, *(b for pair in joined for b in pair)])
    places = np.array([STILL, *(place for pair in pins for place in pair)])
    unbent = np.zeros((len(places), 3, 0))
    moments = [second_moment(m, np.diag(i), np.zeros(3)) for m, i in zip(masses, inertias, strict=True)]
    masses = np.array(masses, dtype=float), np.zeros((count, 3)), np.array(moments)
    ends = np.arange(1, len(bodies)).reshape(-1, 2)
    held = np.array(holds, dtype=np.int64).reshape(-1, 2)
    no_compliance = np.zeros((len(pins), ROWS))
    unknowns, last = list(range(size)), (size + rows).tolist()
    of_bodies, of_rows = np.array([first, rigid]), np.array([size + rows, rows])
    return nothing(Tables)._replace(
        bodies=Bodies(first, rigid, np.zeros((count, 6)), *masses, np.zeros((count, 2, 3))),
        markers=Markers(bodies, places, unbent, unbent, np.zeros(len(bodies), dtype=np.int64)),
        joints=nothing(Joints)._replace(
            pins=Pins(0, ends, no_compliance, no_compliance, in_plane=False, follows=False),
            drive=Speeds(first_row, marker=0, turning=0),
            holds=Held(first_row + 2, held),
        ),
        multipliers=len(rows),
        search=Search(0.0, 0.0, 0),
        fronts=fronts_of([unknowns, last], [[*unknowns, *last]]),
        rows=FrontRows(of_bodies, np.zeros(count, dtype=np.int64), np.array([size, 0]), of_rows),
    )


def integrated(tables, start, gravity, h, steps):
    """Coordinates, rates (steps + 1, bodies, 6) and multipliers of pins (steps + 1, pins, ROWS).

    `start` are coordinates, rates and accelerations (3, bodies, 6).
    """
    state, multipliers = np.reshape(start, (3, -1)).copy(), np.zeros(tables.multipliers)
    system = System(tables, Workspace.allocate(tables, 1, nothing(ShoePoints)))
    block = pack(system, SYSTEM)
    inputs = Inputs(tuple(gravity), np.zeros((0, 6)), 0.0, np.zeros(2), np.zeros(2))
    scratch = np.zeros(state.shape[1] + len(multipliers)), np.zeros(tables.fronts.size)
    # generalized alpha (Arnold and Bruels, Multibody System Dynamics 18, 2007)
    alpha_m, alpha_f = (2.0 * RADIUS - 1.0) / (RADIUS + 1.0), RADIUS / (RADIUS + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    by_acceleration = (1.0 - alpha_m) / ((1.0 - alpha_f) * beta * h * h)
    weights = Weights(1.0, gamma / (h * beta), by_acceleration, False, beta * h / gamma)
    algorithmic, pins = state[2].copy(), tables.joints.drive.first
    found = [(*state[:2].copy(), multipliers[:pins].copy())]
    for _ in range(steps):
        before = algorithmic
        algorithmic = (alpha_f * state[2] - alpha_m * before) / (1.0 - alpha_m)
        state[0] += h * state[1] + h * h * ((0.5 - beta) * before + beta * algorithmic)
        state[1] += h * ((1.0 - gamma) * before + gamma * algorithmic)
        state[2] = 0.0
        converged, *_ = step(block, state, multipliers, inputs, weights, Limits(1e-6, 50, False), scratch)
        assert converged
        algorithmic = algorithmic + (1.0 - alpha_f) / (1.0 - alpha_m) * state[2]
        found.append((*state[:2].copy(), multipliers[:pins].copy()))
    q, q_t, forces = map(np.array, zip(*found, strict=True))
    return q.reshape(steps + 1, -1, 6), q_t.reshape(steps + 1, -1, 6), forces.reshape(steps + 1, -1, ROWS)


def test_a_free_top_precesses_as_in_the_closed_form_through_turns_of_pitch():
    """Torque-free symmetric top (Goldstein, Classical Mechanics, 5.6): its axis y goes round the momentum."""
    across, along = 3000.0, 5200.0
    angles = np.array([0.2, 0.0, 0.3])
    axes = rotation_matrices(angles)
    inertia = axes @ np.diag((across, along, across)) @ axes.T
    omega = axes @ (0.5, 4.0, 0.0)
    momentum, rates = inertia @ omega, rotations.angle_rates(angles, omega)
    # Euler's equations: what turns the momentum in the body's axes turns them back
    alpha = np.linalg.solve(inertia, -np.cross(omega, momentum))
    turning = angles, rates, rotations.angle_accelerations(angles, rates, alpha)
    start = [[*STILL, *one] for one in turning]
    h, steps = 1e-3, 4000
    q, q_t, _ = integrated(hinged([4500.0], [(across, along, across)], []), start, STILL, h, steps)
    time = h * np.arange(steps + 1)
    # the axis turns about the momentum, the body about its axis besides
    precession = Rotation.from_rotvec(time[:, None] * momentum / across)
    spin = 4.0 * (1.0 - along / across)
    turned = Rotation.from_rotvec(np.outer(spin * time, [0, 1, 0])).as_matrix()
    expected = precession.as_matrix() @ axes @ turned
    assert np.ptp(q[:, 0, 4]) > 2.0 * 2.0 * np.pi
    np.testing.assert_allclose(rotation_matrices(q[:, 0, 3:]), expected, atol=2e-4)
    found = rotations.angular_velocity(q[:, 0, 3:], q_t[:, 0, 3:])
    np.testing.assert_allclose(np.einsum("tji,tj->ti", expected, found)[:, 1], 4.0, rtol=1e-4)


def test_a_hinged_body_swings_all_round_in_the_time_of_the_pendulum():
    """Time of a whole turn by the elliptic integral; forces at the pin at the bottom by centrifugal force."""
    mass, inertia, arm, g = 4500.0, 900.0, 0.4, 9.81
    about_pin = inertia + mass * arm**2
    fastest = 1.3 * np.sqrt(4.0 * mass * g * arm / about_pin)
    time = 4.0 / fastest * ellipk(4.0 * mass * g * arm / (about_pin * fastest**2))
    steps = 2000
    start = np.zeros((3, 2, 6))
    start[0, 1, 2], start[2, 1, 2] = -arm, arm * fastest**2
    start[1, 1, [0, 4]] = -arm * fastest, fastest
    inertias = [(1.0, 1.0, 1.0), (300.0, inertia, 700.0)]
    tables = hinged([1.0, mass], inertias, [(STILL, (0.0, 0.0, arm))], held=[0])
    q, q_t, force = integrated(tables, start, (0.0, 0.0, -g), time / steps, steps)
    pitch = q[:, 1, 4]
    assert pitch[-1] == pytest.approx(2.0 * np.pi, rel=1e-4)
    assert q_t[-1, 1, 4] == pytest.approx(fastest, rel=1e-4)
    energy = 0.5 * about_pin * q_t[:, 1, 4] ** 2 - mass * g * arm * np.cos(pitch)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)
    assert abs(force[-1, 0, 2]) == pytest.approx(mass * (g + arm * fastest**2), rel=1e-3)


def test_a_straight_chain_goes_round_as_one():
    """Three links turn evenly about a held pin, upside down too: each pin pulls what is beyond it inwards."""
    mass, length, omega = 4500.0, 0.67, 3.0
    middle = length * (np.arange(3) + 0.5)
    start = np.zeros((3, 4, 6))
    start[0, 1:, 0], start[1, 1:, 2], start[2, 1:, 0] = middle, -omega * middle, -(omega**2) * middle
    start[1, 1:, 4] = omega
    rear, front = (-0.5 * length, 0.0, 0.0), (0.5 * length, 0.0, 0.0)
    pins = [(STILL, rear), (front, rear), (front, rear)]
    tables = hinged([1.0, *[mass] * 3], [(500.0, 200.0, 600.0)] * 4, pins, held=[0])
    turn, steps = 2.0 * np.pi / omega, 2000
    q, _, force = integrated(tables, start, STILL, turn / steps, steps)
    np.testing.assert_allclose(q[-1, 1:, 4], 2.0 * np.pi, rtol=1e-4)
    reach = np.hypot(q[:, 1:, 0], q[:, 1:, 2])
    np.testing.assert_allclose(reach, np.broadcast_to(middle, reach.shape), atol=1e-6)
    expected = mass * omega**2 * np.cumsum(middle[::-1])[::-1]
    np.testing.assert_allclose(np.linalg.norm(force[-1, :, :3], axis=1), expected, rtol=1e-4)


def test_angles_come_back_from_their_rotations():
    random = np.random.default_rng(7)
    angles = random.uniform(-1.0, 1.0, (50, 3)) * (1.5, np.pi, np.pi)
    np.testing.assert_allclose(rotations.angles_of(rotation_matrices(angles)), angles, atol=1e-12)
