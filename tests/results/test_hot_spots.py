"""Hot spots: regions of a shoe, and shares of loads in a stress by closed forms and by one load alone."""

import numpy as np
import pytest

from exudyn_crawler import Case, History, LoadCycle, simulate
from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.hot_spots import REGIONS, flat_triangles, load_shares, shares, shoe_regions
from fem import Shapes
from meshes import STEEL, joint_interfaces, mesh_named
from tests.modal_loads import modal_loads
from tests.small_shoe import SMALL_SHOE
from tests.stress_results import by_modes_alone

TRACK = Track.ph4100c()
ROOTS = {
    "lugs": ((-0.1837, 0.652, -0.0725), (-0.1837, -0.522, 0.1675), (0.2023, -0.7951, 0.0708)),
    "notches": ((-0.169, -0.463, 0.152), (0.185, -0.408, 0.163), (-0.169, 0.887, 0.152)),
}
"""m: the S-paper's hot spots beside the inner faces of the rear lugs, and the root of a fork's cheek; corners
of the flanges' notches."""

NODES = np.arange(0, 3000, 500)
OTHERS = {
    "machine load": ("joint_force", "joint_torque", "pin_force", "pin_torque", "contact"),
    "ground": ("joint_force", "joint_torque", "pin_force", "pin_torque", "shoe_load"),
}
"""Variables of what acts on a middle shoe beside one load; "contact" stands for all of a contact's."""
CONTACT = ("normal_force", "friction_force", "friction_torque", "area", "node_force")


def bare(mesh) -> Shapes:
    """Shoe without modes."""
    nodes = len(mesh.nodes)
    empty = (np.empty((nodes, 3, 0)), np.empty((nodes, 6, 0)))
    return Shapes(mesh, STEEL, tuple(joint_interfaces(mesh)), *empty)


@pytest.fixture(scope="module")
def shoe() -> Shapes:
    return bare(mesh_named("coarse"))


def test_regions_are_where_their_surfaces_are(shoe):
    regions = shoe_regions(shoe, TRACK)
    assert set(regions) == set(REGIONS)
    assert set(regions[shoe.mesh.nodes_of("rails")]) == {"roller path"}
    for name in TRACK.joint_centers:
        assert set(regions[shoe.mesh.nodes_of(f"bore {name}")]) == {"bores"}
    assert set(regions[np.abs(shoe.nodes[:, 1]) > 1.7]) == {"wings"}


@pytest.mark.parametrize("region", ROOTS)
def test_roots_of_lugs_are_lugs_and_corners_of_notches_are_none(shoe, region):
    surface, regions = shoe.mesh.surface_nodes, shoe_regions(shoe, TRACK)
    for place in ROOTS[region]:
        nearest = surface[np.linalg.norm(shoe.nodes[surface] - place, axis=1).argmin()]
        assert np.linalg.norm(shoe.nodes[nearest] - place) < 0.03
        assert regions[nearest] == region, place


def test_shoe_without_rails_has_neither_roller_path_nor_wings(shoe):
    mesh = shoe.mesh.with_surfaces({})
    del mesh.surfaces["rails"]
    assert set(shoe_regions(bare(mesh), TRACK)) == {"lugs", "bores", "web", "notches"}


@pytest.mark.parametrize(
    ("one", "other", "share"),
    [
        ((3.0, 0, 0, 0, 0, 0), (-1.0, 0, 0, 0, 0, 0), 1.5),  # of their sum
        ((0, 0, 0, 4.0, 0, 0), (5.0, 0, 0, 0, 0, 0), 48.0 / 73.0),  # shear: 3 of its square
        ((-1.0, -1.0, -1.0, 0, 0, 0), (2.0, 0, 0, 0, 0, 0), 0.0),  # none of pressure from all sides
    ],
)
def test_shares_of_two_stresses_are_those_by_hand(one, other, share):
    found = shares({"one": 1e6 * np.array([one]), "other": 1e6 * np.array([other])})
    assert found["one"] == pytest.approx(share)
    assert found["other"] == pytest.approx(1.0 - share)


def test_shares_of_no_stress_are_zero():
    assert shares({"nothing": np.zeros((2, 6))})["nothing"].tolist() == [0.0, 0.0]


@pytest.fixture(scope="module")
def run_on_cells() -> History:
    """Three shoes on sand, of which the middle one bends."""
    changes = {"track.shoe_count": 3, "loads": LoadCycle.propel(3), "flexible.shoes": (2,)}
    case = Case.stress(SMALL_SHOE).with_(changes)
    return simulate(case.on_cells(BekkerSoil.lete_sand()), 0.02, False)


def test_shares_of_the_loads_of_a_run_add_up_to_one(flexible_run):
    history, table = flexible_run[0], flexible_run[2][13]
    rows = np.resize([3, 20, history.time.size - 1], len(NODES))
    for one in (by_modes_alone(history), history):
        found = load_shares(stress_basis(one), 13, NODES, rows)
        loads = ("pins", "machine load", "ground", "drive", "inertia")
        assert set(found) == {f"contribution of {load}" for load in loads}
        assert found.sum(axis=1).to_numpy() == pytest.approx(1.0, abs=1e-9)
    rows = np.searchsorted(history.time.values, table["time"].to_numpy())
    again = load_shares(stress_basis(history), 13, table["node"].to_numpy(), rows)
    for name, own in again.items():
        assert table[name].to_numpy() == pytest.approx(own.to_numpy())


@pytest.mark.simulation
@pytest.mark.slow
def test_shares_on_cells_are_complete(run_on_cells):
    """Stresses of all loads, those of the cells' forces among them, are the stress that is recovered."""
    rows = np.resize([0, 3, run_on_cells.time.size - 1], len(NODES))
    for one in (by_modes_alone(run_on_cells), run_on_cells):
        basis = stress_basis(one)
        found = load_shares(basis, 2, NODES, rows)
        assert found.sum(axis=1).to_numpy() == pytest.approx(1.0, abs=1e-9)
        assert found["contribution of ground"].abs().min() > 1e-3
        modes, parts = basis.shapes.stress_modes[NODES], basis.by_load(2, rows)
        summed = sum(np.einsum("kcm,km->kc", modes, q) for q in parts.values())
        stress = np.einsum("kcm,km->kc", modes, basis.coordinates[2][rows])
        np.testing.assert_allclose(summed, stress, rtol=0.0, atol=1e-7 * np.abs(stress).max())


@pytest.mark.simulation
@pytest.mark.parametrize("load", list(OTHERS))
@pytest.mark.parametrize(
    ("run", "shoe"), [("history", 7), pytest.param("run_on_cells", 2, marks=pytest.mark.slow)]
)
def test_a_load_that_acts_alone_has_all_of_the_stress(request, run, shoe, load):
    """Its modes have come to rest under it, so that there is no inertia, either."""
    whole = request.getfixturevalue(run)
    dataset = whole.dataset.isel(time=[-1]).copy(deep=True)
    for name in OTHERS[load]:
        for one in set(CONTACT) & set(dataset) if name == "contact" else (name,):
            dataset[one] = 0.0 * dataset[one]
    loaded = History(whole.case, dataset)
    for history in (by_modes_alone(loaded), loaded):
        inside = unit_loads(history.case).integrated.inside
        still = modal_loads(history, shoe) @ inside / (2.0 * np.pi * history.frequency.values) ** 2
        history.modal_coordinate.loc[{"flexible_shoe": shoe}] = still
        found = load_shares(stress_basis(history, [shoe]), shoe, NODES, np.zeros(len(NODES), dtype=int))
        assert found[f"contribution of {load}"].to_numpy() == pytest.approx(1.0, abs=1e-9)
        assert np.abs(found.drop(columns=f"contribution of {load}").to_numpy()).max(initial=0.0) < 1e-9


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


def test_flat_triangles_close_the_surface_and_follow_its_round_parts():
    mesh = mesh_named("coarse")
    fine, corners = flat_triangles(mesh.boundary), mesh.boundary[:, :3]
    edges = np.sort(np.concatenate([fine[:, [0, 1]], fine[:, [1, 2]], fine[:, [2, 0]]]))
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert np.array_equal(np.unique(fine), mesh.surface_nodes)
    off = abs(volume(mesh.nodes, fine) - mesh.volume)
    assert off < 0.3 * abs(volume(mesh.nodes, corners) - mesh.volume)
    assert off < 1e-3 * mesh.volume
