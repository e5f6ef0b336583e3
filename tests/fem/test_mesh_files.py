"""Reading and writing meshes: what cannot be used is refused by name."""

import gzip
from pathlib import Path

import meshio
import numpy as np
import pytest

import fem
from tests.fem.bodies import box_mesh


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("suffix", [".msh", ".msh.gz"])
def test_what_is_written_is_read_and_nothing_printed(tmp_path: Path, capfd, order: int, suffix: str) -> None:
    """Also of a format that one of meshio's readers fails for."""
    mesh = box_mesh((1, 2, 1), (1.0, 1.0, 1.0), order=order)
    named = fem.Mesh(mesh.nodes, mesh.elements, {"all": mesh.boundary, "two": mesh.boundary[:2]})
    fem.write_mesh(tmp_path / f"m{suffix}", named)
    back = fem.read_mesh(tmp_path / f"m{suffix}")
    assert back.digest == named.digest
    assert set(back.surfaces) == {"all", "two"}
    assert capfd.readouterr() == ("", "")


def test_vtu_without_surfaces(tmp_path: Path, cube: fem.Mesh) -> None:
    fem.write_vtu(tmp_path / "m.vtu", cube, {})
    back = fem.read_mesh(tmp_path / "m.vtu")
    np.testing.assert_array_equal(back.elements, cube.elements)
    assert back.surfaces == {}


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nothing"):
        fem.read_mesh(tmp_path / "nothing.msh")


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.msh", b"junk", "it holds no mesh as ansys or gmsh"),
        (
            "a.msh",
            b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
            r"it holds no mesh as .*: \$Element section",
        ),
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
    with pytest.raises(fem.MeshError, match=f"must be a mesh that meshio can read.*({told})") as refused:
        fem.read_mesh(tmp_path / name)
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")


def test_no_tetrahedra(tmp_path: Path) -> None:
    meshio.write(tmp_path / "t.vtu", meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]))
    with pytest.raises(fem.MeshError, match=r"must hold tetrahedra .* got no solid elements"):
        fem.read_mesh(tmp_path / "t.vtu")


def test_mixed_elements(tmp_path: Path) -> None:
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    cells = [("tetra", [[0, 1, 2, 4]]), ("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])]
    meshio.write(tmp_path / "m.vtu", meshio.Mesh(cube, cells))
    with pytest.raises(fem.MeshError, match="one kind of solid elements, got 1 tetra, 1 hexahedron"):
        fem.read_mesh(tmp_path / "m.vtu")
