"""Meshes of flexible shoes that do not fit their track or its rigid shoes are refused by name."""

import re

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, Shoe, run_case
from exudyn_crawler.model.flexible_shoes import check_shoe
from fem import Mesh, write_mesh
from meshes import shoe_mesh

CASE = Case.stress("coarse")
MESH = shoe_mesh("coarse")
OFF_ITS_COM = MESH.nodes + np.array([0.0, 0.0, 0.1])


def of_mesh(folder, mesh):
    """The stress study's case with another mesh as a file."""
    path = folder / "shoe.msh"
    write_mesh(path, mesh)
    return CASE.with_(flexible=CASE.flexible_shoes().with_(mesh=str(path)))


def changed(nodes=MESH.nodes, leave_out=""):
    """The mesh with other nodes or without a surface."""
    surfaces = {name: faces for name, faces in MESH.surfaces.items() if name != leave_out}
    return Mesh(nodes, MESH.elements, surfaces)


@pytest.mark.parametrize(
    ("stretch", "told"),
    [
        ([1e3, 1e3, 1e3], r"must be in m and no larger than 50 m, it is 3505 m long; is it in mm\?"),
        (
            [1.0, 1.02, 1.0],
            r"must have the underside of the case's shoes within 0\.005 m, .* it has .*'right': -1\.7",
        ),
        ([1.002, 1.0, 1.0], "must meet the track's pins within 0.001 m"),
    ],
)
def test_a_mesh_of_other_size_is_refused(tmp_path, stretch, told):
    with pytest.raises(ValueError, match=told):
        check_shoe(of_mesh(tmp_path, changed(MESH.nodes * stretch)))


def linear():
    """The mesh without the nodes in the middle of edges."""
    used, numbers = np.unique(MESH.elements[:, :4], return_inverse=True)
    surfaces = {name: np.searchsorted(used, faces[:, :3]) for name, faces in MESH.surfaces.items()}
    return Mesh(MESH.nodes[used], numbers.reshape(-1, 4), surfaces)


@pytest.mark.parametrize(
    ("mesh", "told"),
    [
        (changed(leave_out="underside"), "must have the surface 'underside'"),
        (changed(leave_out="top"), "'whole top', which follows from 'top'"),
        (linear(), r"must have tetrahedra with 10 nodes, .* \(gmsh -order 2\)"),
    ],
    ids=["no underside", "no top", "linear"],
)
def test_a_mesh_that_does_not_do_is_refused_before_anything_is_written(tmp_path, mesh, told):
    with pytest.raises(ValueError, match=told):
        run_case(CaseFile(case=of_mesh(tmp_path, mesh), duration=0.01), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.simulation
def test_a_shoe_as_its_mesh_has_it():
    shoe = Shoe.from_mesh(MESH)
    assert shoe == Shoe.from_mesh("coarse")
    paper = CASE.shoe
    assert shoe.mass == pytest.approx(MESH.volume * 7847.25, rel=1e-9)
    assert shoe.mass == pytest.approx(paper.mass, rel=5e-3)
    assert shoe.inertia_tensor == pytest.approx(paper.inertia_tensor, rel=0.02, abs=20.0)
    assert shoe.footprint == pytest.approx(paper.footprint, abs=1e-4)
    # the papers' load point is on the top without the wings, which are lower
    assert Shoe.from_mesh(MESH, load_surface="top").load_point[2] == pytest.approx(
        paper.load_point[2], abs=1e-3
    )
    assert shoe.load_point[2] < paper.load_point[2]
    assert Shoe.from_mesh(MESH, density=7000.0).mass == pytest.approx(MESH.volume * 7000.0, rel=1e-9)


def test_a_shoe_of_a_stretched_mesh_fits_it(tmp_path):
    case = of_mesh(tmp_path, changed(MESH.nodes * [1.0, 1.02, 1.0]))
    wider = case.with_(shoe=Shoe.from_mesh(case.flexible.mesh))
    check_shoe(wider)
    assert wider.shoe.width == pytest.approx(1.02 * CASE.shoe.width, rel=1e-6)


@pytest.mark.parametrize(
    ("size", "told"),
    [
        (1e3, "is 3505 m long; is it in mm?"),
        (1e2, "is 350.5 m long; is it in mm or cm?"),
        (1.0 / 0.0254, "is 138 m long; is it in cm or inch?"),
        (1e6, "is 3.505e+06 m long"),
    ],
)
def test_a_mesh_in_another_unit_is_told_before_its_origin(size, told):
    with pytest.raises(ValueError, match=f"^the mesh must be in m and no larger .*{re.escape(told)}$"):
        Shoe.from_mesh(changed(size * OFF_ITS_COM))


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


def test_a_mesh_whose_origin_is_not_its_com_gives_no_shoe():
    with pytest.raises(ValueError, match=r"mesh must have its origin at its COM within 0\.01 m"):
        Shoe.from_mesh(changed(OFF_ITS_COM))
