"""Contact of the assembled track: balance of action and reaction, derivatives, crossing of edges."""

import numpy as np
import pytest
import scipy.sparse

from exudyn_crawler import Case, Terrain
from exudyn_crawler.ground.laws import normal_force
from exudyn_crawler.ground.pair_contact import pair_law
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.ground.rotations import moments_of
from exudyn_crawler.ground.triplets import Weights
from exudyn_crawler.model.system import build

TERRAINS = {
    f"{name} {tilt}": terrain.with_(tilt=tilt)
    for name, terrain in (("coarse", Terrain.kinematics()), ("fine", Terrain.stress()))
    for tilt in ("pitch", "roll")
}
SHOES = 13


@pytest.fixture(scope="module", params=TERRAINS)
def contacts(request):
    """Contact of the assembled track in both formulations."""
    case = Case.translation().with_(terrain=TERRAINS[request.param])
    return {one: build(case.with_(terrain_formulation=one)).contact for one in ("reduced", "constrained")}


def spread(contact, seed):
    """Random state of shoes in the ground and of terrain coordinates: (q, q_t)."""
    random = np.random.default_rng(seed)
    shoes = random.uniform(-1.0, 1.0, (2, SHOES, 6))
    shoes[0] *= [0.3, 0.3, 0.02, 0.02, 0.02, 0.05]
    shoes[0, :, 2] -= 0.0657
    shoes[1] *= [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]
    reduced = random.uniform(-1.0, 1.0, (2, contact.coordinates.size)) * [[1.0], [5.0]]
    return tuple(np.concatenate((s.ravel(), r)) for s, r in zip(shoes, reduced, strict=True))


def as_bodies(contacts, q):
    """The same state (or rates) in the coordinates of the constrained formulation."""
    reduced, full = contacts["reduced"], contacts["constrained"]
    motion = reduced.unit_motion(q)
    bodies = np.zeros((len(motion), 6))
    bodies[:, 2] = motion[:, 2]
    bodies[:, 3 + full.coordinates.tilt_axis] = motion[:, 3]
    return np.concatenate((q[: 6 * SHOES], bodies.ravel()))


def wrenches(contact, q, forces):
    """Forces and moments about their centres of all bodies, and where those are."""
    places = q.reshape(-1, 6)
    generalized = forces.reshape(-1, 6)
    moments = moments_of(places[:, 3:], generalized[:, 3:])
    centers = np.vstack((contact.shoe_reference[:, :3], contact.unit_reference[:, :3])) + places[:, :3]
    return generalized[:, :3], moments, centers


@pytest.mark.parametrize("seed", range(5))
def test_what_shoes_receive_units_give(contacts, seed):
    full = contacts["constrained"]
    q, q_t = (as_bodies(contacts, x) for x in spread(contacts["reduced"], seed))
    force, moment, center = wrenches(full, q, full.forces(q, q_t))
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
    modes = reduced.coordinates.modes
    expected = modes.heave.T @ units[:, 2] + modes.tilt.T @ units[:, 3 + full.coordinates.tilt_axis]
    forces = reduced.forces(q, q_t)
    assert forces[: 6 * SHOES] == pytest.approx(bodies[:SHOES].ravel(), rel=1e-12)
    assert forces[6 * SHOES :] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def dense(triplets, size):
    rows, columns = triplets[:, :2].astype(int).T
    return scipy.sparse.coo_matrix((triplets[:, 2], (rows, columns)), shape=(size, size)).toarray()


def central(function, x, h):
    columns = []
    for k in range(len(x)):
        step = np.zeros_like(x)
        step[k] = h
        columns.append((function(x + step) - function(x - step)) / (2.0 * h))
    return np.column_stack(columns)


@pytest.mark.parametrize("by", ["position", "velocity"])
def test_derivatives_are_those_of_central_differences(contacts, by):
    reduced = contacts["reduced"]
    q, q_t = spread(reduced, 11)
    if by == "position":
        expected = central(lambda x: reduced.forces(x, q_t), q, 1e-6)
        given = reduced.derivatives(q, q_t, Weights(1.0, 0.0))
    else:
        expected = central(lambda x: reduced.forces(q, x), q_t, 1e-6)
        given = reduced.derivatives(q, q_t, Weights(0.0, 1.0))
    assert error(dense(given, reduced.size), expected) < 1e-3


def error(given, expected):
    """Greatest difference relative to its column, where that is more than rounding.

    One-sided steps of 1e-6 m/s on a curve that bends within 1e-2 m/s err by some 4e-4.
    """
    scale = np.abs(expected).max(axis=0) + 1e-6 * np.abs(expected).max()
    return (np.abs(given - expected) / scale).max()


def test_constrained_derivatives_hold_what_moves_units(contacts):
    full = contacts["constrained"]
    q, q_t = (as_bodies(contacts, x) for x in spread(contacts["reduced"], 11))
    given = dense(full.derivatives(q, q_t, Weights(1.0, 0.0)), full.size)
    expected = central(lambda x: full.forces(x, q_t), q, 1e-6)
    kept = np.zeros(full.size, dtype=bool)
    kept[: 6 * SHOES] = True
    units = kept[6 * SHOES :].reshape(-1, 6)
    units[:, [2, 3 + full.coordinates.tilt_axis]] = True
    block = np.ix_(kept, kept)
    assert error(given[block], expected[block]) < 1e-3
    assert not given[~kept].any()
    assert not given[:, ~kept].any()


@pytest.mark.parametrize("factors", [(1.0, 0.0), (0.0, 1.0), (1.0, 250.0)])
def test_secant_is_the_tangent_at_rest_and_not_beyond_the_stiction_speed(factors):
    contact = build(Case.translation()).contact
    q, _ = spread(contact, 3)
    q[3 : 6 * SHOES : 6] = q[4 : 6 * SHOES : 6] = 0.0

    def both(q_t):
        return [
            dense(contact.derivatives(q, q_t, Weights(*factors, secant=one)), contact.size)
            for one in (True, False)
        ]

    at_rest = both(np.zeros_like(q))
    assert at_rest[0] == pytest.approx(at_rest[1], abs=1e-6 * np.abs(at_rest[1]).max())
    q_t = np.zeros_like(q)
    q_t[: 6 * SHOES : 6] = 0.05
    secant, tangent = both(q_t)
    slid = [matrix[0, 0] for matrix in (secant, tangent)]
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
    case = Case.translation()
    contact = build(case).contact
    q, q_t = settled(contact, 7, contact.shoe_reference[6, 0])
    rows = contact.results(q, q_t)
    seven = rows[rows[:, RESULT["shoe"]] == 6]
    assert (seven[:, RESULT["unit"]] + 1).tolist() == [7, 12]
    expected = normal_force(pair_law(case.contact, 1.0).law, 0.0657, 0.0)
    for row in seven:
        assert row[RESULT["penetration"]] == pytest.approx(0.0657, rel=1e-12)
        assert row[RESULT["normal_force"]] == pytest.approx((0.0, 0.0, expected), rel=1e-9)
    assert seven[:, RESULT["area"]].sum() == pytest.approx(case.shoe.length * case.shoe.width, rel=1e-9)
    assert len(rows) == SHOES + 1


def test_crossing_an_edge_is_continuous():
    contact = build(Case.translation()).contact
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
