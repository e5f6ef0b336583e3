"""Spheres under a shoe: where they stand, and what pushes them over a seam."""

import numpy as np
import pytest

from exudyn_crawler import Case, SphereContact
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.ground.coordinates import ConstrainedCoordinates
from exudyn_crawler.ground.sphere_contact import sphere_field
from exudyn_crawler.ground.spheres import COLUMN

SPHERES = SphereContact.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)
DRAWN_BACK = CASE.with_(contact=SPHERES.with_(faces="drawn_back"))


def test_spheres_stand_evenly_inside_the_underside():
    places = sphere_field(CASE).places
    low_x, high_x, low_y, high_y, z = CASE.shoe.footprint
    assert len(places) == 20
    assert places.mean(axis=0)[:2] == pytest.approx(
        [0.5 * (low_x + high_x), 0.5 * (low_y + high_y)], abs=1e-12
    )
    assert places[:, 0].min() - low_x == pytest.approx(0.63 / 8.0, rel=1e-12)
    assert places[:, 1].max() - high_y == pytest.approx(-3.505 / 10.0, rel=1e-12)
    assert places[:, 2] == pytest.approx(z + SPHERES.radius)


def lift_over_seam(case: Case, beside: float) -> float:
    """Vertical force on a sphere beside the seam at x = 7 m by so much (m), over that far from any seam."""
    terrain = case.terrain
    contact = ground_contact(case, ConstrainedCoordinates(terrain.unit_count, terrain.tilt_axis))
    rear = sphere_field(case).places[0, 0] + contact.shoe_reference[0, 0]

    def lift(x):
        q = np.zeros(contact.size)
        q[0], q[2] = x - rear, -case.settled_penetration
        table, _, _ = contact.touching(q, np.zeros_like(q))
        point, normal = table[:, COLUMN["point"]], table[:, COLUMN["normal"]]
        center = point[:, 0] + table[:, COLUMN["distance"]] * normal[:, 0]
        own = (table[:, COLUMN["shoe"]] == 0.0) & (np.abs(center - x) < 1e-9)
        return float((table[own, COLUMN["size"]] * normal[own, 2]).sum())

    return lift(7.0 + beside) / lift(3.5)


def test_whole_faces_both_push_a_sphere_over_their_seam():
    assert sphere_field(CASE).inset == (0.0, 0.0)
    assert lift_over_seam(CASE, 0.0) == pytest.approx(2.0, rel=1e-9)


def test_drawn_back_faces_push_over_the_seam_as_hard_as_one():
    assert lift_over_seam(DRAWN_BACK, 0.0) == pytest.approx(1.0, rel=1e-9)
    beside = np.array([lift_over_seam(DRAWN_BACK, x) for x in np.linspace(-0.1, 0.1, 21)])
    assert beside == pytest.approx(1.0, abs=0.1)
    assert np.ptp(beside) > 0.01
