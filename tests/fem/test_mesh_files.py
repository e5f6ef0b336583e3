"""Files of gmsh, Salome and others: all names of a face count, and what has no names says what to do."""

import gzip

import meshio
import numpy as np
import pytest

import fem
from fem.files import deck_lines, mesh_files
from tests.fem.bodies import box_mesh
from tests.fem.decks import Shells, areas, same_faces, solids_text, write_med, write_msh41
from tests.fem.refusals import refused

NAMES = [(2, 1, "top"), (2, 2, "path"), (2, 3, "under side's"), (3, 1, "solid"), (3, 2, "top")]
"""Dimension, number and name of physical groups: one name is that of a surface and of a volume."""
GROUPS = {1: [1, -2], 2: [1], 3: [3], 0: [1, 2]}
"""Groups of the geometric surfaces and of the volume: the path is a part of the top."""
AREAS = {"top": 2.0, "path": 1.0, "under side's": 2.0}
"""m2"""


@pytest.fixture(scope="module", params=[1, 2])
def box(request) -> fem.Mesh:
    return box_mesh((2, 1, 1), (2.0, 1.0, 1.0), order=request.param)


@pytest.fixture(scope="module")
def patches(box) -> dict[int, np.ndarray]:
    """Faces of the path, of the rest of the top, of the underside and of one side."""
    corners = box.nodes[box.boundary[:, :3]]
    top = np.isclose(corners[:, :, 2], 1.0).all(axis=1)
    path = top & (corners[:, :, 0].max(axis=1) <= 1.0)
    under = np.isclose(corners[:, :, 2], 0.0).all(axis=1)
    side = np.isclose(corners[:, :, 1], 0.0).all(axis=1)
    return {k: box.boundary[faces] for k, faces in enumerate((path, top & ~path, under, side), start=1)}


def assert_whole(mesh: fem.Mesh, box: fem.Mesh) -> None:
    np.testing.assert_array_equal(mesh.elements, box.elements)
    np.testing.assert_array_equal(mesh.nodes, box.nodes)
    assert areas(mesh) == pytest.approx(AREAS)


@pytest.mark.parametrize("options", [{}, {"binary": True}, {"parametric": True}, {"binary": True, "size": 4}])
def test_a_face_in_two_groups_has_both_names(tmp_path, box, patches, options):
    """Beside a surface without a group, as gmsh saves all, and one name of a volume and a surface."""
    write_msh41(tmp_path / "m.msh", box, patches, GROUPS, NAMES, **options)
    assert_whole(fem.read_mesh(tmp_path / "m.msh"), box)
    bodies = fem.read_volume(tmp_path / "m.msh").cell_sets
    assert {name: len(numbers) for name, numbers in bodies.items()} == {
        "solid": len(box.elements),
        "top": len(box.elements),
    }


@pytest.mark.parametrize("binary", [False, True])
def test_version_2_has_a_copy_of_a_cell_for_each_group(tmp_path, box, patches, binary):
    triangle = {3: "triangle", 6: "triangle6"}[box.boundary.shape[1]]
    tetrahedron = {4: "tetra", 10: "tetra10"}[box.elements.shape[1]]
    cells = []
    tags = []
    for number, groups in GROUPS.items():
        for group in groups:
            cells.append((triangle, patches[number]) if number else (tetrahedron, box.elements))
            tags.append(np.full(len(cells[-1][1]), abs(group)))
    # meshio has one name for one group
    names = {name: np.array([number, dimension]) for dimension, number, name in NAMES[:4]}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    raw = meshio.Mesh(box.nodes, cells, cell_data=data, field_data=names)
    meshio.write(tmp_path / "m.msh", raw, "gmsh22", binary=binary)
    if not binary:
        text = (
            (tmp_path / "m.msh").read_text().replace("$PhysicalNames\n4\n", '$PhysicalNames\n5\n3 2 "top"\n')
        )
        text = text.replace("$Nodes", "$ParametricNodes").replace("$EndNodes", "$EndParametricNodes")
        (tmp_path / "m.msh").write_text(text)
    assert_whole(fem.read_mesh(tmp_path / "m.msh"), box)


def test_groups_without_names_or_without_elements_are_noted(tmp_path, box, patches):
    write_msh41(tmp_path / "m.msh", box, patches, GROUPS, [])
    mesh = fem.read_mesh(tmp_path / "m.msh")
    assert mesh.surfaces == {}
    assert mesh.notes == ("physical surfaces without a name are left out, of the numbers 1, 2, 3",)
    write_msh41(tmp_path / "m.msh", box, patches, {}, NAMES[:2])
    (note,) = fem.read_mesh(tmp_path / "m.msh").notes
    assert note.startswith("no elements are in the physical surfaces 'top', 'path'")
    assert "Mesh.SaveAll" in note


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((b"4.1 0 8", b"4 0 8"), "version must be 4.1 or 2.2, got 4; save it in version 4.1 or 2.2"),
        ((b"$MeshFormat\n4.1 0 8\n$EndMeshFormat", b"$NOD"), r"must begin with \$MeshFormat, got \$NOD"),
        ((b"$Entities", b"$PartitionedEntities"), "must not be partitioned"),
        ((b"$EndElements", b""), r"end of its section \$Elements, it ends early"),
        ((b"$Nodes\n1 ", b"$Nodes\n2 "), "it ends early"),
        ((b"$Nodes\n1 ", b"$Nodes\n1x "), "could not convert string to float"),
    ],
)
def test_other_and_broken_files_of_gmsh_say_what_to_do(tmp_path, box, patches, change, words):
    write_msh41(tmp_path / "m.msh", box, patches, GROUPS, NAMES)
    (tmp_path / "m.msh").write_bytes((tmp_path / "m.msh").read_bytes().replace(*change))
    refused(f"m.msh must be a mesh .*{words}", fem.read_mesh, tmp_path / "m.msh", error=fem.MeshError)


@pytest.mark.parametrize("suffix", ["", ".gz"])
def test_groups_of_med_families_are_surfaces_and_fields_do_not_matter(tmp_path, box, patches, suffix):
    place = {tuple(face): row for row, face in enumerate(box.boundary.tolist())}
    family_of = np.zeros(len(box.boundary), dtype=np.int64)
    for number in (1, 2, 3):
        family_of[[place[tuple(face)] for face in patches[number].tolist()]] = -number
    families = {-1: ["top", "path"], -2: ["top"], -3: ["under side's"]}
    write_med(tmp_path / "m.med", box, families, family_of)
    if suffix:
        (tmp_path / "m.med.gz").write_bytes(gzip.compress((tmp_path / "m.med").read_bytes()))
    mesh = fem.read_mesh(tmp_path / f"m.med{suffix}")
    assert areas(mesh) == pytest.approx(AREAS)
    assert mesh.volume == pytest.approx(2.0)
    assert same_faces(mesh, "top", box.with_surfaces({"top": np.vstack((patches[1], patches[2]))}))
    count = len(box.elements)
    assert mesh.notes == (f"{count} of {count} elements are numbered in the other sense and were turned",)


def test_shells_of_nodes_that_are_not_there_are_refused(tmp_path, box):
    family_of = np.full(len(box.boundary), -1)
    wild = type("Wild", (), {"nodes": box.nodes, "elements": box.elements, "order": box.order})()
    wild.boundary = box.boundary + len(box.nodes)
    write_med(tmp_path / "m.med", wild, {-1: ["top"]}, family_of)
    words = "m.med: elements must refer to nodes of the file, got .* that do not: 0, 1"
    refused(words, fem.read_mesh, tmp_path / "m.med", error=fem.MeshError)


def test_broken_med_files_are_refused_in_a_line(tmp_path):
    (tmp_path / "m.med").write_bytes(b"junk")
    refused(
        "m.med must be a mesh .* not an HDF5 file", fem.read_mesh, tmp_path / "m.med", error=fem.MeshError
    )


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".bdf"])
def test_formats_without_names_say_which_ones_have_names(tmp_path, monkeypatch, box, suffix):
    monkeypatch.chdir(tmp_path)
    kinds = {4: ("tetra", "triangle"), 10: ("tetra10", "triangle6")}[box.elements.shape[1]]
    raw = meshio.Mesh(box.nodes, [(kinds[0], box.elements), (kinds[1], box.boundary)])
    meshio.write(f"m{suffix}", raw)
    mesh = fem.read_mesh(f"m{suffix}")
    assert mesh.volume == pytest.approx(2.0)
    assert mesh.surfaces == {}
    assert mesh.notes[0].startswith(f"{suffix} brings no named surfaces: save the mesh as .msh with physical")


def test_what_meshio_does_not_read_says_which_formats_to_use(tmp_path, monkeypatch, cube):
    """Shells beside quadratic tetrahedra in XDMF."""
    monkeypatch.chdir(tmp_path)
    meshio.write(
        "m.xdmf", meshio.Mesh(cube.nodes, [("tetra10", cube.elements), ("triangle6", cube.boundary)])
    )
    words = (
        r"m.xdmf must be .* does not know 38 in it: a kind of element, or a name; save it as .msh with phys"
    )
    refused(words, fem.read_mesh, "m.xdmf", error=fem.MeshError)


@pytest.mark.parametrize("name", ["m.msh.gz", "m.vtu.gz", "m.inp"])
def test_what_is_larger_than_any_mesh_is_not_unpacked(tmp_path, monkeypatch, name):
    for module in (mesh_files, deck_lines):
        monkeypatch.setattr(module, "LARGEST_FILE", 3 << 20)
    zeros = b"0" * (5 << 20)
    (tmp_path / name).write_bytes(gzip.compress(zeros) if name.endswith(".gz") else zeros)
    refused("it must be at most 3 MiB large", fem.read_mesh, tmp_path / name, error=fem.MeshError)


def test_a_broken_archive_is_refused(tmp_path, box):
    fem.write_mesh(tmp_path / "m.msh.gz", box)
    content = (tmp_path / "m.msh.gz").read_bytes()
    for broken in (content[: len(content) // 2], content[:40] + b"\0\0\0\0" + content[44:]):
        (tmp_path / "m.msh.gz").write_bytes(broken)
        refused("m.msh.gz must be a mesh .*", fem.read_mesh, tmp_path / "m.msh.gz", error=fem.MeshError)


CHANGES = [b"", b"\n", b",", b"-1", b"999999999999", b"*", b"$", b"nan", b"\0\0\0\0", b"1e308"]
"""What takes the place of some bytes of a file."""


@pytest.mark.filterwarnings("ignore::fem.MeshWarning")
@pytest.mark.parametrize("name", ["a.inp", "text.msh", "binary.msh", "m.med"])
def test_changed_files_are_meshes_or_refused_in_a_line(tmp_path, box, patches, name):
    rng = np.random.default_rng(5)
    named = box.with_surfaces({"top": patches[2]})
    path = tmp_path / name
    if name == "m.med":
        write_med(path, box, {-1: ["top"]}, np.full(len(box.boundary), -1))
    elif name == "a.inp":
        shells = Shells(named, ["top"], "S3")
        kind = {1: "C3D4", 2: "C3D10"}[box.order]
        path.write_text(f"{solids_text(box, kind)}{shells.text}*ELSET, ELSET=top, GENERATE\n100000, 100001\n")
    else:
        write_msh41(path, box, patches, GROUPS, NAMES, binary=name == "binary.msh")
    content = path.read_bytes()
    refusals = []
    for _ in range(60):
        first = int(rng.integers(len(content)))
        change = CHANGES[rng.integers(len(CHANGES))]
        path.write_bytes(content[:first] + change + content[first + int(rng.integers(1, 9)) :])
        try:
            fem.read_mesh(path)
        except fem.MeshError as error:
            refusals.append(str(error))
    assert all(name in refusal and "\n" not in refusal for refusal in refusals)
    assert len(refusals) > 5
