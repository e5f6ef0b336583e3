"""Contacts at the edges of units: area vector, its gradients, closest points, fingers."""

from typing import NamedTuple

import numpy as np
import pytest

from exudyn_crawler import PairContact, Shoe, Terrain
from exudyn_crawler.ground.contact import pair_law
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.overlap import GRADIENT, overlap, overlap_workspace, write_gradient
from exudyn_crawler.ground.pair_geometry import BodyStates, ContactGeometry, Flexible, Outline
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.pairs import RESULT, Footprint
from exudyn_crawler.ground.rotations import ForceRows, Weights
from exudyn_crawler.ground.terrain import grid_of
from tests.ground.test_overlap import HALF, rectangle

CORNERS = {
    "side": {"x": HALF - 0.1, "y": 0.2},
    "other side": {"x": -HALF + 0.1, "y": 0.2, "slope_x": 0.03},
    "side, yawed and tilted": {"x": HALF - 0.05, "y": -1.2, "yaw": 0.1, "slope_x": 0.05, "slope_y": 0.01},
    "side across": {"x": 0.3, "y": HALF - 1.0, "yaw": -0.06, "slope_y": 0.01},
    "corner": {"x": HALF - 0.1, "y": -HALF + 0.5, "yaw": 0.2, "slope_x": -0.02, "slope_y": 0.015},
    "corner far away": {"x": -HALF - 0.1, "y": HALF + 0.7, "yaw": -0.15, "slope_x": 0.02, "slope_y": 0.01},
    "side, half out of the ground": {"x": HALF - 0.1, "y": 0.2, "yaw": 0.03, "depth": 0.0, "slope_y": 0.03},
    "half out of the ground": {"x": 0.3, "y": 0.2, "yaw": 0.1, "depth": 0.01, "slope_x": 0.08},
}


def clipped(corners):
    """Overlap of corners (4, 3), and the polygon that it leaves; along the unit's axes the shoe's x is xi."""
    work = overlap_workspace()
    work[0, :4, :3] = corners
    work[0, :4, 3] = corners[:, 0] + 0.3 * corners[:, 1]  # any function that is linear over the underside
    part = overlap(work, HALF, HALF)
    return part, work[1 if part.cut else 0]


def values(part) -> np.ndarray:
    """What `write_gradient` gives the changes of."""
    first = [part.area, part.volume, part.xi * part.volume, part.eta * part.volume, part.depth * part.volume]
    return np.array(
        [*first, part.side_x, part.side_y, part.high_xi - part.low_xi, part.high_eta - part.low_eta]
    )


def moved(corners, u):
    """Corners after a displacement of the shoe along the unit's axes."""
    return corners + np.array([u[0], u[1], -u[2]])


@pytest.mark.parametrize("place", CORNERS.values(), ids=CORNERS)
def test_the_gradient_of_an_overlap_is_that_of_central_differences(place):
    corners, h = rectangle(**place), 1e-6
    part, polygon = clipped(corners)
    along_x, along_y = corners[1] - corners[0], corners[3] - corners[0]
    slope = np.linalg.solve([along_x[:2], along_y[:2]], [along_x[2], along_y[2]])
    gradient = np.zeros((GRADIENT, 3))
    write_gradient(polygon, part.cut, part, HALF, HALF, slope[0], slope[1], gradient)
    ends = [[values(clipped(moved(corners, s * u))[0]) for s in (h, -h)] for u in np.eye(3)]
    expected = np.array([(ahead - behind) / (2.0 * h) for ahead, behind in ends]).T
    # the area vector is what volume changes by
    assert (part.side_x, part.side_y, part.area) == pytest.approx(-expected[1], rel=1e-6, abs=1e-8)
    # widths of polygons with slanted ends change by more than the side, which is left out
    kept = slice(0, 9) if place.get("yaw", 0.0) == 0.0 else slice(0, 7)
    assert gradient[:9][kept] == pytest.approx(expected[kept], rel=1e-6, abs=1e-7)


def test_within_a_unit_no_side_is_within_the_shoe():
    part, _ = clipped(rectangle(0.4, -1.1, slope_x=0.03))
    assert (part.side_x, part.side_y, part.cut) == (0.0, 0.0, 0)


class Pair(NamedTuple):
    """One shoe on one unit: what `touching_pairs` takes."""

    track: tuple
    contacts: UnitContacts
    work: np.ndarray
    pitch: float

    def touch(self, places, rates, derive=(1.0, 0.0)):
        """Results, wrenches and tangents of the contacts of a shoe at places and rates (6,)."""
        none = np.zeros((0, 0))
        unit, unit_rates = np.array([[3.5, 3.5, -1.0, self.pitch]]), np.array([[0.0, 0.0, 0.02, 0.003]])
        bodies = BodyStates(places[None].copy(), rates[None].copy(), unit, unit_rates, none, none)
        weights = Weights(*derive, 0.0, False, 1.0)
        count = touching_pairs(tuple(bodies), self.track, tuple(weights), tuple(self.contacts), self.work)
        rows = ForceRows(*self.contacts.rows)
        return [np.array(one[:count]) for one in (self.contacts.results, rows.wrench, rows.tangent)]


def pair_of(contact, shoe=None, pitch=0.0) -> Pair:
    """Pair of a shoe and the first unit of the rigid studies, which pitches (rad)."""
    shoe = Shoe.kinematics() if shoe is None else shoe
    terrain = Terrain.kinematics().with_(columns=1, rows=1)
    flexible = Flexible(np.zeros(2), np.ones(2), np.zeros((2, 2, 3, 0)), np.array([-1]))
    track = ContactGeometry(
        Outline(grid_of(terrain), Footprint(*shoe.footprint.tolist()), shoe.finger_length),
        pair_law(contact, shoe.length * shoe.width),
        flexible,
        shoe.fingers,
    )
    return Pair(plain(track), UnitContacts.allocate(8, 0), overlap_workspace(), pitch)


LAWS = {
    f"{normal}, {penetration}": PairContact.oil_sand().with_(normal=normal, penetration=penetration)
    for normal in ("face", "area")
    for penetration in ("centroid", "closest")
}
RATES = np.array([0.06, -0.02, 0.03, 0.02, -0.03, 0.05])


def at(x, y, depth=0.06, yaw=0.0, roll=0.0, pitch=0.0):
    """Places of a shoe whose COM is over (x, y) and its underside about so deep."""
    return np.array([x, y, Shoe.kinematics().com_height - depth, roll, pitch, yaw])


PLACES = {
    "over a side": at(7.0, 3.0, roll=0.002, pitch=0.01),
    "over a side, yawed": at(7.1, 3.0, yaw=0.05, pitch=-0.01),
    "over a side across": at(3.0, 0.8, roll=0.003),
    "over a corner": at(7.05, 0.9, yaw=0.03, roll=0.004, pitch=0.01),
    "half out of the ground": at(6.95, 3.0, depth=0.04, roll=0.02),
    "a strip of fingers": at(7.0 + 0.344 - 0.08, 3.0, roll=0.002),
    "a strip narrower than deep": at(7.0 + 0.344 - 0.03, 3.0, roll=0.002),
    "fingers take over": at(7.0 + 0.344 - 0.117 + 0.003, 3.0, roll=0.002),
    "a strip in the blend of the edge": at(7.0 + 0.344 - 0.006, 3.0),
}


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("law", [name for name in LAWS if name != "face, centroid"])
def test_tangents_at_edges_are_those_of_central_differences(law, place):
    pair = pair_of(LAWS[law], pitch=0.01)
    results, _, by_place = pair.touch(place, RATES)
    _, _, by_rate = pair.touch(place, RATES, (0.0, 1.0))
    assert len(results)
    for c, u in enumerate(1e-6 * np.eye(6)[:3]):
        for found, change in ((by_place, (u, 0.0)), (by_rate, (0.0, u))):
            ahead, behind = (pair.touch(place + s * change[0], RATES + s * change[1])[1] for s in (1.0, -1.0))
            expected = (ahead - behind) / 2e-6
            assert found[:, :, c] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max() + 1.0)


def test_a_normal_at_an_edge_leans_by_depth_over_width():
    pair = pair_of(LAWS["area, centroid"], Shoe.ph4100c())
    depth, width = 0.06, 0.2
    results, _, _ = pair.touch(at(7.0 + 0.315 - width, 3.0, depth), np.zeros(6))
    normal = results[0, RESULT["normal_force"]]
    assert normal[0] / normal[2] == pytest.approx(depth / width, rel=1e-9)
    assert normal[1] == 0.0


def test_the_penetration_of_a_strip_is_no_more_than_its_width():
    pair = pair_of(LAWS["area, closest"], Shoe.ph4100c())
    for width, expected in ((0.2, 0.06), (0.02, 0.02)):
        x = 7.0 + 0.315 - width
        results, _, _ = pair.touch(at(x, 3.0, 0.06), np.zeros(6))
        assert results[0, RESULT["penetration"]] == pytest.approx(expected, rel=1e-9)


def test_each_finger_alone_over_a_unit_has_a_whole_law_and_further_in_a_shoe_is_one_volume():
    reach, none = 0.09, np.zeros(6)
    results, _, _ = pair_of(LAWS["face, centroid"]).touch(at(7.0 + 0.344 - reach, 3.0), none)
    assert results[:, RESULT["finger"]].tolist() == [1, 2, 3]
    forces = results[:, RESULT["normal_force"]][:, 2]
    # the unit rolls at 3 mrad/s below them, against 10 kN s/m of damping
    assert forces == pytest.approx(forces[0], abs=1e4 * 3e-3 * Shoe.kinematics().width)
    without_fingers = pair_of(LAWS["face, centroid"], Shoe.ph4100c())
    whole, _, _ = without_fingers.touch(at(7.0 + 0.315 - reach, 3.0), none)
    assert whole[:, RESULT["finger"]].tolist() == [0]
    assert forces[0] == pytest.approx(whole[0, RESULT["normal_force"]][2], rel=0.02)
    widths = np.diff(Shoe.kinematics().fingers)[:, 0]
    assert results[:, RESULT["area"]] == pytest.approx(reach * widths, rel=1e-3)
    further_in, _, _ = pair_of(LAWS["area, closest"]).touch(at(7.0, 3.0), none)
    assert further_in[:, RESULT["finger"]].tolist() == [0]


@pytest.mark.parametrize("law", LAWS)
def test_leaving_a_unit_is_continuous(law):
    pair = pair_of(LAWS[law])

    def greatest_jump(count):
        places = (at(x, 3.0, yaw=0.02) for x in np.linspace(6.6, 7.45, count))
        force = [pair.touch(place, np.zeros(6))[1][:, :3].sum(axis=0) for place in places]
        return np.abs(np.diff(force, axis=0)).max()

    # where the forces are continuous, half the step makes half the jump
    assert 0.4 < greatest_jump(8001) / greatest_jump(4001) < 0.6


@pytest.mark.parametrize("normal", ["face", "area"])
def test_inside_a_unit_both_laws_are_the_same(normal):
    place = at(3.3, 3.0, roll=0.004, pitch=0.02)
    expected = pair_of(LAWS["face, centroid"], pitch=0.01).touch(place, RATES)
    found = pair_of(LAWS[f"{normal}, closest"], pitch=0.01).touch(place, RATES)
    for one, other in zip(expected, found, strict=True):
        assert np.array_equal(one, other)
