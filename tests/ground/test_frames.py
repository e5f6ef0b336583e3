"""Contact on frames: blind to the global axes, in any attitude; coordinates to frames."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exudyn_crawler import PairContact
from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.contact import pair_law
from exudyn_crawler.ground.frames import Frame, turned, velocity_at
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pairs import (
    FROM_CURVE,
    RIGID,
    Footprint,
    Patch,
    Volume,
    pair_contact,
    pair_overlap,
)
from exudyn_crawler.ground.rotations import angular_velocity, attitude, rotation_matrices

FOOTPRINT = Footprint(-0.33, 0.32, -1.7, 1.8, -0.2)
HALF = (3.5, 3.5, 1.0)
CONTACTS = {name: PairContact.oil_sand(sharing=name) for name in ("pair", "area")} | {
    "leaning": PairContact.adams(),
    "leaning, closest points": PairContact.adams().with_(penetration="closest"),
}
LAWS = {name: pair_law(contact, 2.3) for name, contact in CONTACTS.items()}
SEEDS = range(12)
"""Every third turns the pair by a quarter about y, where the angles about x, y, z are singular."""


def frame(r, R, v, omega) -> Frame:
    return Frame(tuple(r), tuple(map(tuple, R)), tuple(v), tuple(omega))


def meeting(random) -> tuple[Frame, Frame]:
    """Shoe on a unit, both nearly level and moving."""
    shoe, unit = (Rotation.from_rotvec(random.normal(0.0, 0.01, 3)).as_matrix() for _ in range(2))
    place = np.array([random.uniform(-3.6, 3.6), random.uniform(-3.0, 3.0), 1.2 - random.uniform(0.06, 0.09)])
    return (
        frame(place, shoe, random.normal(0.0, 0.03, 3), random.normal(0.0, 0.03, 3)),
        frame(random.normal(0.0, 0.01, 3), unit, random.normal(0.0, 0.03, 3), random.normal(0.0, 0.01, 3)),
    )


def carried_off(body: Frame, R, r, v, omega) -> Frame:
    """Same body in a world that is turned, moved and in motion as a whole."""
    arm = R @ body.r
    return frame(r + arm, R @ body.R, R @ body.v + v + np.cross(omega, arm), R @ body.omega + omega)


def journey(seed, random):
    """Turn, displacement, velocity and spin of the whole: turns beyond 90 degrees among them."""
    R = Rotation.random(random_state=seed).as_matrix()
    if seed % 3 == 0:
        R = Rotation.from_euler("y", 90.0, degrees=True).as_matrix()
    return R, random.normal(0.0, 50.0, 3), random.normal(0.0, 1.0, 3), random.normal(0.0, 0.5, 3)


def touched(shoe, unit, law, patch):
    part = pair_overlap(shoe, unit, FOOTPRINT, HALF, overlap_workspace())
    return pair_contact(Volume(part, 1.0, FOOTPRINT, HALF), shoe, unit, patch, law, FROM_CURVE)


def bent(random) -> Patch:
    """Patch that moves by fractions of a millimetre and some mm/s."""
    return Patch(tuple(random.normal(0.0, 3e-4, 3)), tuple(random.normal(0.0, 5e-3, 3)))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_contact_in_a_turned_and_moving_world_is_the_same_turned(seed, law):
    random = np.random.default_rng(seed)
    pair, patch = meeting(random), bent(random)
    R, r, v, omega = journey(seed, random)
    here = touched(*pair, law, patch)
    there = touched(*(carried_off(body, R, r, v, omega) for body in pair), law, patch)
    assert here.area > 0.0
    assert np.linalg.norm(here.normal_force) > 1e3
    assert there[:3] == pytest.approx(here[:3], rel=1e-9, abs=1e-12)
    assert np.array(there.point) == pytest.approx(r + R @ here.point, abs=1e-11)
    most = 1e-9 * np.linalg.norm(here.normal_force)
    for name in ("normal_force", "friction_force", "friction_torque"):
        assert np.array(getattr(there, name)) == pytest.approx(R @ getattr(here, name), abs=most)
    assert np.array(there.slip_velocity) == pytest.approx(R @ here.slip_velocity, abs=1e-12)


@pytest.mark.parametrize("law", ["pair", "leaning", "leaning, closest points"])
@pytest.mark.parametrize("seed", SEEDS)
def test_bodies_that_move_as_one_neither_slip_nor_sink(seed, law):
    random = np.random.default_rng(seed)
    R, r, v, omega = journey(seed, random)
    still = [body._replace(v=(0.0, 0.0, 0.0), omega=(0.0, 0.0, 0.0)) for body in meeting(random)]
    contact = touched(*(carried_off(b, R, r, v, omega) for b in still), LAWS[law], RIGID)
    assert np.linalg.norm(contact.normal_force) > 1e3
    assert np.linalg.norm(contact.slip_velocity) < 1e-12
    assert abs(contact.penetration_rate) < 1e-12


ANGLES = np.random.default_rng(2).uniform(-math.pi, math.pi, (8, 3))


@pytest.mark.parametrize("angles", ANGLES)
def test_angles_are_yaw_roll_pitch(angles):
    at = attitude(*angles)
    expected = Rotation.from_euler("ZXY", angles[[2, 0, 1]]).as_matrix()
    assert np.array(at.R) == pytest.approx(expected, abs=1e-14)
    assert rotation_matrices(angles[None])[0] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("angles", ANGLES)
def test_frames_move_with_their_coordinates(angles):
    random = np.random.default_rng(7)
    q, q_t = np.concatenate((random.normal(size=3), angles)), random.normal(size=6)
    body = rotations.shoe_frame(q, q_t, attitude(*angles))
    assert np.array(body.omega) == pytest.approx(angular_velocity(angles, q_t[3:]), abs=1e-14)
    own = np.array([0.3, -0.2, 0.5])
    step = 1e-6
    moved = [q + sign * step * q_t for sign in (1.0, -1.0)]
    ahead, behind = (one[:3] + rotation_matrices(one[None, 3:])[0] @ own for one in moved)
    place = tuple(np.add(body.r, turned(body.R, tuple(own))))
    # central differences of second order
    assert np.array(velocity_at(body, place)) == pytest.approx((ahead - behind) / (2.0 * step), abs=1e-8)


@pytest.mark.parametrize("angles", ANGLES)
def test_generalized_moments_do_the_work_of_the_moment(angles):
    random = np.random.default_rng(8)
    rates, moment = random.normal(size=3), random.normal(size=3)
    parts = rotations.moments_on_angles(angles[None], moment[None])[0]
    assert np.dot(parts, rates) == pytest.approx(moment @ angular_velocity(angles, rates), abs=1e-14)
    again = rotations.moments_of(angles[None], np.array([parts]))[0]
    assert again == pytest.approx(moment, abs=1e-12 / abs(math.cos(angles[1])))


@pytest.mark.parametrize("axis", [0, 1])
def test_a_unit_is_a_body_with_one_angle(axis):
    q, q_t = np.array([1.0, 2.0, -1.0, 0.3]), np.array([0.1, 0.2, 0.3, 0.4])
    unit = rotations.unit_frame(q, q_t, axis)
    assert np.array(unit.R) == pytest.approx(np.array(attitude(*(0.3 * np.eye(3)[axis])).R), abs=1e-15)
    assert unit.omega == tuple(0.4 * np.eye(3)[axis])
