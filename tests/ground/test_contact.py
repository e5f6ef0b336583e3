"""What every model of contact does, asked of each: `GroundContact`."""

import numpy as np
import pytest
import scipy.sparse

from exudyn_crawler import Case, SphereContact
from exudyn_crawler.case import Terrain
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.ground.coordinates import ConstrainedCoordinates, ReducedCoordinates
from exudyn_crawler.ground.pair_contact import PairGroundContact
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import moments_of
from exudyn_crawler.ground.terrain import terrain_modes
from exudyn_crawler.ground.triplets import Weights

SHOES = 13
SIX = 6 * SHOES
CASES = {
    "pair": Case.translation(),
    "pair by area": Case.translation().with_(
        contact=Case.translation().contact.with_(sharing="area"), terrain=Terrain.stress()
    ),
    "spheres": Case.translation().with_(contact=SphereContact.oil_sand()),
}


def coordinates_of(case: Case, formulation: str):
    terrain = case.terrain
    if formulation == "bodies":
        return ConstrainedCoordinates(terrain.unit_count, terrain.tilt_axis)
    modes = terrain_modes(terrain)
    return ReducedCoordinates(modes, terrain.tilt_axis, modes.size)


@pytest.fixture(
    scope="module",
    params=[("pair", "modes"), ("pair", "bodies"), ("pair by area", "modes"), ("spheres", "bodies")],
    ids=" in ".join,
)
def contact(request):
    case = CASES[request.param[0]]
    return ground_contact(case, coordinates_of(case, request.param[1]))


def moving(contact):
    """Which coordinates move shoes and units: not the units' x, y and the angles that they keep at zero."""
    kept = np.ones(contact.size, dtype=bool)
    if contact.coordinates.shapes is None:
        units = kept[SIX:].reshape(-1, 6)
        units[:] = False
        units[:, [2, 3 + contact.coordinates.tilt_axis]] = True
    return kept


def states(contact, seed):
    """Random state of shoes in the ground and of terrain coordinates: (q, q_t)."""
    random = np.random.default_rng(seed)
    q, q_t = random.uniform(-1.0, 1.0, (2, contact.size)) * moving(contact)
    q[:SIX] *= np.tile([0.3, 0.3, 0.02, 0.02, 0.02, 0.05], SHOES)
    q[2:SIX:6] -= 0.0657
    q_t[:SIX] *= 0.05
    modes = contact.coordinates.shapes is not None
    q[SIX:] *= 1.0 if modes else 1e-3
    q_t[SIX:] *= 1.0 if modes else 1e-2
    return q, q_t


@pytest.mark.parametrize("seed", range(3))
def test_results_add_up_to_the_forces_on_every_shoe(contact, seed):
    q, q_t = states(contact, seed)
    forces, rows = contact.forces(q, q_t), contact.results(q, q_t)
    assert forces.shape == (contact.size,)
    assert rows.shape[1] == RESULTS
    index = rows[:, RESULT["shoe"]].astype(int)
    force = rows[:, RESULT["normal_force"]] + rows[:, RESULT["friction_force"]]
    shoes = contact.shoe_reference + q[:SIX].reshape(-1, 6)
    moment = np.cross(rows[:, RESULT["point"]] - shoes[index, :3], force) + rows[:, RESULT["friction_torque"]]
    summed = np.zeros((2, SHOES, 3))
    np.add.at(summed[0], index, force)
    np.add.at(summed[1], index, moment)
    generalized = forces[:SIX].reshape(-1, 6)
    assert np.abs(generalized).max() > 1e5
    scale = 1e-10 * np.abs(generalized).max()
    assert summed[0] == pytest.approx(generalized[:, :3], abs=scale)
    assert summed[1] == pytest.approx(moments_of(shoes[:, 3:], generalized[:, 3:]), abs=scale)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("by", ["places", "rates"])
def test_derivatives_are_those_of_central_differences(contact, seed, by):
    q, q_t = states(contact, seed)
    kept = moving(contact)
    if by == "places" and contact.spheres is not None:
        q_t[:] = 0.0  # the spheres' derivatives leave out what places change the slip by
    step = 1e-7 * np.random.default_rng(seed).normal(size=contact.size) * kept
    step[SIX:] *= 0.1
    factors = (1.0, 0.0) if by == "places" else (0.0, 1.0)
    ahead, behind = (
        contact.forces(q + s * factors[0] * step, q_t + s * factors[1] * step) for s in (1.0, -1.0)
    )
    expected = 0.5 * (ahead - behind)[kept]
    triplets = contact.derivatives(q, q_t, Weights(*factors))
    rows, columns = triplets[:, :2].astype(int).T
    matrix = scipy.sparse.coo_matrix((triplets[:, 2], (rows, columns)), shape=(contact.size,) * 2)
    given = (matrix @ step)[kept]
    # one-sided steps of 1e-6 m/s on a curve that bends within 1e-2 m/s err by some 4e-4
    assert given == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
    assert np.abs(expected).max() > 1e-4


def test_weights_add_both_derivatives(contact):
    q, q_t = states(contact, 5)

    def matrix(*factors):
        triplets = contact.derivatives(q, q_t, Weights(*factors, secant=True))
        rows, columns = triplets[:, :2].astype(int).T
        return scipy.sparse.coo_matrix((triplets[:, 2], (rows, columns)), shape=(contact.size,) * 2).toarray()

    both = matrix(-1.0, -250.0)
    assert both == pytest.approx(-matrix(1.0, 0.0) - 250.0 * matrix(0.0, 1.0), abs=1e-10 * np.abs(both).max())


def test_the_terrain_sinks_evenly(contact):
    q = np.zeros(contact.size)
    q[SIX : SIX + contact.coordinates.size] = contact.coordinates.sunk_evenly(-0.04)
    motion = contact.unit_motion(q)
    assert motion[:, 2] == pytest.approx(-0.04, abs=1e-12)
    assert np.abs(motion[:, [0, 1, 3]]).max() < 1e-12


def test_shoes_at_the_settled_depth_carry_their_loads(contact):
    loads = np.full(SHOES, 4.3e5)
    q = np.zeros(contact.size)
    q[2:SIX:6] = -contact.settled_depth(loads)
    carried = contact.forces(q, np.zeros_like(q))[2:SIX:6]
    # shoe 10 stands on one unit of 7 m; by area every shoe has one whole law
    assert carried[9] == pytest.approx(4.3e5, rel=1e-9)
    assert contact.settled_depth(-loads) == pytest.approx(np.zeros(SHOES))


def test_ground_below_is_that_of_the_units_there(contact):
    heights = contact.unit_reference[:, 0]
    below = contact.ground_below(np.zeros(contact.size), heights)
    half = 0.5 * (heights[-1] - heights[0]) / (len(np.unique(heights)) - 1)
    assert np.abs(below - contact.shoe_reference[:, 0]).max() < half + 0.33


def test_nothing_sinks_through_even_ground(contact):
    assert contact.sunken(np.zeros(contact.size)) == []


def test_flexible_shoes_need_independent_coordinates():
    case = CASES["pair"]
    coms = case.track.com_positions(case.shoe.com_height)
    with pytest.raises(ValueError, match="coordinates must be the terrain's independent ones"):
        PairGroundContact(
            coms,
            case.shoe,
            case.terrain,
            case.contact,
            coordinates_of(case, "bodies"),
            flexible_shoes=[6],
        )
