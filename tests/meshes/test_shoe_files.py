"""Makers' files become shoes: tetrahedra without sets, STL and STEP; broken ones are refused in a line."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fem
from fem.body.mesh import boundary_faces
from meshes.recognition.axes import Choices, NodesUnit
from meshes.recognition.elements import peeled
from meshes.recognition.quality import mesh_quality
from meshes.recognition.shoe import axes_of, differing_bores, recognize_file
from meshes.recognition.slivers import find_slivers, healed, suspects
from meshes.recognition.solids import StepSolid
from meshes.recognition.step_units import StepUnit
from meshes.recognition.surfaces import find_surfaces
from meshes.recognition.triangles import Triangles
from tests.meshes.swept import SweptShoe

TURN = Rotation.from_rotvec([0.3, 2.0, -0.7]).as_matrix()
NODES, TETS = SweptShoe(facets=12).mesh()
TURNED = (NODES @ TURN.T + (500.0, -80.0, 1200.0)).round(4)  # mm
BOUNDARY = boundary_faces(TETS)
VOLUME = 1e-9 * np.linalg.det(NODES[TETS][:, 1:] - NODES[TETS][:, :1]).sum() / 6.0  # m3


def written(path, points, blocks, **more):
    meshio.write(path, meshio.Mesh(points, blocks), **more)
    return path


def check_shoe(found):
    assert found.axes.unit == "mm"
    assert found.pitch == pytest.approx(0.25, abs=1e-6)
    np.testing.assert_allclose(found.axes.rows @ TURN, np.eye(3), atol=1e-5)
    assert found.joint_y == pytest.approx((-0.1, 0.1), abs=1e-5)
    assert found.mesh.volume == pytest.approx(VOLUME, rel=1e-6)
    body = fem.ElasticBody(found.mesh, fem.Material(200e9, 0.3, 7850.0))
    np.testing.assert_allclose(body.center_of_mass, 0.0, atol=1e-9)
    assert found.mesh.order == 2


@pytest.mark.parametrize("ending", ["inp", "bdf", "vtu", "msh"])
def test_tetrahedra_without_sets_are_recognized(tmp_path, ending):
    path = tmp_path / f"shoe.{ending}"
    if ending == "msh":
        written(path, TURNED, [("tetra", TETS)], file_format="gmsh22", binary=False)
    else:
        written(path, TURNED, [("tetra", TETS)])
    found = recognize_file(path)
    check_shoe(found)
    assert found.questions == ()
    assert any("mid-side nodes" in one for one in found.remarks)


def test_shells_and_beams_beside_the_solid_are_left_out_and_said(tmp_path):
    points = np.vstack((TURNED, [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]]))
    blocks = [("tetra", TETS), ("triangle", BOUNDARY[:40]), ("line", [[len(points) - 2, len(points) - 1]])]
    found = recognize_file(written(tmp_path / "shoe.vtu", points, blocks))
    check_shoe(found)
    assert any("1 elements of the kind line are left out" in one for one in found.remarks)
    assert any("2 nodes belong to no solid element" in one for one in found.remarks)


def test_bodies_apart_are_chosen_from(tmp_path):
    pin = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 30.0]]) + 9e3
    blocks = [("tetra", np.vstack((TETS, np.arange(4)[None] + len(TURNED))))]
    path = written(tmp_path / "two.vtu", np.vstack((TURNED, pin)), blocks)
    with pytest.raises(fem.MeshError, match=r"one body, got 2 .*--body N chooses one"):
        recognize_file(path)
    check_shoe(recognize_file(path, Choices(body="1")))
    with pytest.raises(fem.MeshError, match=r"--body must be a number in 1\.\.2"):
        recognize_file(path, Choices(body="3"))


def test_a_body_without_bores_is_refused_with_what_it_has(tmp_path):
    nodes, tets = SweptShoe(front=(), rear=()).mesh()
    path = written(tmp_path / "plate.vtu", nodes, [("tetra", tets)])
    with pytest.raises(
        ValueError, match=r"plate\.vtu: it must have round bores at both ends .* 1 of radius 15"
    ):
        recognize_file(path)


def test_a_shoe_in_no_unit_is_refused(tmp_path):
    path = written(tmp_path / "tiny.vtu", 1e-6 * NODES, [("tetra", TETS)])
    with pytest.raises(ValueError, match=r"must have a pitch of 0\.05 to 1\.5 m .* in mm, m, inch or cm"):
        recognize_file(path)


def test_a_unit_that_makes_no_shoe_is_refused_with_the_one_that_does():
    boundary = Triangles(NODES, BOUNDARY)
    times = VOLUME * 7850.0  # kg
    words = (
        r"is the unit wrong\? The file names cm, with which the shoe would have a pitch of 2\.5 m and "
        rf"{times:.4g} t of steel; shoes have .*; it would have a pitch of 0\.25 m and {times:.4g} kg in mm"
    )
    # as converted to mm
    with pytest.raises(ValueError, match=words):
        axes_of(replace(boundary, points=10.0 * NODES), Choices(), NodesUnit("mm", "cm", 1e-2))
    with pytest.raises(ValueError, match=r"with --unit cm the shoe would .* pitch of 0\.25 m and .* in mm"):
        axes_of(boundary, Choices(unit="cm"))
    # a flag does not change a unit that is known
    named = axes_of(boundary, Choices(unit="cm"), NodesUnit("mm", "cm", 1e-2))
    assert (named.unit, named.pins.pitch) == ("mm", pytest.approx(250.0))


def test_other_choices_and_files_are_refused_by_name(tmp_path):
    with pytest.raises(FileNotFoundError, match="no file nowhere"):
        recognize_file("nowhere.step")
    path = written(tmp_path / "shoe.vtu", TURNED, [("tetra", TETS)])
    with pytest.raises(ValueError, match="size must be one of coarse, study, fine, got 'huge'"):
        recognize_file(path, size="huge")
    with pytest.raises(ValueError, match=r"--pins must be in 1\.\.1"):
        recognize_file(path, Choices(pins=2))


CUT = b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
"""Beginning of an STL file, at which meshio would end the process."""


@pytest.mark.parametrize("content", [b"", b"solid nothing\nendsolid\n", b"\x00" * 84, b"ISO-10303-21;", CUT])
def test_broken_stl_files_are_refused(tmp_path, content):
    path = tmp_path / "broken.stl"
    path.write_bytes(content)
    with pytest.raises(fem.MeshError, match=r"broken\.stl must be"):
        recognize_file(path)


def test_an_stl_boundary_is_filled(tmp_path):
    pytest.importorskip("netgen")
    path = written(tmp_path / "shoe.stl", TURNED, [("triangle", BOUNDARY)])
    found = recognize_file(path, size="coarse")
    assert found.axes.unit == "mm"
    assert found.pitch == pytest.approx(0.25, abs=1e-6)
    assert found.mesh.volume == pytest.approx(VOLUME, rel=1e-5)
    assert mesh_quality(found.mesh).least > 0.01
    open_one = written(tmp_path / "open.stl", TURNED, [("triangle", BOUNDARY[3:])])
    with pytest.raises(
        fem.MeshError, match=r"open\.stl: its boundary must be closed, .* send the shoe as STEP"
    ):
        recognize_file(open_one)


def with_sliver(faces, height):
    """Points and boundary with one more corner, such part of its triangle's height off the longest edge."""
    areas = np.linalg.norm(
        np.cross(TURNED[faces[:, 1]] - TURNED[faces[:, 0]], TURNED[faces[:, 2]] - TURNED[faces[:, 0]]), axis=1
    )
    largest = int(areas.argmax())
    a, b, c = faces[largest]
    corner = np.array([0.5 - 0.5 * height, 0.5 - 0.5 * height, height]) @ TURNED[[a, b, c]]
    m = len(TURNED)
    return np.vstack((TURNED, corner)), np.vstack(
        (np.delete(faces, largest, axis=0), [(a, b, m), (b, c, m), (c, a, m)])
    )


def test_flat_elements_on_the_boundary_are_peeled_off():
    """Six tetrahedra of a cube, and a flat one on its top between other diagonals."""
    cube = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
    flat = np.array([False] * 6 + [True])
    np.testing.assert_array_equal(peeled(np.vstack((cube, [[4, 5, 7, 6]])), flat), cube)
    inner = np.vstack((cube, [[4, 5, 7, 6], [4, 5, 6, 8]]))
    assert len(peeled(inner, np.append(flat, False))) == 8


def test_slivers_of_an_stl_boundary_are_said_or_refused(tmp_path):
    pytest.importorskip("netgen")
    points, faces = with_sliver(BOUNDARY, 1e-2)
    found = recognize_file(written(tmp_path / "flat.stl", points, [("triangle", faces)]), size="coarse")
    assert found.pitch == pytest.approx(0.25, abs=1e-6)
    assert any("slivers among its triangles" in remark for remark in found.remarks)
    points, faces = with_sliver(BOUNDARY, 1e-4)
    path = written(tmp_path / "flatter.stl", points, [("triangle", faces)])
    with pytest.raises(fem.MeshError, match=r"flatter\.stl: slivers among the triangles .* send the shoe as"):
        recognize_file(path, size="coarse")


def plate_shoe(occ):
    """Shoe of a pitch of 200 mm: plate with a grouser, lugs ahead outside of those behind."""
    body = occ.Box(occ.Pnt(-95, -150, 0), occ.Pnt(95, 150, 20)) + occ.Box(
        occ.Pnt(-60, -150, -45), occ.Pnt(-40, 150, 0)
    )
    holes = []
    for x, root, y in ((100, -80, 120), (100, -80, -120), (-100, 80, 75), (-100, 80, -75)):
        low, high = (y, y + 40) if y > 0 else (y - 40, y)
        body += occ.Cylinder(occ.Pnt(x, low, 60), occ.Y, 30, high - low)
        body += occ.Box(occ.Pnt(min(x, root), low, 5), occ.Pnt(max(x, root), high, 90))
        holes.append(occ.Cylinder(occ.Pnt(x, low - 1, 60), occ.Y, 15, high - low + 2))
    for hole in holes:
        body -= hole
    return body


MILLI = "SI_UNIT(.MILLI.,.METRE.)"


@pytest.mark.parametrize("unit", ["m", *(pytest.param(unit, marks=pytest.mark.slow) for unit in ("mm", ""))])
def test_a_step_file_becomes_a_shoe(tmp_path, unit):
    occ = pytest.importorskip("netgen.occ")
    path = tmp_path / "plate.step"
    body = plate_shoe(occ)
    if unit == "m":
        body = body.Scale(occ.Pnt(0, 0, 0), 1e-3)
    body.WriteStep(str(path))
    # coordinates stay, and count in m, or in a unit that is not named
    text = path.read_text()
    if unit == "m":
        path.write_text(text.replace(MILLI, "SI_UNIT($,.METRE.)"))
    elif not unit:
        path.write_text(
            text.replace(f"LENGTH_UNIT() NAMED_UNIT(*) {MILLI}", "NAMED_UNIT(*) SI_UNIT($,.AMPERE.)")
        )
    found = recognize_file(path, Choices(unit=unit or None), size="coarse")
    if unit:
        assert found.unit == f"{unit}, named by the file"
        with pytest.raises(ValueError, match=rf"--unit cm contradicts the file, which names {unit}"):
            recognize_file(path, Choices(unit="cm"), size="coarse")
    else:
        assert found.unit == "mm, by the size of the shoe"
        assert any("names no unit of length, mm was taken" in one for one in found.remarks)
    assert found.pitch == pytest.approx(0.2, abs=1e-6)
    assert found.radii == pytest.approx((0.015, 0.015), abs=1e-6)
    assert found.joint_y == pytest.approx((-0.1175, 0.1175), abs=1e-3)
    assert [one.flag for one in found.questions] == ["--footprint tips"]
    assert any("gap of 5 mm" in one for one in found.remarks)
    assert found.mesh.volume == pytest.approx(1e-9 * plate_shoe(occ).mass, rel=2e-3)


def test_cross_holes_chamfers_and_other_holes_do_no_harm(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    body = plate_shoe(occ)
    rims = [edge for edge in body.edges if abs(edge.mass - 2.0 * np.pi * 15.0) < 0.1]
    body = body.MakeChamfer(rims, 2.0)
    for y in (-140, 140):  # grease holes into the front bores, and through the plate
        body -= occ.Cylinder(occ.Pnt(100, y, 40), occ.Z, 4, 60)
        for x in (-70, 20):
            body -= occ.Cylinder(occ.Pnt(x, y, -1), occ.Z, 15, 22)
    body -= occ.Cylinder(occ.Pnt(-40, -151, 10), occ.Y, 5, 302)  # along the pins, in two equal lines
    body -= occ.Cylinder(occ.Pnt(60, -151, 10), occ.Y, 5, 302)
    body.WriteStep(str(tmp_path / "holes.step"))
    triangles, _ = StepSolid(tmp_path / "holes.step").quick()
    axes = axes_of(triangles, Choices(), NodesUnit("mm", "mm", 1e-3))
    assert axes.pins.pitch == pytest.approx(200.0, abs=1e-3)
    assert [line.radius for line in axes.pins.lines] == pytest.approx([15.0, 15.0], abs=1e-3)
    assert [len(line.bores) for line in axes.pins.lines] == [2, 2]
    np.testing.assert_allclose(axes.rows, np.eye(3), atol=1e-6)
    surfaces = find_surfaces(triangles, axes, None)
    assert not any("are not alike" in remark for remark in surfaces.remarks)
    ends = np.array([surfaces.box(f"bore front {side}")[:, 1] for side in ("right", "left")])
    np.testing.assert_allclose(ends, [[-0.158, -0.122], [0.122, 0.158]], atol=1e-3)


def test_solids_that_touch_are_fused_and_others_chosen_from(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    body = plate_shoe(occ)
    below = occ.Box(occ.Pnt(40, -150, -45), occ.Pnt(60, 150, 0))
    path = tmp_path / "bolted.step"
    occ.Compound([body, below]).WriteStep(str(path))
    found = recognize_file(path, size="coarse")
    assert found.mesh.volume == pytest.approx(1e-9 * (body.mass + below.mass), rel=2e-3)
    assert "--body N" in [one.flag for one in found.questions]
    apart = tmp_path / "apart.step"
    occ.Compound([body, below.Move(occ.Vec(500, 0, 0))]).WriteStep(str(apart))
    with pytest.raises(fem.MeshError, match=r"several that touch, got 2 apart .*--body N chooses one$"):
        recognize_file(apart)
    for x, low in ((-81, 119), (-81, -161), (69, 74), (69, -116)):  # so that the next shoe does not touch
        body -= occ.Box(occ.Pnt(x, low, 20), occ.Pnt(x + 12, low + 42, 91))
    occ.Compound([body, body.Move(occ.Vec(200, 0, 0))]).WriteStep(str(apart))
    with pytest.raises(fem.MeshError, match=r"are 2 equal links, one pitch apart: --body 1 takes one"):
        recognize_file(apart)


def test_bores_of_one_line_that_differ_are_told_of_with_their_radii(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    path = tmp_path / "worn.step"
    (plate_shoe(occ) - occ.Cylinder(occ.Pnt(100, 119, 60), occ.Y, 15.5, 42)).WriteStep(str(path))
    axes = axes_of(StepSolid(path).quick()[0], Choices(), NodesUnit("mm", "mm", 1e-3))
    assert [line.has_equal_radii for line in axes.pins.lines] == [True, False]
    assert sorted(bore.radius for bore in axes.pins.lines[1].bores) == pytest.approx([15.0, 15.5], abs=1e-6)
    (words,) = differing_bores(axes)
    assert words.startswith("the front bores have different radii, 15.000 mm at y = -1")
    assert "15.500 mm at y = 1" in words


@pytest.mark.parametrize("width", [0.005, 0.0005])
def test_slivers_of_a_solid_are_found_and_healed(width):
    occ = pytest.importorskip("netgen.occ")
    block = occ.Box(occ.Pnt(0, 0, 0), occ.Pnt(600, 200, 50))
    # a notch that leaves walls as thin as this
    shape = (block - occ.Box(occ.Pnt(100, -1, 50 - width), occ.Pnt(160, 100, 60))).solids[0]
    found = find_slivers(shape)
    assert {sliver.kind for sliver in found} == {"edge", "face"}
    assert min(sliver.size for sliver in found) == pytest.approx(width, rel=0.1)
    words = next(sliver for sliver in found if sliver.kind == "edge").words(StepUnit("cm", 1e-2))
    assert words.startswith(f"an edge {0.1 * width:.3g} cm long at (1")
    assert suspects(found, StepUnit("mm", 1e-3)).startswith(
        f"the solid has {len(found)} slivers, the smallest a"
    )
    whole = healed(occ, shape)
    assert find_slivers(whole) == []
    assert whole.mass == pytest.approx(shape.mass, rel=1e-5)
    assert find_slivers(block.solids[0]) == []


@pytest.mark.slow
def test_a_shoe_with_slivers_is_read_without_them(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    path = tmp_path / "sliver.step"
    notch = occ.Box(occ.Pnt(-94.995, -60, 19.995), occ.Pnt(-94, 60, 30))
    (plate_shoe(occ) - notch).WriteStep(str(path))
    found = recognize_file(path, size="coarse")
    assert any("slivers were removed, the smallest" in remark for remark in found.remarks)
    assert found.mesh.volume == pytest.approx(1e-9 * plate_shoe(occ).mass, rel=2e-3)


def test_pins_that_fill_bores_are_told_of_with_the_flag_that_leaves_them_out(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    body = plate_shoe(occ)
    pin = occ.Cylinder(occ.Pnt(100, -160, 60), occ.Y, 15, 320)
    path = tmp_path / "pinned.step"
    occ.Compound([body, pin]).WriteStep(str(path))
    words = "round bores .* 2 solids were fused .*: pins and bushes among them fill bores, --body N takes"
    with pytest.raises(ValueError, match=words):
        recognize_file(path, size="coarse")
    triangles, _ = StepSolid(path, "1").quick()
    assert axes_of(triangles, Choices(), NodesUnit("mm", "mm", 1e-3)).pins.pitch == pytest.approx(
        200.0, abs=1e-3
    )


def test_broken_step_files_are_refused(tmp_path):
    occ = pytest.importorskip("netgen.occ")
    path = tmp_path / "box.step"
    occ.Box(occ.Pnt(0, 0, 0), occ.Pnt(9, 9, 9)).WriteStep(str(path))
    whole = path.read_bytes()
    for content in (b"", b"no STEP", whole[: len(whole) // 2], whole.replace(b"CARTESIAN_POINT", b"NOTHING")):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"box\.step") as caught:
            recognize_file(path)
        assert "\n" not in str(caught.value)


def test_a_wall_of_one_element_is_as_thick_as_it_is():
    nodes, tets = SweptShoe(front=(), rear=(), rails=False, decoy=False).mesh()
    plate = tets[nodes[tets][:, :, 2].max(axis=1) < 20.5]
    used, thin = np.unique(plate, return_inverse=True)
    of_mesh = mesh_quality(fem.Mesh(1e-3 * nodes[used], thin.reshape(-1, 4), {}))
    assert of_mesh.thinnest == pytest.approx(0.02)
    assert of_mesh.thin_share > 0.5
    assert 0.1 < of_mesh.least < of_mesh.mean < 1.0
