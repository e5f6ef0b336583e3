"""Spheres under a shoe: where they stand, and what pushes them over a seam."""

import numpy as np
import pytest

from exudyn_crawler import Case, SphereContact
from exudyn_crawler.case import Heights
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.ground.sphere_contact import face_inset, sphere_centers
from tests.model.both import sphere_wrenches

SPHERES = SphereContact.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)
FOUR = Case.translation().with_(contact=SPHERES.with_(spheres_x=2, spheres_y=2))
DRAWN_BACK = FOUR.with_(contact=FOUR.contact.with_(faces="drawn_back"))


def test_spheres_stand_evenly_inside_the_underside():
    places = sphere_centers(CASE)
    low_x, high_x, low_y, high_y, z = CASE.shoe.footprint
    assert len(places) == 20
    assert places.mean(axis=0)[:2] == pytest.approx(
        [0.5 * (low_x + high_x), 0.5 * (low_y + high_y)], abs=1e-12
    )
    assert places[:, 0].min() - low_x == pytest.approx(CASE.shoe.length / 8.0, rel=1e-12)
    assert places[:, 1].max() - high_y == pytest.approx(-3.505 / 10.0, rel=1e-12)
    assert places[:, 2] == pytest.approx(z + SPHERES.radius)


def test_spheres_are_as_deep_as_the_faces_of_a_relief_let_them():
    hills = Heights(slope_x=0.1, level=-1.4)
    case = CASE.with_(terrain=CASE.terrain.with_(relief=hills, tilt="pitch"))
    contact = ground_contact(case)
    places = contact.shoe_reference[:, None, :3] + sphere_centers(case)
    above = (places[..., 2] - 0.1 * places[..., 0] + 1.4) / np.hypot(1.0, 0.1)
    q = np.zeros(contact.size)
    assert contact.depths(q) == pytest.approx(SPHERES.radius - above, abs=1e-12)
    assert contact.sunken(q) == (np.flatnonzero((above < 0.0).any(axis=1)) + 1).tolist()


def lift_over_seam(case: Case, beside: float) -> float:
    """Vertical force on rear spheres beside the seam at x = 7 m by so much (m), over that far from any seam.

    The front ones stand on one face both times.
    """
    rear = sphere_centers(case)[0, 0] + case.track.com_positions(case.shoe.com_height)[0, 0]

    def lift(x):
        q = np.zeros(6 * (case.track.shoe_count + case.terrain.unit_count))
        q[0], q[2] = x - rear, -case.settled_penetration
        return float(sphere_wrenches(case, q)[0, 2])

    return lift(7.0 + beside) / (0.5 * lift(3.5)) - 1.0


def test_whole_faces_both_push_a_sphere_beside_their_seam():
    """At the seam itself both faces' points are one, which Exudyn takes once."""
    assert face_inset(FOUR) == (0.0, 0.0)
    assert lift_over_seam(FOUR, 0.0) == pytest.approx(1.0, rel=1e-9)
    assert lift_over_seam(FOUR, 1e-6) == pytest.approx(2.0, rel=1e-9)


def test_drawn_back_faces_push_over_the_seam_as_hard_as_one():
    assert lift_over_seam(DRAWN_BACK, 0.0) == pytest.approx(1.0, rel=1e-9)
    beside = np.array([lift_over_seam(DRAWN_BACK, x) for x in np.linspace(-0.1, 0.1, 21)])
    assert beside == pytest.approx(1.0, abs=0.1)
    assert np.ptp(beside) > 0.01
