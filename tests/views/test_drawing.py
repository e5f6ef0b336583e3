"""Scenes: where solids and arrows are, and how they are painted; those of a short run, also for ParaView."""

import io
from dataclasses import replace
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from PIL import Image

from exudyn_crawler import Case, History
from exudyn_crawler.case import Heights, Waves
from exudyn_crawler.views.outputs import write_paraview
from exudyn_crawler.views.scenes.gear import wheel_solids
from exudyn_crawler.views.scenes.pictures import draw_arrows, paint
from exudyn_crawler.views.scenes.scene import SIDES, Arrows, Colouring, Placement, Solid, View, box
from exudyn_crawler.views.scenes.shoes import (
    BESIDE,
    picture_name,
    picture_time,
    stress_picture,
    stress_scene,
    write_stress_pictures,
)
from exudyn_crawler.views.scenes.track import forces_on, instants, shoe_forces, shoe_pose
from tests.views.test_track_scene import axes_of_rollers

ABOVE = View.seen_from(azimuth=-90.0, elevation=90.0)
"""x to the right, y up."""


def surface(points, triangles, values):
    stress = Colouring("stress", values[None, None], 0.0, 1.0, "YlOrRd")
    return Solid("surface", points, (triangles,), "white", colourings=(stress,))


WEDGE = surface(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.6]], dtype=float),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    np.zeros(4),
)


def picture(surfaces, view, window=(-1.0, 1.0, -1.0, 1.0), arrows=None):
    """Red, green and blue of a picture of 200 x 200 pixels, the top row first."""
    figure = Figure(figsize=(2.0, 2.0), dpi=100)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    paint(ax, surfaces, view, window)
    if arrows is not None:
        draw_arrows(ax, [arrows], view)
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=100)
    return np.asarray(Image.open(memory).convert("RGB")).astype(float)


def at(image, x, y):
    """Colour at a place of the window -1..1."""
    return image[round(99.5 - 100 * y), round(99.5 + 100 * x)]


def square(z, value, half=0.5):
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return surface(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.full(4, value))


def test_a_view_has_the_axes_of_the_one_who_looks():
    assert np.array([ABOVE.right, ABOVE.up, ABOVE.toward]) == pytest.approx(np.eye(3))
    behind = View.seen_from(azimuth=180.0, elevation=0.0)
    # from behind the track, which runs along x, y = left is at the left
    axes = np.array([behind.right, behind.up, behind.toward])
    assert axes == pytest.approx(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]))
    slanted = View.seen_from(azimuth=25.0, elevation=-30.0)
    frame = np.array([slanted.right, slanted.up, slanted.toward])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    assert slanted.toward[2] == pytest.approx(-0.5)


def test_a_solid_covers_what_its_projection_covers():
    view = View.seen_from(azimuth=20.0, elevation=35.0)
    image = picture([WEDGE], view)
    covered = image.min(axis=2) < 250.0
    y, x = np.mgrid[0.995:-1.0:-0.01, -0.995:1.0:0.01]
    expected = np.zeros_like(covered)
    for corners in view.project(WEDGE.points)[WEDGE.triangles, :2]:
        inside = [
            (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        ]
        expected |= np.all(np.array(inside) > 0.0, axis=0)
    assert expected.mean() > 0.1
    # edges are one pixel wide
    assert (covered != expected).mean() < 0.015


def test_the_nearer_surface_hides_the_other():
    pale, dark = (at(picture([square(0.0, value)], ABOVE), 0.0, 0.0) for value in (0.0, 1.0))
    near, far = square(0.2, 1.0, half=0.3), square(-0.2, 0.0)
    for order in ([near, far], [far, near]):
        image = picture(order, ABOVE)
        assert at(image, 0.0, 0.0) == pytest.approx(dark, abs=6)
        assert at(image, 0.4, 0.0) == pytest.approx(pale, abs=6)
    assert dark[1] < 0.3 * pale[1]


def test_arrows_point_from_tail_to_head():
    head, along = np.array([[[-0.8, 0.6, 0.1]]]), np.array([[[0.0, 1.4, 0.0]]])
    arrow = Arrows("force", "#1f4fd8", head, along, 1.0)
    image = picture([square(0.2, 0.0, 0.2)], ABOVE, arrows=arrow)
    blue = image[:, :, 2] - image[:, :, 0] > 60.0
    rows, columns = np.nonzero(blue)
    assert 0.99 - rows.min() / 100 == pytest.approx(0.6, abs=0.03)
    assert 0.99 - rows.max() / 100 == pytest.approx(-0.8, abs=0.03)
    assert columns.mean() / 100 - 0.995 == pytest.approx(-0.8, abs=0.02)
    # the head is broad, the tail is not
    widths = blue.sum(axis=1)[rows.min() : rows.max()]
    assert widths[:12].max() > widths[-60:].max()


def test_a_point_behind_something_is_not_shown():
    upper, lower = square(0.2, 0.0, half=0.3), square(-0.2, 0.0)
    centre = surface(
        np.vstack((upper.points, lower.points, [[0.1, 0.05, -0.2], [0.0, 0.1, -0.2], [0.45, 0.0, -0.2]])),
        np.vstack((upper.triangles, lower.triangles + 4, [[8, 9, 10]])),
        np.zeros(11),
    )
    assert not centre.shows(8, ABOVE)
    assert centre.shows(10, ABOVE)
    assert centre.shows(8, View.seen_from(azimuth=-90.0, elevation=-90.0))


def test_copies_of_a_solid_stand_where_they_are_placed_and_lifted():
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    solid = Solid(
        "box",
        *box(np.zeros(3), np.array([2.0, 1.0, 1.0])),
        "white",
        np.array([[[5.0, 0.0, 0.0], [np.nan] * 3, [0.0, 0.0, 0.0]]]),
        np.stack([np.eye(3), np.eye(3), turned])[None],
        lift=np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]]),
    )
    first, second = (replace(solid, lift=solid.lift[row:]).at() for row in (0, 1))
    # the second copy is nowhere
    assert len(first.points) == 16
    assert first.points[:8].min(axis=0) == pytest.approx([5.0, 0.0, 0.0])
    assert first.points[8:].min(axis=0) == pytest.approx([-1.0, 0.0, 0.1])
    assert first.points[8:].max(axis=0) == pytest.approx([0.0, 2.0, 1.1])
    assert second.points - first.points == pytest.approx(np.repeat([[0, 0, 0], [0, 0, 0.2]], 8, axis=0))
    a, b, c = (first.points[first.triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(4.0)


def test_what_bends_is_drawn_larger_and_seen_the_same_in_its_own_axes():
    points, faces = box(-np.ones(3), np.ones(3))
    rng = np.random.default_rng(4)
    bend, heads = rng.normal(size=(1, 1, 8, 3)), rng.normal(size=(1, 1, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    solid = Solid("box", points, faces, "white", bend=bend, larger=3.0)
    assert solid.at().points == pytest.approx(points + 3.0 * bend[0, 0])
    placed = Placement(np.array([1.0, 2.0, 3.0]), turn)
    moved = replace(solid, origin=placed.origin[None, None], turn=turn[None, None])
    force = Arrows("force", "blue", placed.place(heads), heads @ turn.T, 0.5)
    view, same = ABOVE, ABOVE.on(placed)
    assert same.project(moved.at().points) == pytest.approx(view.project(solid.at().points))
    own = np.stack((0.5 * heads[0], heads[0]), axis=1)
    assert same.project(force.at()) == pytest.approx(view.project(own))


def files_at(series, time):
    """Paths of what ParaView shows at a time, by name, as a series lists them."""
    entries = [entry.attrib for entry in ElementTree.parse(series).iter("DataSet")]
    return {one["name"]: series.parent / one["file"] for one in entries if float(one["timestep"]) == time}


def test_every_chosen_time_gets_a_picture(history, stress, stress_folder):
    pictures = sorted(stress_folder.glob("*.png"))
    assert [picture_time(path) for path in pictures] == pytest.approx(stress.frame.values)
    images = [np.asarray(Image.open(path).convert("RGB")).astype(int) for path in pictures]
    # red is where stress is, blue are the arrows; at t = 0 the shoes carry less than under way
    red = [(image[..., 0] - image[..., 2] > 120).mean() for image in images]
    blue = [(image[..., 2] - image[..., 0] > 100).mean() for image in images]
    assert min(blue) > 2e-4
    assert red[1] > 1.1 * red[0]
    with pytest.raises(FileExistsError, match=picture_name(0.0)):
        write_stress_pictures(stress, history, stress_folder)


def test_all_pictures_share_one_scale_and_say_the_highest_stress(history, stress):
    scene = stress_scene(stress, history)
    surface = np.unique(stress.triangle.values)
    greatest = float(stress.frame_von_mises.isel(node=surface).max()) / 1e6
    (end,) = {one.colourings[0].high for one in scene.solids}
    assert greatest <= end < 1.6 * greatest
    for time, frame in enumerate(stress.frame.values):
        figure = stress_picture(scene, instants(history, [frame]), time, force_scale=1e-6)
        texts = [text.get_text() for text in figure.texts]
        for shoe in (7, 13):
            highest = float(stress.frame_von_mises.sel(shoe=shoe, frame=frame).max()) / 1e6
            assert texts[texts.index(f"shoe {shoe}") + 1] == f"{highest:.1f} MPa"
        bars = [ax for ax in figure.axes if ax.get_ylabel() == "von Mises stress in MPa"]
        assert [ax.get_ylim() for ax in bars] == [pytest.approx((0.0, end))]
        assert isinstance(bars[0]._colorbar, Colorbar)


def test_a_shoe_is_bent_by_its_magnified_displacement_and_pressed_by_its_contacts(history, stress):
    frame = float(stress.frame[-1])
    now = history.dataset.sel(time=frame, method="nearest")
    place = shoe_pose(now, 13)
    scene = stress_scene(stress, history)
    surface, arrows = scene.solids[1].at(1), scene.arrows[1].at(1)
    used = np.unique(stress.triangle.values)
    chosen = stress.sel(shoe=13, frame=frame).isel(node=used)
    moved = (surface.points - place.origin) @ place.turn - chosen.node_position.values
    assert moved == pytest.approx(scene.solids[1].larger * chosen.frame_displacement.values, abs=1e-12)
    assert surface.values == pytest.approx(chosen.frame_von_mises.values / 1e6)
    assert np.linalg.norm(moved, axis=1).max() < 0.05
    # arrows end at the underside and push the shoe up
    heads = (arrows[:, 1] - place.origin) @ place.turn
    assert heads[:, 2] == pytest.approx(-history.case.shoe.com_height, abs=0.05)
    total = (arrows[:, 1] - arrows[:, 0]).sum(axis=0) / scene.arrows[1].scale
    own = history.contact_shoe.values == 13
    expected = (now.normal_force + now.friction_force).isel(contact=own).sum("contact").values
    assert total == pytest.approx(expected, rel=1e-9)
    assert shoe_forces(now.expand_dims("time"))[1][0, 12] == pytest.approx(expected, rel=1e-9)


def test_a_shoe_under_rollers_bends_and_is_pressed_as_its_stresses_say(bent, bent_stress):
    scene, last = stress_scene(bent_stress, bent), bent_stress.sizes["frame"] - 1
    surface, arrows = scene.solids[0].at(last), scene.arrows[0].at(last)
    own = bent_stress.sel(shoe=5).isel(frame=last, node=np.unique(bent_stress.triangle.values))
    assert surface.values == pytest.approx(own.frame_von_mises.values / 1e6, rel=1e-5, abs=1e-6)
    place = shoe_pose(bent.dataset.isel(time=-1), 5)
    moved = (surface.points - place.origin) @ place.turn - own.node_position.values
    expected = scene.solids[0].larger * own.frame_displacement.values
    assert moved == pytest.approx(expected, rel=1e-4, abs=1e-9)
    total = (arrows[:, 1] - arrows[:, 0]).sum(axis=0) / scene.arrows[0].scale
    _, forces = forces_on(bent.dataset.isel(time=[-1]), 5)
    assert total == pytest.approx(forces[0].sum(axis=0), rel=1e-6, abs=1.0)


def test_rollers_near_the_shoes_are_where_the_history_has_them(bent, bent_stress):
    scene, last = stress_scene(bent_stress, bent), bent_stress.sizes["frame"] - 1
    now = instants(bent, [bent.duration])
    shoes = now.position.sel(shoe=[5, 6], axis="x").values
    centers = wheel_solids(now)[0].origin[0]
    near = (centers[:, 0] > shoes.min() - BESIDE) & (centers[:, 0] < shoes.max() + BESIDE)
    drawn = scene.solids[2].at(last).points.reshape(-1, 2 * SIDES, 3).mean(axis=1)
    assert len(drawn) >= 2
    assert drawn == pytest.approx(centers[near], abs=1e-9)


def test_paraview_reads_the_track_back_in_place(history, stress, tmp_path):
    series = write_paraview(stress, history, tmp_path)
    times = sorted({float(one.attrib["timestep"]) for one in ElementTree.parse(series).iter("DataSet")})
    assert times == pytest.approx(stress.frame.values)
    last = files_at(series, times[-1])
    assert set(last) == {"shoe 7", "shoe 13", "rigid shoes", "terrain", "contacts"}

    now = history.dataset.sel(time=times[-1], method="nearest")
    shoe = meshio.read(last["shoe 13"])
    assert [block.type for block in shoe.cells] == ["tetra10"]
    chosen = stress.sel(shoe=13, frame=times[-1])
    assert shoe.point_data["von mises"] == pytest.approx(chosen.frame_von_mises.values, rel=1e-6)
    place = shoe_pose(now, 13)
    inside = (shoe.points - place.origin) @ place.turn
    assert inside == pytest.approx(stress.node_position.values, abs=1e-9)
    bent = shoe.point_data["displacement"] @ place.turn
    assert bent == pytest.approx(chosen.frame_displacement.values, abs=1e-9)

    terrain = meshio.read(last["terrain"])
    assert terrain.cell_data["heave"][0] == pytest.approx(now.unit_heave.values)
    first = terrain.points[terrain.cells[0].data[0]]
    middle = history.case.terrain.centers[0] + [0.0, 0.0, float(now.unit_heave[0])]
    assert first.mean(axis=0) == pytest.approx(middle)
    assert len(meshio.read(last["rigid shoes"]).cells[0].data) == 11
    contacts = meshio.read(last["contacts"])
    total = (now.normal_force + now.friction_force).sum("contact").values
    assert contacts.point_data["force"].sum(axis=0) == pytest.approx(total, rel=1e-6)
    with pytest.raises(FileExistsError, match=r"track\.pvd exists"):
        write_paraview(stress, history, tmp_path)


def test_units_of_uneven_ground_are_as_high_as_their_faces(history, stress, tmp_path):
    hills = Heights(parts=(Waves(height=0.1, length=16.0),))
    terrain = history.case.terrain.with_(relief=hills)
    # only drawn: this run was on even ground
    uneven = History(history.case.model_copy(update={"terrain": terrain}), history.dataset)
    write_paraview(stress.isel(frame=[0]), uneven, tmp_path)
    written = meshio.read(tmp_path / "track_parts" / "terrain_000.vtu")
    corners = written.points[written.cells[0].data]
    now = history.dataset.sel(time=0.0, method="nearest")
    bottom, top = corners[:, :4, 2].mean(axis=1), corners[:, 4:, 2].mean(axis=1)
    assert top == pytest.approx(terrain.top_heights + now.unit_heave.values, abs=1e-4)
    # boxes pitch with their faces
    assert top - bottom == pytest.approx(terrain.unit_height * np.cos(terrain.tilts), abs=1e-4)


def test_stresses_of_another_mesh_are_refused(history, stress, tmp_path):
    count = stress.sizes["node"]
    with pytest.raises(ValueError, match=f"{count - 1} nodes of the stresses are not the {count}"):
        write_paraview(stress.isel(node=slice(1, None)), history, tmp_path)
    with pytest.raises(ValueError, match="must have flexible shoes"):
        write_paraview(stress, History(Case.translation(), history.dataset), tmp_path)


def test_paraview_has_frame_rollers_and_treads(bent, bent_stress, tmp_path):
    last = float(bent_stress.frame[-1])
    files = files_at(write_paraview(bent_stress, bent, tmp_path), last)
    assert {"side frame", "rollers", "treads"} <= set(files)
    now = bent.dataset.sel(time=[last], method="nearest")
    rollers, hubs = meshio.read(files["rollers"]), axes_of_rollers(bent, now)
    whose = rollers.cell_data["roller"][0]
    for number, hub in enumerate(hubs, 1):
        own = rollers.points[np.unique(rollers.cells[0].data[whose == number])]
        assert own.mean(axis=0) == pytest.approx(hub, abs=1e-4)
        force = rollers.cell_data["force"][0][whose == number][0]
        assert force == pytest.approx(now.roller_force.sel(roller=number).sum("rail").values[0])
    frame, ends = meshio.read(files["side frame"]), bent.case.gear.ends
    assert np.linalg.norm(frame.points[1] - frame.points[0]) == pytest.approx(ends[1] - ends[0])
    treads = meshio.read(files["treads"])
    total = now.roller_force.sum(("roller", "rail")).values[0]
    assert treads.point_data["force"].sum(axis=0) == pytest.approx(total)
