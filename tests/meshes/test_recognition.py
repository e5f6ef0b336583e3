"""Shoes of known pins, in any axes and unit, are recognized, or a question says what is open."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import meshes
from fem.body.mesh import Mesh, boundary_faces
from meshes.recognition import shoe
from meshes.recognition.axes import UNITS, Choices, rails_up
from meshes.recognition.bores import find_bores
from meshes.recognition.elements import centroid, with_middles
from meshes.recognition.surfaces import find_surfaces
from meshes.recognition.triangles import Triangles
from tests.meshes.swept import FORK, SweptShoe

MIDDLE_LUG = {
    "front": ((-195.0, -125.0), (-35.0, 35.0), (125.0, 195.0)),
    "rear": ((-115.0, -45.0), (45.0, 115.0)),
}
SHOES = {
    "fork": SweptShoe(),
    "of 12 facets": SweptShoe(facets=12, half_pitch=155.0),
    "different bores": SweptShoe(radii=(20.0, 15.0), facets=14),
    "three and two lugs": SweptShoe(**MIDDLE_LUG),
    "one behind": SweptShoe(front=((-165.0, -75.0), (75.0, 165.0)), rear=((-70.0, 70.0),)),
    "grouser": SweptShoe(grouser=True, facets=12),
    "links": SweptShoe(front=FORK[::3], rails=False, links=True),
}
FACETS = (8, 9, 10, 12, 16, 20, 24)
COARSE = (4, 5, 6, 7)
"""Around a bore: shoes are known by the first, by the others known or refused."""


@cache
def boundary_of(own):
    """Triangles of a swept shoe."""
    nodes, tets = own.mesh()
    return Triangles(nodes, boundary_faces(tets))


TRIANGLES = {name: boundary_of(own) for name, own in SHOES.items()}


def moved(triangles, seed):
    """Triangles (mm) after a random rigid motion, in a random unit, and the turn, with the unit's name."""
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=rng).as_matrix()
    unit = rng.choice(["mm", "m", "inch", "cm"])
    points = (triangles.points @ turn.T + rng.normal(0.0, 3e3, 3)) * 1e-3 / UNITS[unit]
    if rng.random() < 0.5:
        points = points.astype(np.float32).astype(float)
    return Triangles(points, triangles.faces[rng.permutation(len(triangles.faces))]), turn, str(unit)


def check_motion(own, seed):
    triangles, turn, unit = moved(boundary_of(own), seed)
    axes = shoe.axes_of(triangles, Choices())
    found = find_surfaces(triangles, axes, None)
    flags = [one.flag for one in (*axes.questions, *found.questions)]
    assert axes.unit == unit or "--unit" in flags
    scale = UNITS[unit]
    assert axes.pins.pitch * scale == pytest.approx(2e-3 * own.half_pitch, abs=2e-5)
    radii = [line.radius * scale for line in axes.pins.lines]
    assert radii == pytest.approx([1e-3 * own.radii[1], 1e-3 * own.radii[0]], abs=2e-5)
    assert [len(line.bores) for line in axes.pins.lines] == [len(own.rear), len(own.front)]
    np.testing.assert_allclose(axes.rows @ turn, np.eye(3), atol=2e-4)
    assert flags == ["--unit"] * ("--unit" in flags) + ["--footprint tips"] * own.grouser
    assert ("roller path" in found.faces) == (own.rails or own.links)
    if axes.unit == unit:
        whole = 4.0 * own.half_width * 115.0e-6
        expected = whole - own.grouser * 2.0 * own.half_width * 20e-6
        assert found.footprint_area == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", SHOES)
def test_any_motion_and_unit_gives_the_same_shoe(name, seed):
    check_motion(SHOES[name], seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
@pytest.mark.parametrize("name", SHOES)
def test_a_hundred_motions_units_and_facets_give_the_same_shoe(name, seed):
    check_motion(dataclasses.replace(SHOES[name], facets=FACETS[seed % len(FACETS)]), seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("facets", COARSE)
@pytest.mark.parametrize("name", SHOES)
def test_shoes_of_few_facets_are_the_same_or_refused(name, facets, seed):
    refusal = "bores"
    try:
        check_motion(dataclasses.replace(SHOES[name], facets=facets), seed)
    except ValueError as error:
        refusal = str(error)
    assert "bores" in refusal


@pytest.mark.parametrize("facets", [7, 8, 12, 24])
def test_pitch_is_exact_at_any_number_of_facets(facets):
    nodes, tets = SweptShoe(facets=facets, radii=(25.0, 22.0)).mesh()
    axes = shoe.axes_of(Triangles(nodes, boundary_faces(tets)), Choices())
    assert axes.pins.pitch == pytest.approx(250.0, abs=1e-6)
    assert [line.radius for line in axes.pins.lines] == pytest.approx([22.0, 25.0], abs=1e-6)


def test_bores_too_coarse_are_refused():
    nodes, tets = SweptShoe(facets=4).mesh()
    with pytest.raises(ValueError, match=r"bores at both ends .*, got .*round"):
        shoe.axes_of(Triangles(nodes, boundary_faces(tets)), Choices())


def test_holes_of_a_shoe_are_its_bores_and_the_decoy():
    holes = find_bores(TRIANGLES["fork"])
    assert sorted(round(hole.radius, 6) for hole in holes) == [15.0] + [18.0] * 6
    lengths = sorted(round(hole.ends[1] - hole.ends[0], 6) for hole in holes)
    assert lengths == [40.0] * 6 + [480.0]


def test_joints_act_in_the_middle_of_what_both_ends_share():
    axes = shoe.axes_of(TRIANGLES["fork"], Choices())
    assert find_surfaces(TRIANGLES["fork"], axes, None).joint_y == pytest.approx((-0.1, 0.1))


def test_rails_of_links_reach_over_both_of_their_halves():
    axes = shoe.axes_of(TRIANGLES["links"], Choices())
    found = find_surfaces(TRIANGLES["links"], axes, None)
    lengths = np.ptp(found.box("roller path"), axis=0)
    np.testing.assert_allclose(lengths, [0.23, 0.33, 0.0], atol=1e-9)
    area = found.triangles.areas[found.faces["roller path"]].sum()
    assert area == pytest.approx(2.0 * 0.04 * (0.12 + 0.13))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_rails_say_what_is_up(sense):
    axes = shoe.axes_of(TRIANGLES["fork"], Choices())
    rows = axes.rows * np.array([[1.0], [sense], [sense]])
    local = TRIANGLES["fork"].moved(axes.origin, rows, axes.scale)
    assert rails_up(local, 0.25) == sense


def test_joints_of_lugs_side_by_side_act_in_their_gap():
    own = SweptShoe(front=FORK[::3], rear=((-115.0, -75.0), (75.0, 115.0)))
    nodes, tets = own.mesh()
    triangles = Triangles(nodes, boundary_faces(tets))
    axes = shoe.axes_of(triangles, Choices())
    found = find_surfaces(triangles, axes, None)
    assert found.joint_y == pytest.approx((-0.12, 0.12))
    assert "gap of 10 mm" in found.remarks[0]


@pytest.mark.parametrize("lost", range(4))
def test_a_shoe_without_one_of_its_bores_is_not_taken_in_silence(lost):
    own = SweptShoe()
    nodes, tets = SweptShoe(front=(*FORK[:lost], *FORK[lost + 1 :])).mesh()
    triangles = Triangles(nodes, boundary_faces(tets))
    axes = shoe.axes_of(triangles, Choices())
    assert len(axes.pins.lines[1].bores) == len(own.front) - 1 or axes.questions
    remarks = find_surfaces(triangles, axes, None).remarks
    assert any("are not alike on the right and on the left" in one for one in remarks)


def test_equal_ends_ask_which_leads():
    nodes, tets = SweptShoe(
        front=((-160.0, -120.0), (80.0, 120.0)), rear=((-120.0, -80.0), (120.0, 160.0))
    ).mesh()
    axes = shoe.axes_of(Triangles(nodes, boundary_faces(tets)), Choices())
    assert [one.flag for one in axes.questions] == ["--flip-front"]


@pytest.mark.parametrize(("flip", "turn"), [("flip_front", [-1, -1, 1]), ("flip_up", [1, -1, -1])])
def test_flags_turn_the_shoe(flip, turn):
    plain = shoe.axes_of(TRIANGLES["fork"], Choices())
    turned = shoe.axes_of(TRIANGLES["fork"], Choices(**{flip: True}))
    np.testing.assert_allclose(turned.rows, np.array(turn)[:, None] * plain.rows, atol=1e-9)


def test_tips_of_a_grouser_are_the_underside_on_demand():
    axes = shoe.axes_of(TRIANGLES["grouser"], Choices())
    found = find_surfaces(TRIANGLES["grouser"], axes, "tips")
    assert found.footprint_area == pytest.approx(0.02 * 0.7)
    np.testing.assert_allclose(np.ptp(found.box("underside"), axis=0), [0.02, 0.7, 0.0], atol=1e-9)
    assert found.questions == ()


def test_equal_lines_over_each_other_are_of_a_double_pin_track():
    nodes, tets = SweptShoe(front=FORK, rear=FORK, decoy=False).mesh()
    with pytest.raises(ValueError, match="two pins a link and connectors"):
        shoe.axes_of(Triangles(nodes, boundary_faces(tets)), Choices())


def test_front_and_rear_lugs_that_overlap_are_told_of_with_their_length():
    rear = ((-150.0, -110.0), (110.0, 150.0))
    nodes, tets = SweptShoe(front=((-165.0, -125.0), (125.0, 165.0)), rear=rear, decoy=False).mesh()
    with pytest.raises(ValueError, match=r"lugs overlap by 25 .* lugs have to stand beside") as caught:
        shoe.axes_of(Triangles(nodes, boundary_faces(tets)), Choices())
    assert "connectors" not in str(caught.value)


def test_centre_of_a_volume_is_that_of_its_boundary():
    nodes, tets = SweptShoe().mesh()
    expected = Triangles(nodes, boundary_faces(tets)).center
    np.testing.assert_allclose(centroid(nodes, tets), expected, atol=1e-6)
    np.testing.assert_allclose(centroid(*with_middles(nodes, tets)), expected, atol=1e-6)


@pytest.mark.parametrize("size", ["coarse", "study"])
def test_the_ready_shoe_comes_back_from_millimetres_and_other_axes(size):
    ready = meshes.shoe_mesh(size)
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    nodes = 1e3 * (ready.nodes @ turn.T + (2.0, -7.0, 0.5))
    found = shoe.recognize_solid(shoe.FileSolid(nodes, ready.elements, None, {}), Choices())
    assert found.axes.unit == "mm"
    assert found.questions == ()
    np.testing.assert_allclose(found.axes.rows @ turn, np.eye(3), atol=1e-7)
    assert found.pitch == pytest.approx(meshes.PITCH, abs=1e-7)
    off = np.mean(found.mesh.nodes - ready.nodes, axis=0)
    np.testing.assert_allclose(found.mesh.nodes - ready.nodes, off[None] + 0.0 * ready.nodes, atol=1e-7)
    for name, faces in ready.surfaces.items():
        same = Mesh(ready.nodes, ready.elements, {name: found.mesh.surface(name)}).surface(name)
        assert face_set(same) == face_set(faces), name


def face_set(faces):
    return {tuple(face) for face in np.sort(faces[:, :3], axis=1).tolist()}
