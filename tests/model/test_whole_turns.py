"""Bodies that turn all round, upright and beyond, against closed forms: tables of hinged rigid bodies."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.rotations import rotation_matrices
from studies.mechanisms import STILL, Joint, Rigid, hinged, integrated

pytestmark = pytest.mark.simulation

BASE = Rigid(1.0, (1.0, 1.0, 1.0), held=True)


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
    q, q_t, *_ = integrated(hinged([Rigid(4500.0, (across, along, across))], []), start, STILL, h, steps)
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
    bodies = [BASE, Rigid(mass, (300.0, inertia, 700.0))]
    tables = hinged(bodies, [Joint(0, 1, STILL, (0.0, 0.0, arm))])
    q, q_t, force, _ = integrated(tables, start, (0.0, 0.0, -g), time / steps, steps)
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
    joints = [Joint(0, 1, STILL, rear), Joint(1, 2, front, rear), Joint(2, 3, front, rear)]
    tables = hinged([BASE, *[Rigid(mass, (500.0, 200.0, 600.0))] * 3], joints)
    turn, steps = 2.0 * np.pi / omega, 2000
    q, _, force, _ = integrated(tables, start, STILL, turn / steps, steps)
    np.testing.assert_allclose(q[-1, 1:, 4], 2.0 * np.pi, rtol=1e-4)
    reach = np.hypot(q[:, 1:, 0], q[:, 1:, 2])
    np.testing.assert_allclose(reach, np.broadcast_to(middle, reach.shape), atol=1e-6)
    expected = mass * omega**2 * np.cumsum(middle[::-1])[::-1]
    np.testing.assert_allclose(np.linalg.norm(force[-1, :, :3], axis=1), expected, rtol=1e-4)


def test_angles_come_back_from_their_rotations():
    random = np.random.default_rng(7)
    angles = random.uniform(-1.0, 1.0, (50, 3)) * (1.5, np.pi, np.pi)
    np.testing.assert_allclose(rotations.angles_of(rotation_matrices(angles)), angles, atol=1e-12)
