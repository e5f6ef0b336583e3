"""Contacts at the edges of units: leaning normals, closest points, fingers."""

import numpy as np
import pytest

from exudyn_crawler import PairContact, Shoe, Terrain
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_geometry import BodyStates
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.ground.terrain import UnitCoordinates


class Pair:
    """One shoe on the first unit of the rigid studies, which pitches (rad)."""

    def __init__(self, law, shoe=None, pitch=0.0):
        shoe = shoe or Shoe.kinematics()
        terrain = Terrain.kinematics().with_(columns=1, rows=1)
        units = UnitCoordinates(1, terrain.tilt_axis)
        self.track = PairGroundContact(np.zeros((1, 6)), shoe, terrain, LAWS[law], units).geometry
        self.contacts, self.work = UnitContacts.allocate(8, 0), overlap_workspace()
        self.unit = np.array([[3.5, 3.5, -1.0, pitch]])

    def touch(self, place, rates, derive=(1.0, 0.0)):
        """Results, wrenches and tangents of the contacts of a shoe at a place and rates (6,)."""
        none, unit_rates = np.zeros((0, 0)), np.array([[0.0, 0.0, 0.02, 0.003]])
        bodies = BodyStates(place[None].copy(), rates[None].copy(), self.unit, unit_rates, none, none)
        weights = Weights(*derive, 0.0, False, 1.0)
        count = touching_pairs(bodies, self.track, weights, self.contacts, self.work)
        rows = self.contacts.rows
        return [np.array(one[:count]) for one in (self.contacts.results, rows.wrench, rows.tangent)]

    def results(self, *where):
        """Results of the contacts of a shoe at rest."""
        return self.touch(at(*where), np.zeros(6))[0]


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
    "a corner of a turned shoe, a triangle": at(7.0 + 1.05, 3.0, yaw=0.5, roll=0.002),
    "half out of the ground": at(6.95, 3.0, depth=0.04, roll=0.02),
    "a strip of fingers": at(7.0 + 0.344 - 0.08, 3.0, roll=0.002),
    "a strip narrower than deep": at(7.0 + 0.344 - 0.03, 3.0, roll=0.002),
    "fingers take over": at(7.0 + 0.344 - 0.117 + 0.003, 3.0, roll=0.002),
    "a strip in the blend of the edge": at(7.0 + 0.344 - 0.006, 3.0),
}


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("law", [name for name in LAWS if name != "face, centroid"])
def test_tangents_at_edges_are_those_of_central_differences(law, place):
    pair = Pair(law, pitch=0.01)
    for derive in ((1.0, 0.0), (0.0, 1.0)):
        results, _, tangents = pair.touch(place, RATES, derive)
        assert len(results)
        for c, u in enumerate(1e-6 * np.eye(6)[:3]):
            by_place, by_rate = np.outer(derive, u)
            ahead, behind = (pair.touch(place + s * by_place, RATES + s * by_rate)[1] for s in (1.0, -1.0))
            expected = (ahead - behind) / 2e-6
            assert tangents[:, :, c] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max() + 1.0)


def test_a_normal_at_an_edge_leans_by_depth_over_width():
    results = Pair("area, centroid", Shoe.ph4100c()).results(7.0 + 0.315 - 0.2, 3.0)
    normal = results[0, RESULT["normal_force"]]
    assert normal[0] / normal[2] == pytest.approx(0.06 / 0.2, rel=1e-9)
    assert normal[1] == 0.0


@pytest.mark.parametrize(("width", "expected"), [(0.2, 0.06), (0.02, 0.02)])
def test_the_penetration_of_a_strip_is_no_more_than_its_width(width, expected):
    results = Pair("area, closest", Shoe.ph4100c()).results(7.0 + 0.315 - width, 3.0)
    assert results[0, RESULT["penetration"]] == pytest.approx(expected, rel=1e-9)


def test_each_finger_alone_over_a_unit_has_a_whole_law_and_further_in_a_shoe_is_one_volume():
    reach = 0.09
    results = Pair("face, centroid").results(7.0 + 0.344 - reach, 3.0)
    whole = Pair("face, centroid", Shoe.ph4100c()).results(7.0 + 0.315 - reach, 3.0)
    further_in = Pair("area, closest").results(7.0, 3.0)
    fingers = [one[:, RESULT["finger"]].tolist() for one in (results, whole, further_in)]
    assert fingers == [[1, 2, 3], [0], [0]]
    forces = results[:, RESULT["normal_force"]][:, 2]
    # the unit rolls at 3 mrad/s below them, against 10 kN s/m of damping
    assert forces == pytest.approx(forces[0], abs=1e4 * 3e-3 * Shoe.kinematics().width)
    assert forces[0] == pytest.approx(whole[0, RESULT["normal_force"]][2], rel=0.02)
    widths = np.diff(Shoe.kinematics().fingers)[:, 0]
    assert results[:, RESULT["area"]] == pytest.approx(reach * widths, rel=1e-3)


@pytest.mark.parametrize("law", LAWS)
def test_leaving_a_unit_is_continuous(law):
    pair = Pair(law)
    places = (at(x, 3.0, yaw=0.02) for x in np.linspace(6.6, 7.45, 8001))
    force = np.array([pair.touch(place, np.zeros(6))[1][:, :3].sum(axis=0) for place in places])
    coarse, fine = (np.abs(np.diff(force[::every], axis=0)).max() for every in (2, 1))
    # where the forces are continuous, half the step makes half the jump
    assert 0.4 < fine / coarse < 0.6


@pytest.mark.parametrize("normal", ["face", "area"])
def test_inside_a_unit_both_laws_are_the_same(normal):
    place = at(3.3, 3.0, roll=0.004, pitch=0.02)
    expected = Pair("face, centroid", pitch=0.01).touch(place, RATES)
    found = Pair(f"{normal}, closest", pitch=0.01).touch(place, RATES)
    for one, other in zip(expected, found, strict=True):
        assert np.array_equal(one, other)
