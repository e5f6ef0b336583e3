"""Contact of the whole track by every model: sums, reactions, tangents, crossing of edges, spheres."""

import numpy as np
import pytest

from exudyn_crawler import Case, PairContact, Shoe, SphereContact, Terrain
from exudyn_crawler.case import Heights, statics
from exudyn_crawler.ground.contact import PairGroundContact, ground_contact, pair_law
from exudyn_crawler.ground.laws import impact_force
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import moments_of
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.ground.sphere_contact import face_inset, sphere_centers
from exudyn_crawler.ground.terrain import UnitCoordinates
from tests.model.both import sphere_wrenches

SHOES = 13
SIX = 6 * SHOES
PAIR = Case.translation()
WHOLE = PAIR.with_(shoe=Shoe.ph4100c(), contact=PairContact.oil_sand())
"""Contacts by whole undersides, normal to the units' faces."""
SPHERES = PAIR.with_(contact=SphereContact.oil_sand())
FOUR = SPHERES.with_({"contact.spheres_x": 2, "contact.spheres_y": 2})
BY_AREA = PAIR.with_(contact=PairContact.oil_sand(sharing="area"), terrain=Terrain.stress())
CASES = {
    "pair in reduced": PAIR,
    "pair in constrained": PAIR.with_(terrain_formulation="constrained"),
    "pair by area in reduced": BY_AREA,
    "spheres in constrained": SPHERES.with_(terrain_formulation="constrained"),
}
TERRAINS = {
    f"{name} {tilt}": terrain.with_(tilt=tilt)
    for name, terrain in (("coarse", Terrain.kinematics()), ("fine", Terrain.stress()))
    for tilt in ("pitch", "roll")
}


@pytest.fixture(scope="module", params=CASES)
def contact(request):
    return ground_contact(CASES[request.param])


@pytest.fixture(scope="module", params=TERRAINS)
def formulations(request):
    """Contact of the track in both formulations of the terrain, reduced and constrained."""
    case = WHOLE.with_(terrain=TERRAINS[request.param])
    return [ground_contact(case.with_(terrain_formulation=one)) for one in ("reduced", "constrained")]


def states(contact, seed):
    """Random state of shoes in the ground and of terrain coordinates: (q, q_t)."""
    random = np.random.default_rng(seed)
    q, q_t = random.uniform(-1.0, 1.0, (2, contact.size))
    q[:SIX] *= np.tile([0.3, 0.3, 0.02, 0.02, 0.02, 0.05], SHOES)
    q[2:SIX:6] -= 0.0657
    q_t[:SIX] *= 0.1
    if isinstance(contact.coordinates, UnitCoordinates):  # these keep their x, y and the other angles
        held = [k for k in range(6) if k not in (2, 3 + contact.coordinates.tilt_axis)]
        q[SIX:].reshape(-1, 6)[:, held] = 0.0
        q[SIX:] *= 1e-3
        q_t[SIX:] *= 1e-2
    else:
        q_t[SIX:] *= 5.0
    return q, q_t


def wrenches(seed):
    """Forces and moments on shoes that stand on the ground: array (shoes, 6)."""
    random = np.random.default_rng(seed)
    return random.normal(size=(SHOES, 6)) * [3e4, 3e4, 2e4, 5e4, 3e4, 2e4] + [0.0, 0.0, 4e5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("seed", range(3))
def test_results_add_up_to_the_forces_on_every_shoe(contact, seed):
    q, q_t = states(contact, seed)
    shoes = contact.shoe_reference + q[:SIX].reshape(-1, 6)
    if isinstance(contact, PairGroundContact):
        rows, _ = contact.results(q[None], q_t[None])
        forces = contact.forces(q, q_t)
        assert forces.shape == (contact.size,)
        generalized = forces[:SIX].reshape(-1, 6)
        on_shoes = np.hstack((generalized[:, :3], moments_of(shoes[:, 3:], generalized[:, 3:])))
    else:
        on_shoes = wrenches(seed)
        rows, _ = contact.results(q[None], q_t[None], on_shoes[None])
    assert rows.shape[1] == RESULTS
    index = rows[:, RESULT["shoe"]].astype(int)
    force = rows[:, RESULT["normal_force"]] + rows[:, RESULT["friction_force"]]
    moment = np.cross(rows[:, RESULT["point"]] - shoes[index, :3], force) + rows[:, RESULT["friction_torque"]]
    summed = np.zeros((SHOES, 6))
    np.add.at(summed, index, np.hstack((force, moment)))
    assert np.abs(on_shoes).max() > 1e5
    assert summed == pytest.approx(on_shoes, abs=1e-10 * np.abs(on_shoes).max())


def test_the_terrain_sinks_evenly(contact):
    motion = contact.coordinates.motion(contact.coordinates.sunk_evenly(-0.04))
    assert motion == pytest.approx(np.tile([0.0, 0.0, -0.04, 0.0], (len(motion), 1)), abs=1e-12)


def test_shoes_at_the_settled_depth_carry_their_loads(contact, request):
    loads = np.full(SHOES, 4.3e5)
    case = CASES[request.node.callspec.params["contact"]]
    depths, q = statics.settled_depths(case, loads), np.zeros(contact.size)
    q[2:SIX:6] = -depths
    assert statics.settled_depths(case, -loads) == pytest.approx(np.zeros(SHOES))
    if isinstance(contact, PairGroundContact):
        # shoe 10 stands on one unit of 7 m; by area every shoe has one whole law
        assert contact.forces(q, np.zeros_like(q))[2:SIX:6][9] == pytest.approx(4.3e5, rel=1e-9)
    else:
        assert depths == pytest.approx(contact.depths(q).mean(axis=1))


def test_kernels_get_rows_of_bodies_in_both_formulations(formulations):
    """Arrays in another order would have the contact compiled once more, 10 s."""
    for contact in formulations:
        q = np.zeros((2, contact.size))
        assert all(array.flags.c_contiguous for array in contact.bodies_at(q, q))
        assert all(array.flags.c_contiguous for array in contact.bodies_at(q[0], q[0]))


@pytest.mark.parametrize("seed", range(5))
def test_what_shoes_receive_units_give(formulations, seed):
    _, contact = formulations
    q, q_t = states(contact, seed)
    bodies = contact.bodies_at(q, q_t)
    force, moment = np.split(contact.forces(q, q_t).reshape(-1, 6), 2, axis=1)
    moment[:SHOES] = moments_of(bodies.shoes[:, 3:], moment[:SHOES])
    center = np.vstack((bodies.shoes[:, :3], bodies.units[:, :3]))
    assert np.abs(force).max() > 1e5
    for one in (force, moment + np.cross(center, force)):
        assert one.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9 * np.abs(one).sum())


@pytest.mark.parametrize("seed", range(5))
def test_reduced_forces_are_the_projection_of_the_constrained_ones(formulations, seed):
    reduced, full = formulations
    modes, tilt = reduced.coordinates, 3 + full.coordinates.tilt_axis

    def as_bodies(q):
        """The same state (or rates) in the coordinates of the constrained formulation."""
        motion = modes.motion(q[SIX:])
        bodies = np.zeros((len(motion), 6))
        bodies[:, [2, tilt]] = motion[:, 2:]
        return np.concatenate((q[:SIX], bodies.ravel()))

    q, q_t = states(reduced, seed)
    bodies = full.forces(as_bodies(q), as_bodies(q_t)).reshape(-1, 6)
    expected = modes.heave.T @ bodies[SHOES:, 2] + modes.tilt.T @ bodies[SHOES:, tilt]
    forces = reduced.forces(q, q_t)
    assert forces[:SIX] == pytest.approx(bodies[:SHOES].ravel(), rel=1e-12)
    assert forces[SIX:] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def tangent(contact, q, q_t, weights):
    """Weighted derivative of the forces on the shoes by their coordinates, as the kernel has it."""
    found = UnitContacts.allocate(contact.greatest_count, 0)
    bodies = contact.bodies_at(q, q_t)
    count = touching_pairs(bodies, contact.geometry, weights, found, overlap_workspace())
    rows, out = found.rows, np.zeros((SHOES, 6, SHOES, 6))
    for k in range(count):
        shoe, J = rows.bodies[k, 0], rows.jacobian[k, 0]
        out[shoe, :, shoe] += J.T @ rows.tangent[k] @ J
    return out.reshape(SIX, SIX)


@pytest.mark.parametrize("factors", [(1.0, 0.0), (0.0, 1.0), (1.0, 250.0)])
def test_secant_is_the_tangent_at_rest_and_not_beyond_the_stiction_speed(factors):
    contact = ground_contact(PAIR)
    q, _ = states(contact, 3)
    q[3:SIX:6] = q[4:SIX:6] = 0.0

    def both(q_t):
        return [tangent(contact, q, q_t, Weights(*factors, 0.0, one, 1.0)) for one in (True, False)]

    q_t = np.zeros_like(q)
    at_rest = both(q_t)
    assert at_rest[0] == pytest.approx(at_rest[1], abs=1e-6 * np.abs(at_rest[1]).max())
    q_t[:SIX:6] = 0.05
    secant, whole = both(q_t)
    if factors[1]:
        # falling curve: the tangent pushes, the secant drags
        assert secant[0, 0] < 0.0 < whole[0, 0]


def settled(contact, x):
    """State of a level track, sunk by the papers' depth, with shoe seven moved to x; at rest."""
    q = np.zeros(contact.size)
    q[2:SIX:6] = -0.0657
    q[36] = x - contact.shoe_reference[6, 0]
    return q, np.zeros_like(q)


def test_shoe_seven_rests_on_two_units_with_the_pair_laws_force_on_each():
    contact = ground_contact(WHOLE)
    q, q_t = settled(contact, contact.shoe_reference[6, 0])
    rows, _ = contact.results(q[None], q_t[None])
    seven = rows[rows[:, RESULT["shoe"]] == 6]
    assert (seven[:, RESULT["unit"]] + 1).tolist() == [7, 12]
    expected = impact_force(pair_law(WHOLE.contact, 1.0).impact, 0.0657, 0.0)
    assert seven[:, RESULT["penetration"]] == pytest.approx(0.0657, rel=1e-12)
    assert seven[:, RESULT["normal_force"]] == pytest.approx(np.array([[0.0, 0.0, expected]] * 2), rel=1e-9)
    assert seven[:, RESULT["area"]].sum() == pytest.approx(WHOLE.shoe.length * WHOLE.shoe.width, rel=1e-9)
    assert len(rows) == SHOES + 1


def test_crossing_an_edge_is_continuous():
    contact = ground_contact(WHOLE)
    places = np.linspace(13.4, 14.6, 12001)
    forces = np.array([contact.forces(*settled(contact, x))[36:42] for x in places])
    coarse, fine = (np.abs(np.diff(forces[::every], axis=0)).max() for every in (2, 1))
    force = np.abs(forces[::2, 2])
    one = 1.0e8 * 0.0657**2
    assert (force.min(), force.max()) == pytest.approx((one, 2.0 * one), rel=1e-6)
    # where the forces are continuous, half the step makes half the jump
    assert 0.4 < fine / coarse < 0.6


def test_spheres_stand_evenly_inside_the_underside():
    places = sphere_centers(SPHERES)
    low_x, high_x, low_y, high_y, z = SPHERES.shoe.footprint
    assert len(places) == 20
    middle = [0.5 * (low_x + high_x), 0.5 * (low_y + high_y)]
    assert places.mean(axis=0)[:2] == pytest.approx(middle, abs=1e-12)
    assert places[:, 0].min() - low_x == pytest.approx(SPHERES.shoe.length / 8.0, rel=1e-12)
    assert places[:, 1].max() - high_y == pytest.approx(-3.505 / 10.0, rel=1e-12)
    assert places[:, 2] == pytest.approx(z + SPHERES.contact.radius)


def test_spheres_are_as_deep_as_the_faces_of_a_relief_let_them():
    hills = Heights(slope_x=0.1, level=-1.4)
    case = SPHERES.with_({"terrain.relief": hills, "terrain.tilt": "pitch"})
    contact = ground_contact(case)
    places = contact.shoe_reference[:, None, :3] + sphere_centers(case)
    above = (places[..., 2] - 0.1 * places[..., 0] + 1.4) / np.hypot(1.0, 0.1)
    q = np.zeros(contact.size)
    assert contact.depths(q) == pytest.approx(SPHERES.contact.radius - above, abs=1e-12)
    assert contact.sunken(q) == (np.flatnonzero((above < 0.0).any(axis=1)) + 1).tolist()


def lift_over_seam(case, beside):
    """Vertical force on rear spheres beside the seam at x = 7 m by so much (m), over that far from any seam.

    The front ones stand on one face both times.
    """
    rear = sphere_centers(case)[0, 0] + case.gear.shoe_reference(case)[0, 0]

    def lift(x):
        q = np.zeros(SIX + 6 * case.terrain.unit_count)
        q[0], q[2] = x - rear, -statics.settled_penetration(case)
        return float(sphere_wrenches(case, q)[0, 2])

    return lift(7.0 + beside) / (0.5 * lift(3.5)) - 1.0


def test_whole_faces_both_push_a_sphere_beside_their_seam():
    """At the seam itself both faces' points are one, which Exudyn takes once."""
    assert face_inset(FOUR) == (0.0, 0.0)
    assert lift_over_seam(FOUR, 0.0) == pytest.approx(1.0, rel=1e-9)
    assert lift_over_seam(FOUR, 1e-6) == pytest.approx(2.0, rel=1e-9)


def test_drawn_back_faces_push_over_the_seam_as_hard_as_one():
    drawn_back = FOUR.with_({"contact.faces": "drawn_back"})
    assert lift_over_seam(drawn_back, 0.0) == pytest.approx(1.0, rel=1e-9)
    beside = np.array([lift_over_seam(drawn_back, x) for x in np.linspace(-0.1, 0.1, 21)])
    assert beside == pytest.approx(1.0, abs=0.1)
    assert np.ptp(beside) > 0.01
