"""Checks of a mesh: every fault is named with its number and place."""

import numpy as np
import pytest

import fem
from meshes import STEEL


def test_boundary_of_a_box_is_its_skin(cube: fem.Mesh) -> None:
    body = fem.ElasticBody(cube, STEEL)
    assert body.surface_weights(cube.boundary).sum() == pytest.approx(6.0, rel=1e-12)
    corners = cube.nodes[cube.boundary[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normals, corners.mean(axis=1) - 0.5)
    assert (outward > 0).all()


def test_inverted_elements(cube: fem.Mesh) -> None:
    elements = cube.elements.copy()
    elements[3, [0, 1]] = elements[3, [1, 0]]
    with pytest.raises(fem.MeshError, match=r"neither inverted nor flat, got 1 of \d+ that are: 3"):
        fem.Mesh(cube.nodes, elements, {})


def test_element_turned_inside_out_by_a_mid_side_node(cube: fem.Mesh) -> None:
    nodes = cube.nodes.copy()
    nodes[cube.elements[0, 4]] += 2.0 * (nodes[cube.elements[0, 3]] - nodes[cube.elements[0, 0]])
    with pytest.raises(fem.MeshError, match="inverted"):
        fem.Mesh(nodes, cube.elements, {})


def test_elements_that_come_twice(cube: fem.Mesh) -> None:
    turned = cube.elements[[5, 2]][:, [1, 2, 0, 3, *((5, 6, 4, 8, 9, 7) if cube.order == 2 else ())]]
    told = rf"must be different, got 2 of {len(cube.elements)} more than once: 2, 5"
    with pytest.raises(fem.MeshError, match=told):
        fem.Mesh(cube.nodes, np.vstack([cube.elements, turned]), {})


def test_volume_is_that_of_the_elements_curved_edges_included(cube: fem.Mesh) -> None:
    assert cube.volume == pytest.approx(1.0, rel=1e-12)
    # every node moves, so that edges bend; the mass matrix integrates the same determinant
    bent = cube.nodes + 0.05 * np.sin(3.0 * cube.nodes[:, [1, 2, 0]])
    mesh = fem.Mesh(bent, cube.elements, {})
    assert mesh.volume * STEEL.density == pytest.approx(fem.ElasticBody(mesh, STEEL).mass, rel=1e-10)


def test_loose_nodes(cube: fem.Mesh) -> None:
    with pytest.raises(fem.MeshError, match=f"got 1 loose ones: {len(cube.nodes)}"):
        fem.Mesh(np.vstack([cube.nodes, [9.0, 9.0, 9.0]]), cube.elements, {})


def test_disconnected_bodies(cube: fem.Mesh) -> None:
    nodes = np.vstack([cube.nodes, cube.nodes + 5.0])
    with pytest.raises(fem.MeshError, match="must be one body, got 2 disconnected ones"):
        fem.Mesh(nodes, np.vstack([cube.elements, cube.elements + len(cube.nodes)]), {})


def test_coordinates_not_finite(cube: fem.Mesh) -> None:
    nodes = cube.nodes.copy()
    nodes[4, 1] = np.nan
    with pytest.raises(fem.MeshError, match="nodes must be finite, got 1 that are not: 4"):
        fem.Mesh(nodes, cube.elements, {})


def test_nodes_that_do_not_exist(cube: fem.Mesh) -> None:
    elements = cube.elements.copy()
    elements[2, 5] = 1000
    with pytest.raises(fem.MeshError, match=r"nodes in 0\.\.\d+, got 1 that do not: 2"):
        fem.Mesh(cube.nodes, elements, {})


def test_surface_off_the_boundary(cube: fem.Mesh) -> None:
    faces = cube.boundary[:2].copy()
    faces[1, 0] = (set(range(len(cube.nodes))) - set(faces[1].tolist())).pop()
    with pytest.raises(fem.MeshError, match="'odd' must lie on the boundary, got 1 of 2 triangles off it: 1"):
        fem.Mesh(cube.nodes, cube.elements, {"odd": faces})


def test_unknown_surface(cube: fem.Mesh) -> None:
    with pytest.raises(KeyError, match=r"surface must be one of .* got 'lid'"):
        cube.surface("lid")
