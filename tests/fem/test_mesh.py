"""Meshes and their files: every fault is named, with its number and place."""

import gzip

import meshio
import numpy as np
import pytest
from skfem import ElementTetP1
from skfem.quadrature import get_quadrature

import fem
from fem.body.elasticity import STIFFNESS_ORDER
from fem.body.mesh import STIFFNESS_POINTS
from meshes import STEEL
from tests.fem.bodies import box_mesh
from tests.fem.refusals import refused


def test_boundary_of_a_box_is_its_skin(cube):
    body = fem.ElasticBody(cube, STEEL)
    assert body.surface_weights(cube.boundary).sum() == pytest.approx(6.0, rel=1e-12)
    corners = cube.nodes[cube.boundary[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normals, corners.mean(axis=1) - 0.5)
    assert (outward > 0).all()


def changed(array: np.ndarray, where: object, value: object) -> np.ndarray:
    """A copy that has another value somewhere."""
    copy = array.copy()
    copy[where] = value
    return copy


def test_faults_are_named(cube):
    nodes, elements, count = cube.nodes, cube.elements, len(cube.nodes)
    across = 2.0 * (nodes[elements[0, 3]] - nodes[elements[0, 0]])
    inverted = changed(elements, (3, [0, 1]), elements[3, [1, 0]])
    twice = np.vstack([elements, elements[[5, 2]][:, [1, 2, 0, 3, 5, 6, 4, 8, 9, 7]]])
    two = np.vstack([elements, elements + count])
    for told, *mesh in (
        (r"neither inverted nor flat, got 1 of \d+ that are: 3", nodes, inverted),
        # by a mid-side node
        ("inverted", changed(nodes, elements[0, 4], nodes[elements[0, 4]] + across), elements),
        (f"must be different, got 2 of {len(elements)} more than once: 2, 5", nodes, twice),
        (f"got 1 loose ones: {count}", np.vstack([nodes, [9.0, 9.0, 9.0]]), elements),
        ("must be one body, got 2 disconnected ones", np.vstack([nodes, nodes + 5.0]), two),
        ("nodes must be finite, got 1 that are not: 4", changed(nodes, (4, 1), np.nan), elements),
        (r"nodes in 0\.\.\d+, got 1 that do not: 2", nodes, changed(elements, (2, 5), 1000)),
    ):
        refused(told, fem.Mesh, *mesh, {}, error=fem.MeshError)
    faces = cube.boundary[:2]
    odd = {"odd": changed(faces, (1, 0), np.setdiff1d(np.arange(count), faces[1])[0])}
    told = "'odd' must lie on the boundary, got 1 of 2 triangles off it: 1"
    refused(told, fem.Mesh, nodes, elements, odd, error=fem.MeshError)
    refused(r"surface must be one of .* got 'lid'", cube.surface, "lid", error=KeyError)


def test_elements_that_fold_at_a_node_alone_are_told_apart_and_straightened(cube):
    """The mid-side node nearer to a corner than a quarter of the edge folds it there."""
    corner, other, middle = cube.elements[3, [0, 1, 4]]
    away = cube.nodes[corner] - cube.nodes[other]
    bent = changed(cube.nodes, middle, cube.nodes[middle] + 0.27 * away)
    words = (
        r"inverted at a node, though not at their integration points: .*; the first is at \[.*straightened"
    )
    refused(words, fem.Mesh, bent, cube.elements, {}, error=fem.MeshError)
    content = fem.VolumeMesh(bent, cube.elements, {}, {}, {}, ())
    mesh = content.straightened().mesh()
    np.testing.assert_allclose(mesh.nodes, cube.nodes, atol=1e-12)
    assert mesh.notes[0].endswith("elements have straight edges")


def test_integration_points_are_those_of_the_stiffness():
    points, _ = get_quadrature(ElementTetP1, STIFFNESS_ORDER)
    expected = np.column_stack((1.0 - points.sum(axis=0), *points))
    np.testing.assert_allclose(sorted(STIFFNESS_POINTS.tolist()), sorted(expected.tolist()), atol=1e-9)


def test_volume_is_that_of_the_elements_curved_edges_included(cube):
    assert cube.volume == pytest.approx(1.0, rel=1e-12)
    # every node moves, so that edges bend; the mass matrix integrates the same determinant
    bent = cube.nodes + 0.05 * np.sin(3.0 * cube.nodes[:, [1, 2, 0]])
    mesh = fem.Mesh(bent, cube.elements, {})
    assert mesh.volume * STEEL.density == pytest.approx(fem.ElasticBody(mesh, STEEL).mass, rel=1e-10)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("suffix", [".msh", ".msh.gz"])
def test_what_is_written_is_read_and_nothing_printed(tmp_path, capfd, order, suffix):
    """Also of a format that one of meshio's readers fails for."""
    mesh = box_mesh((1, 2, 1), (1.0, 1.0, 1.0), order=order)
    named = fem.Mesh(mesh.nodes, mesh.elements, {"all": mesh.boundary, "two": mesh.boundary[:2]})
    fem.write_mesh(tmp_path / f"m{suffix}", named)
    back = fem.read_mesh(tmp_path / f"m{suffix}")
    assert back.digest == named.digest
    assert set(back.surfaces) == {"all", "two"}
    assert capfd.readouterr() == ("", "")


def test_vtu_without_surfaces(tmp_path, cube):
    fem.write_vtu(tmp_path / "m.vtu", cube, {})
    back = fem.read_mesh(tmp_path / "m.vtu")
    np.testing.assert_array_equal(back.elements, cube.elements)
    assert back.surfaces == {}


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.msh", b"junk", "it holds no mesh as ansys or gmsh"),
        ("a.msh", b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", r"it holds no gmsh mesh: \$Elements section"),
        ("a.msh.gz", gzip.compress(b"junk", mtime=0), "it holds no mesh as ansys or gmsh"),
        ("a.vtu", b"\0\1", "it holds no mesh as vtu"),
        ("a.msh", b"", "the file is empty"),
        ("a.inp", b"", "the file is empty"),
        ("a.msh.gz", gzip.compress(b"", mtime=0), "the file is empty"),
        ("a.msh.gz", b"", "the file is empty"),
        ("a.msh", b"\n\n", "it holds no mesh|got: "),
        ("a.odd", b"x", "got: Could not deduce file format"),
    ],
)
def test_what_is_no_mesh_is_told_in_a_line_alone(tmp_path, capfd, name, content, told):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(fem.MeshError, match=f"must be a mesh that can be read.*({told})") as error:
        fem.read_mesh(tmp_path / name)
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_files_that_are_none_or_hold_no_tetrahedra_alone(tmp_path):
    refused("nothing", fem.read_mesh, tmp_path / "nothing.msh", error=FileNotFoundError)
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    tetrahedron, hexahedron = ("tetra", [[0, 1, 2, 4]]), ("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])
    for points, cells, told in (
        (np.eye(3), [("triangle", [[0, 1, 2]])], r"must hold tetrahedra .* got no solid elements"),
        (corners, [tetrahedron, hexahedron], "one kind of solid elements, got 1 tetra, 1 hexahedron"),
    ):
        meshio.write(tmp_path / "m.vtu", meshio.Mesh(points, cells))
        refused(told, fem.read_mesh, tmp_path / "m.vtu", error=fem.MeshError)
