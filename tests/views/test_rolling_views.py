"""Side frame and rollers as pictures and ParaView show them, in short runs."""

from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from matplotlib.figure import Figure

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.views.animation import TrackPicture
from exudyn_crawler.views.paraview import write_paraview
from exudyn_crawler.views.placement import instant
from exudyn_crawler.views.plan_view import PlanView
from exudyn_crawler.views.side_view import SideView
from exudyn_crawler.views.undercarriage import acting, pressing, tread_surface
from tests.views.drawn import corners


def axes_of_rollers(history, now):
    """Middles of the rollers' axes as the motion of the frame has them: array (rollers, 3)."""
    along = rotation_matrices(now.side_frame_angles.values)[:, 0]
    return now.side_frame_position.values + np.outer(history.case.undercarriage.rollers, along)


def middles(collection):
    return np.array([path.vertices[:-1].mean(axis=0) for path in collection.get_paths()])


def test_discs_stand_where_the_frame_has_its_rollers_and_press_where_the_history_says(rolled):
    now = rolled.dataset.isel(time=-1)
    ax = Figure().subplots()
    view = SideView(ax, rolled, 1.0, force_scale=1e-6)
    view.show(now)
    hubs = axes_of_rollers(rolled, now)
    drawn = view._rollers
    assert middles(drawn._discs) == pytest.approx(hubs[:, [0, 2]], abs=1e-9)
    assert hubs[:, 2].max() + rolled.case.undercarriage.radius < ax.get_ylim()[1]
    total = rolled.roller_force.isel(time=-1).sum("rail")
    assert pytest.approx(1e-6 * total.sel(axis="z").values) == drawn._forces.V
    # right below the axes but for the tilt of shoes and of frame
    places = np.asarray(drawn._forces.get_offsets())
    radius = rolled.case.undercarriage.radius
    assert np.hypot(*(places - hubs[:, [0, 2]]).T) == pytest.approx(radius, abs=2e-3)


def test_rollers_roll_without_slip(rolled):
    spokes = []
    view = SideView(Figure().subplots(), rolled)
    for row in (0, -1):
        view.show(rolled.dataset.isel(time=row))
        spokes.append(np.diff(view._rollers._spokes.get_segments()[0], axis=0)[0])
    turned = np.arctan2(spokes[1][0], spokes[1][1]) - np.arctan2(spokes[0][0], spokes[0][1])
    way = float(np.ptp(rolled.side_frame_position.sel(axis="x").values))
    assert turned * rolled.case.undercarriage.radius == pytest.approx(way, rel=1e-3)


def test_rollers_keep_their_depth_in_rails_where_the_ground_is_magnified(rolled):
    """They rise with the shoes below them, by what the ground's displacement there is drawn larger."""
    now = rolled.dataset.isel(time=-1)
    heights = {}
    for scale in (1.0, 4.0, 7.0):
        view = SideView(Figure().subplots(), rolled, scale)
        view.show(now)
        heights[scale] = middles(view._rollers._discs)[:, 1]
        tops = corners(view._shoes)[:, 2:].reshape(-1, 2)
        tops = tops[np.argsort(tops[:, 0])]
        heights[scale] -= np.interp(axes_of_rollers(rolled, now)[:, 0], *tops.T)
    # a shoe's drawn edge is straight, the ground below it may have a kink
    assert heights[4.0] == pytest.approx(heights[1.0], abs=0.02)
    assert heights[7.0] == pytest.approx(heights[1.0], abs=0.04)


def test_treads_are_seen_from_above_on_their_rails(rolled):
    now = rolled.dataset.isel(time=-1)
    above = PlanView(Figure().subplots(), rolled)
    above.show(now)
    hubs = axes_of_rollers(rolled, now)
    treads = middles(above._rollers._treads).reshape(len(hubs), 2, 2)
    assert treads[..., 0] == pytest.approx(np.repeat(hubs[:, :1], 2, axis=1), abs=1e-4)
    assert treads[..., 1] - hubs[:, 1:2] == pytest.approx(np.tile(rolled.case.shoe.rails.middles, (3, 1)))


def test_a_picture_of_a_rolled_run_has_room_for_what_it_says(rolled):
    picture = TrackPicture(rolled, 10.0)
    picture.image(0.1)
    width = picture.figure.get_window_extent().width
    _, side, forces = picture.figure.axes[:3]
    assert "violet: force of each roller" in side.get_title(loc="left")
    assert side._left_title.get_window_extent().x1 < width
    drawn = forces.lines[1].get_ydata()
    assert drawn == pytest.approx(-1e-3 * rolled.roller_force.sel(roller=2, axis="z").sum("rail").values)


def test_a_tread_is_a_closed_surface_with_the_volume_of_its_disc(rolled):
    frame = rolled.case.undercarriage
    points, triangles = tread_surface(frame)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    disc = np.pi * frame.radius**2 * frame.tread_width
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(disc, rel=0.01)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_what_acts_on_a_shoe_is_ground_and_rollers(rolled):
    now = rolled.dataset.isel(time=-1)
    contact = (
        (now.normal_force + now.friction_force).isel(contact=now.contact_shoe.values == 5).sum("contact")
    )
    pressed = rolled.rail_force.isel(time=-1).sel(shoe=5)
    _, forces = acting(now, 5)
    assert forces.sum(axis=0) == pytest.approx((contact + pressed).values)
    assert pressing(now, 6)[1].size == 0


def test_paraview_has_frame_rollers_and_treads(bent, bent_stress, tmp_path):
    series = ElementTree.parse(write_paraview(bent_stress, bent, tmp_path)).getroot()
    last = float(bent_stress.frame[-1])
    files = {
        entry.attrib["name"]: tmp_path / entry.attrib["file"]
        for entry in series.iter("DataSet")
        if float(entry.attrib["timestep"]) == last
    }
    assert {"side frame", "rollers", "treads"} <= set(files)
    now = instant(bent, last)
    rollers, hubs = meshio.read(files["rollers"]), axes_of_rollers(bent, now)
    whose = rollers.cell_data["roller"][0]
    for number, hub in enumerate(hubs, 1):
        own = rollers.points[np.unique(rollers.cells[0].data[whose == number])]
        assert own.mean(axis=0) == pytest.approx(hub, abs=1e-4)
        force = rollers.cell_data["force"][0][whose == number][0]
        assert force == pytest.approx(now.roller_force.sel(roller=number).sum("rail").values)
    frame = meshio.read(files["side frame"])
    ends = bent.case.undercarriage.ends
    assert np.linalg.norm(frame.points[1] - frame.points[0]) == pytest.approx(ends[1] - ends[0])
    treads = meshio.read(files["treads"])
    total = now.roller_force.sum(("roller", "rail")).values
    assert treads.point_data["force"].sum(axis=0) == pytest.approx(total)
