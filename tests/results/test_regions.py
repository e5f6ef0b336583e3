"""Regions of a shoe by which hot spots and lives are told apart."""

import numpy as np
import pytest

from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.results.stress.hot_spots import REGIONS, shoe_regions
from fem import Shapes
from meshes import STEEL, joint_interfaces, mesh_named

TRACK = Track.ph4100c()
LUG_ROOTS = ((-0.1837, 0.652, -0.0725), (-0.1837, -0.522, 0.1675), (0.2023, -0.7951, 0.0708))
"""m: the S-paper's hot spots beside the inner faces of the rear lugs, and the root of a fork's cheek."""


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
    tips = np.abs(shoe.nodes[:, 1]) > 1.7
    assert set(regions[tips]) == {"wings"}


@pytest.mark.parametrize("place", LUG_ROOTS)
def test_roots_of_lugs_are_lugs(shoe, place):
    nearest = int(np.linalg.norm(shoe.nodes - place, axis=1).argmin())
    assert np.linalg.norm(shoe.nodes[nearest] - place) < 0.03
    assert shoe_regions(shoe, TRACK)[nearest] == "lugs"


def test_shoe_without_rails_has_neither_roller_path_nor_wings(shoe):
    mesh = shoe.mesh.with_surfaces({})
    del mesh.surfaces["rails"]
    assert set(shoe_regions(bare(mesh), TRACK)) == {"lugs", "bores", "web"}
