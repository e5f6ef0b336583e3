"""Contact of the whole track: balance of action and reaction, tangents, crossing of edges."""

import numpy as np
import pytest

from exudyn_crawler import Case, PairContact, Shoe, Terrain
from exudyn_crawler.ground.contact import ground_contact, pair_law
from exudyn_crawler.ground.laws import impact_force
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.ground.rotations import ForceRows, Weights, moments_of

TERRAINS = {
    f"{name} {tilt}": terrain.with_(tilt=tilt)
    for name, terrain in (("coarse", Terrain.kinematics()), ("fine", Terrain.stress()))
    for tilt in ("pitch", "roll")
}
SHOES = 13
WHOLE = Case.translation().with_(shoe=Shoe.ph4100c(), contact=PairContact.oil_sand())
"""Contacts by whole undersides, normal to the units' faces."""


@pytest.fixture(scope="module", params=TERRAINS)
def contacts(request):
    """Contact of the track in both formulations of the terrain."""
    case = WHOLE.with_(terrain=TERRAINS[request.param])
    return {one: ground_contact(case.with_(terrain_formulation=one)) for one in ("reduced", "constrained")}


def spread(contact, seed):
    """Random state of shoes in the ground and of terrain coordinates: (q, q_t)."""
    random = np.random.default_rng(seed)
    shoes = random.uniform(-1.0, 1.0, (2, SHOES, 6))
    shoes[0] *= [0.3, 0.3, 0.02, 0.02, 0.02, 0.05]
    shoes[0, :, 2] -= 0.0657
    shoes[1] *= 0.1
    reduced = random.uniform(-1.0, 1.0, (2, contact.coordinates.size)) * [[1.0], [5.0]]
    return tuple(np.concatenate((s.ravel(), r)) for s, r in zip(shoes, reduced, strict=True))


def as_bodies(contacts, q):
    """The same state (or rates) in the coordinates of the constrained formulation."""
    reduced, full = contacts["reduced"], contacts["constrained"]
    motion = reduced.coordinates.motion(q[6 * SHOES :])
    bodies = np.zeros((len(motion), 6))
    bodies[:, 2] = motion[:, 2]
    bodies[:, 3 + full.coordinates.tilt_axis] = motion[:, 3]
    return np.concatenate((q[: 6 * SHOES], bodies.ravel()))


@pytest.mark.parametrize("seed", range(5))
def test_what_shoes_receive_units_give(contacts, seed):
    contact = contacts["constrained"]
    q, q_t = (as_bodies(contacts, x) for x in spread(contacts["reduced"], seed))
    bodies = contact.bodies_at(q, q_t)
    force, moment = np.split(contact.forces(q, q_t).reshape(-1, 6), 2, axis=1)
    moment[:SHOES] = moments_of(bodies.shoes[:, 3:], moment[:SHOES])
    center = np.vstack((bodies.shoes[:, :3], bodies.units[:, :3]))
    assert np.abs(force).max() > 1e5
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9 * np.abs(force).sum())
    about_origin = moment + np.cross(center, force)
    assert about_origin.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9 * np.abs(about_origin).sum())


@pytest.mark.parametrize("seed", range(5))
def test_reduced_forces_are_the_projection_of_the_constrained_ones(contacts, seed):
    reduced, full = contacts["reduced"], contacts["constrained"]
    q, q_t = spread(reduced, seed)
    bodies = full.forces(as_bodies(contacts, q), as_bodies(contacts, q_t)).reshape(-1, 6)
    units = bodies[SHOES:]
    modes = reduced.coordinates
    expected = modes.heave.T @ units[:, 2] + modes.tilt.T @ units[:, 3 + full.coordinates.tilt_axis]
    forces = reduced.forces(q, q_t)
    assert forces[: 6 * SHOES] == pytest.approx(bodies[:SHOES].ravel(), rel=1e-12)
    assert forces[6 * SHOES :] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def tangent(contact, q, q_t, weights):
    """Weighted derivative of the forces on the shoes by their coordinates, as the kernel has it."""
    found = UnitContacts.allocate(contact.greatest_count, 0)
    places = tuple(contact.bodies_at(q, q_t))
    count = touching_pairs(places, contact.geometry, tuple(weights), tuple(found), overlap_workspace())
    rows, out = ForceRows(*found.rows), np.zeros((SHOES, 6, SHOES, 6))
    for k in range(count):
        shoe, J = rows.bodies[k, 0], rows.jacobian[k, 0]
        out[shoe, :, shoe] += J.T @ rows.tangent[k] @ J
    return out.reshape(6 * SHOES, 6 * SHOES)


@pytest.mark.parametrize("factors", [(1.0, 0.0), (0.0, 1.0), (1.0, 250.0)])
def test_secant_is_the_tangent_at_rest_and_not_beyond_the_stiction_speed(factors):
    contact = ground_contact(Case.translation())
    q, _ = spread(contact, 3)
    q[3 : 6 * SHOES : 6] = q[4 : 6 * SHOES : 6] = 0.0

    def both(q_t):
        return [tangent(contact, q, q_t, Weights(*factors, 0.0, one, 1.0)) for one in (True, False)]

    at_rest = both(np.zeros_like(q))
    assert at_rest[0] == pytest.approx(at_rest[1], abs=1e-6 * np.abs(at_rest[1]).max())
    q_t = np.zeros_like(q)
    q_t[: 6 * SHOES : 6] = 0.05
    secant, whole = both(q_t)
    slid = [matrix[0, 0] for matrix in (secant, whole)]
    if factors[1]:
        # falling curve: the tangent pushes, the secant drags
        assert slid[0] < 0.0 < slid[1]


def settled(contact, shoe, x):
    """State of a level track, sunk by the papers' depth, with one shoe moved to x; at rest."""
    q = np.zeros(contact.size)
    q[2 : 6 * SHOES : 6] = -0.0657
    q[6 * (shoe - 1)] = x - contact.shoe_reference[shoe - 1, 0]
    return q, np.zeros_like(q)


def test_shoe_seven_rests_on_two_units_with_the_pair_laws_force_on_each():
    contact = ground_contact(WHOLE)
    q, q_t = settled(contact, 7, contact.shoe_reference[6, 0])
    rows = contact.results(q, q_t)
    seven = rows[rows[:, RESULT["shoe"]] == 6]
    assert (seven[:, RESULT["unit"]] + 1).tolist() == [7, 12]
    expected = impact_force(pair_law(WHOLE.contact, 1.0).impact, 0.0657, 0.0)
    for row in seven:
        assert row[RESULT["penetration"]] == pytest.approx(0.0657, rel=1e-12)
        assert row[RESULT["normal_force"]] == pytest.approx((0.0, 0.0, expected), rel=1e-9)
    assert seven[:, RESULT["area"]].sum() == pytest.approx(WHOLE.shoe.length * WHOLE.shoe.width, rel=1e-9)
    assert len(rows) == SHOES + 1


def test_crossing_an_edge_is_continuous():
    contact = ground_contact(WHOLE)
    seven = slice(36, 42)

    def greatest_jump(count):
        places = np.linspace(13.4, 14.6, count)
        forces = np.array([contact.forces(*settled(contact, 7, x))[seven] for x in places])
        return np.abs(np.diff(forces, axis=0)).max(), np.abs(forces[:, 2])

    coarse, force = greatest_jump(6001)
    fine, _ = greatest_jump(12001)
    one = 1.0e8 * 0.0657**2
    assert (force.min(), force.max()) == pytest.approx((one, 2.0 * one), rel=1e-6)
    # where the forces are continuous, half the step makes half the jump
    assert 0.4 < fine / coarse < 0.6
