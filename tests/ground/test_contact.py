"""What every model of contact does, asked of each: `GroundContact`."""

import numpy as np
import pytest

from exudyn_crawler import Case, PairContact, SphereContact
from exudyn_crawler.case import Terrain
from exudyn_crawler.ground.contact import PairGroundContact, ground_contact
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import moments_of
from exudyn_crawler.ground.terrain import UnitCoordinates

SHOES = 13
SIX = 6 * SHOES
PAIR = Case.translation()
CASES = {
    "pair": PAIR,
    "pair by area": PAIR.with_(contact=PairContact.oil_sand(sharing="area"), terrain=Terrain.stress()),
    "spheres": PAIR.with_(contact=SphereContact.oil_sand()),
}


VARIANTS = [
    ("pair", "reduced"),
    ("pair", "constrained"),
    ("pair by area", "reduced"),
    ("spheres", "constrained"),
]


@pytest.fixture(scope="module", params=VARIANTS, ids=" in ".join)
def contact(request):
    name, formulation = request.param
    return ground_contact(CASES[name].with_(terrain_formulation=formulation))


def states(contact, seed):
    """Random state of shoes in the ground and of terrain coordinates: (q, q_t)."""
    random = np.random.default_rng(seed)
    q, q_t = random.uniform(-1.0, 1.0, (2, contact.size))
    is_bodies = isinstance(contact.coordinates, UnitCoordinates)
    if is_bodies:  # these keep their x, y and the other angles
        tilt = 3 + contact.coordinates.tilt_axis
        q[SIX:].reshape(-1, 6)[:, [k for k in range(6) if k not in (2, tilt)]] = 0.0
    q[:SIX] *= np.tile([0.3, 0.3, 0.02, 0.02, 0.02, 0.05], SHOES)
    q[2:SIX:6] -= 0.0657
    q_t[:SIX] *= 0.05
    q[SIX:] *= 1e-3 if is_bodies else 1.0
    q_t[SIX:] *= 1e-2 if is_bodies else 1.0
    return q, q_t


def wrenches(contact, seed):
    """Forces and moments on shoes that stand on the ground: array (shoes, 6)."""
    random = np.random.default_rng(seed)
    return random.normal(size=(SHOES, 6)) * [3e4, 3e4, 2e4, 5e4, 3e4, 2e4] + [0.0, 0.0, 4e5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("seed", range(3))
def test_results_add_up_to_the_forces_on_every_shoe(contact, seed):
    q, q_t = states(contact, seed)
    shoes = contact.shoe_reference + q[:SIX].reshape(-1, 6)
    if isinstance(contact, PairGroundContact):
        rows, forces = contact.results(q, q_t), contact.forces(q, q_t)
        assert forces.shape == (contact.size,)
        generalized = forces[:SIX].reshape(-1, 6)
        on_shoes = np.hstack((generalized[:, :3], moments_of(shoes[:, 3:], generalized[:, 3:])))
    else:
        on_shoes = wrenches(contact, seed)
        rows = contact.results(q, q_t, on_shoes)
    assert rows.shape[1] == RESULTS
    index = rows[:, RESULT["shoe"]].astype(int)
    force = rows[:, RESULT["normal_force"]] + rows[:, RESULT["friction_force"]]
    moment = np.cross(rows[:, RESULT["point"]] - shoes[index, :3], force) + rows[:, RESULT["friction_torque"]]
    summed = np.zeros((2, SHOES, 3))
    np.add.at(summed[0], index, force)
    np.add.at(summed[1], index, moment)
    assert np.abs(on_shoes).max() > 1e5
    scale = 1e-10 * np.abs(on_shoes).max()
    assert summed[0] == pytest.approx(on_shoes[:, :3], abs=scale)
    assert summed[1] == pytest.approx(on_shoes[:, 3:], abs=scale)


def test_the_terrain_sinks_evenly(contact):
    motion = contact.coordinates.motion(contact.coordinates.sunk_evenly(-0.04))
    assert motion[:, 2] == pytest.approx(-0.04, abs=1e-12)
    assert np.abs(motion[:, [0, 1, 3]]).max() < 1e-12


def test_shoes_at_the_settled_depth_carry_their_loads(contact, request):
    loads = np.full(SHOES, 4.3e5)
    case = CASES[request.node.callspec.params["contact"][0]]
    depths, q = case.settled_depths(loads), np.zeros(contact.size)
    q[2:SIX:6] = -depths
    assert case.settled_depths(-loads) == pytest.approx(np.zeros(SHOES))
    if not isinstance(contact, PairGroundContact):
        assert depths == pytest.approx(contact.depths(q).mean(axis=1))
        return
    carried = contact.forces(q, np.zeros_like(q))[2:SIX:6]
    # shoe 10 stands on one unit of 7 m; by area every shoe has one whole law
    assert carried[9] == pytest.approx(4.3e5, rel=1e-9)
