"""Reading and checking meshes: every fault is named with its number and place."""

from pathlib import Path

import meshio
import numpy as np
import pytest

import fem
from tests.fem.conftest import STEEL, box_mesh


@pytest.fixture
def cube() -> fem.Mesh:
    return box_mesh((1, 1, 1), (1.0, 1.0, 1.0))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("suffix", [".msh", ".msh.gz"])
def test_write_and_read(tmp_path: Path, order: int, suffix: str) -> None:
    mesh = box_mesh((1, 2, 1), (1.0, 1.0, 1.0), order=order)
    named = fem.Mesh(mesh.nodes, mesh.elements, {"all": mesh.boundary, "two": mesh.boundary[:2]})
    fem.write_mesh(tmp_path / f"m{suffix}", named)
    back = fem.read_mesh(tmp_path / f"m{suffix}")
    assert back.digest == named.digest
    assert set(back.surfaces) == {"all", "two"}


def test_vtu_without_surfaces(tmp_path: Path, cube: fem.Mesh) -> None:
    fem.write_vtu(tmp_path / "m.vtu", cube, {})
    back = fem.read_mesh(tmp_path / "m.vtu")
    np.testing.assert_array_equal(back.elements, cube.elements)
    assert back.surfaces == {}


def test_boundary_of_a_box_is_its_skin(cube: fem.Mesh) -> None:
    body = fem.ElasticBody(cube, STEEL)
    assert body.surface_weights(cube.boundary).sum() == pytest.approx(6.0, rel=1e-12)
    corners = cube.nodes[cube.boundary[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normals, corners.mean(axis=1) - 0.5)
    assert (outward > 0).all()


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nothing"):
        fem.read_mesh(tmp_path / "nothing.msh")


def test_no_mesh(tmp_path: Path) -> None:
    (tmp_path / "text.msh").write_text("this is no mesh")
    with pytest.raises(fem.MeshError, match="no mesh that meshio can read"):
        fem.read_mesh(tmp_path / "text.msh")


def test_no_tetrahedra(tmp_path: Path) -> None:
    meshio.write(tmp_path / "t.vtu", meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]))
    with pytest.raises(fem.MeshError, match="no tetrahedra"):
        fem.read_mesh(tmp_path / "t.vtu")


def test_mixed_elements(tmp_path: Path) -> None:
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    cells = [("tetra", [[0, 1, 2, 4]]), ("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])]
    meshio.write(tmp_path / "m.vtu", meshio.Mesh(cube, cells))
    with pytest.raises(fem.MeshError, match="1 tetra, 1 hexahedron"):
        fem.read_mesh(tmp_path / "m.vtu")


def test_inverted_elements(cube: fem.Mesh) -> None:
    elements = cube.elements.copy()
    elements[3, [0, 1]] = elements[3, [1, 0]]
    with pytest.raises(fem.MeshError, match=r"1 of \d+ elements are inverted or flat: 3"):
        fem.Mesh(cube.nodes, elements, {})


def test_element_turned_inside_out_by_a_mid_side_node(cube: fem.Mesh) -> None:
    nodes = cube.nodes.copy()
    nodes[cube.elements[0, 4]] += 2.0 * (nodes[cube.elements[0, 3]] - nodes[cube.elements[0, 0]])
    with pytest.raises(fem.MeshError, match="inverted"):
        fem.Mesh(nodes, cube.elements, {})


def test_loose_nodes(cube: fem.Mesh) -> None:
    with pytest.raises(fem.MeshError, match=f"1 loose nodes .*: {len(cube.nodes)}"):
        fem.Mesh(np.vstack([cube.nodes, [9.0, 9.0, 9.0]]), cube.elements, {})


def test_disconnected_bodies(cube: fem.Mesh) -> None:
    nodes = np.vstack([cube.nodes, cube.nodes + 5.0])
    with pytest.raises(fem.MeshError, match="2 disconnected bodies"):
        fem.Mesh(nodes, np.vstack([cube.elements, cube.elements + len(cube.nodes)]), {})


def test_coordinates_not_finite(cube: fem.Mesh) -> None:
    nodes = cube.nodes.copy()
    nodes[4, 1] = np.nan
    with pytest.raises(fem.MeshError, match="1 nodes have coordinates that are not finite: 4"):
        fem.Mesh(nodes, cube.elements, {})


def test_nodes_that_do_not_exist(cube: fem.Mesh) -> None:
    elements = cube.elements.copy()
    elements[2, 5] = 1000
    with pytest.raises(fem.MeshError, match="1 elements refer to nodes outside"):
        fem.Mesh(cube.nodes, elements, {})


def test_surface_off_the_boundary(cube: fem.Mesh) -> None:
    faces = cube.boundary[:2].copy()
    faces[1, 0] = (set(range(len(cube.nodes))) - set(faces[1].tolist())).pop()
    with pytest.raises(fem.MeshError, match="surface 'odd': 1 of 2 triangles"):
        fem.Mesh(cube.nodes, cube.elements, {"odd": faces})


def test_unknown_surface(cube: fem.Mesh) -> None:
    with pytest.raises(KeyError, match="no surface 'lid'"):
        cube.surface("lid")
