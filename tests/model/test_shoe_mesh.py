"""Meshes of flexible shoes that do not fit their track or its rigid shoes are refused by name."""

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, Shoe, run_case
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.model.flexible_shoes import check_shoe
from fem import Mesh, write_mesh
from meshes import shoe_mesh, shoe_path

CASE = Case.stress("coarse")
MESH = shoe_mesh("coarse")
WIDER = MESH.nodes * [1.0, 1.02, 1.0]


def of_mesh(folder, mesh):
    """The stress study's case with another mesh as a file."""
    path = folder / "shoe.msh"
    write_mesh(path, mesh)
    return CASE.with_(flexible=CASE.part(FlexibleShoes).with_(mesh=str(path)))


def changed(nodes=MESH.nodes, leave_out=""):
    """The mesh with other nodes or without a surface."""
    surfaces = {name: faces for name, faces in MESH.surfaces.items() if name != leave_out}
    return Mesh(nodes, MESH.elements, surfaces)


def linear():
    """The mesh without the nodes in the middle of edges."""
    used, numbers = np.unique(MESH.elements[:, :4], return_inverse=True)
    surfaces = {name: np.searchsorted(used, faces[:, :3]) for name, faces in MESH.surfaces.items()}
    return Mesh(MESH.nodes[used], numbers.reshape(-1, 4), surfaces)


UNFIT = {
    "in mm": (
        changed(1e3 * MESH.nodes),
        r"must be in m and no larger than 50 m, but it is 3505 m long; is it in mm\?",
    ),
    "wider": (
        changed(WIDER),
        r"must have the underside of the case's shoes within 0\.005 m, .* it has .*'right': -1\.7",
    ),
    "longer": (changed(MESH.nodes * [1.002, 1.0, 1.0]), "must meet the track's pins within 0.001 m"),
    "no underside": (changed(leave_out="underside"), "must have the surface 'underside'"),
    "no top": (changed(leave_out="top"), "'whole top', which follows from 'top'"),
    "linear": (linear(), r"must have tetrahedra with 10 nodes, .* \(gmsh -order 2\)"),
}


@pytest.mark.parametrize(("mesh", "told"), UNFIT.values(), ids=UNFIT)
def test_a_mesh_that_does_not_do_is_refused_before_anything_is_written(tmp_path, mesh, told):
    with pytest.raises(ValueError, match=told):
        run_case(CaseFile(case=of_mesh(tmp_path, mesh), duration=0.01), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.simulation
def test_a_shoe_as_its_mesh_has_it():
    shoe, paper = Shoe.from_mesh(MESH), CASE.shoe
    assert shoe == Shoe.from_mesh("coarse") == Shoe.from_mesh(shoe_path("coarse"))
    assert shoe.mass == pytest.approx(MESH.volume * 7847.25, rel=1e-9)
    assert shoe.mass == pytest.approx(paper.mass, rel=5e-3)
    assert shoe.inertia_tensor == pytest.approx(paper.inertia_tensor, rel=0.02, abs=20.0)
    assert shoe.footprint == pytest.approx(paper.footprint, abs=1e-4)
    # the papers' load point is on the top without the wings, which are lower
    top = Shoe.from_mesh(MESH, load_surface="top").load_point[2]
    assert top == pytest.approx(paper.load_point[2], abs=1e-3)
    assert shoe.load_point[2] < paper.load_point[2]
    assert Shoe.from_mesh(MESH, density=7000.0).mass == pytest.approx(MESH.volume * 7000.0, rel=1e-9)


def test_a_shoe_of_a_stretched_mesh_fits_it(tmp_path):
    case = of_mesh(tmp_path, changed(WIDER))
    wider = case.with_(shoe=Shoe.from_mesh(case.flexible.mesh))
    check_shoe(wider)
    assert wider.shoe.width == pytest.approx(1.02 * CASE.shoe.width, rel=1e-6)


@pytest.mark.parametrize(
    ("size", "told"),
    [
        # the unit is told before the origin
        (1e3, r"^the mesh must be in m and no larger .*is 3505 m long; is it in mm\?$"),
        (1e2, r"^the mesh must be in m and no larger .*is 350\.5 m long; is it in mm or cm\?$"),
        (1.0 / 0.0254, r"^the mesh must be in m and no larger .*is 138 m long; is it in cm or inch\?$"),
        (1e6, r"^the mesh must be in m and no larger .*is 3\.505e\+06 m long$"),
        (1.0, r"mesh must have its origin at its COM within 0\.01 m"),
    ],
)
def test_a_mesh_in_another_unit_or_off_its_com_gives_no_shoe(size, told):
    with pytest.raises(ValueError, match=told):
        Shoe.from_mesh(changed(size * (MESH.nodes + np.array([0.0, 0.0, 0.1]))))


@pytest.mark.parametrize(
    ("lacking", "told"),
    [
        ("underside", r"the mesh '.*shoe\.msh' must have the surface 'underside', which has \['bore"),
        ("top", r"load_surface must be a surface of the mesh '.*shoe\.msh', which has \['bore .*'top'"),
    ],
)
def test_a_mesh_without_a_surface_gives_no_shoe(tmp_path, lacking, told):
    with pytest.raises(ValueError, match=told):
        Shoe.from_mesh(of_mesh(tmp_path, changed(leave_out=lacking)).flexible.mesh)
