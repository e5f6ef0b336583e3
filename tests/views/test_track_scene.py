"""The track in space, from the side and from above: everything is where the history of a short run has it."""

import numpy as np
import pytest

from exudyn_crawler import History, simulate
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.views.scenes.gear import wheel_solids
from exudyn_crawler.views.scenes.pictures import MARGIN, ground_figure, plan_solids, side_scene, windows
from exudyn_crawler.views.scenes.scene import SIDES
from exudyn_crawler.views.scenes.shoes import LONGEST_OF_SHOE, shoe_force_scale
from exudyn_crawler.views.scenes.track import (
    forces_on,
    greatest_shoe_force,
    instants,
    shoe_forces,
    shoe_pose,
    unloaded_level,
)
from exudyn_crawler.views.style import drawn_scale, round_up
from studies.grounds import STEP_HEIGHT, STEP_PLACE, uneven_case

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def step():
    return simulate(uneven_case("step"), 0.05)


def last(history):
    return instants(history, [history.duration])


def side(history, scale=1.0, force_scale=0.0, now=None):
    """Solids by name, and colour, tails and heads of each kind of force."""
    scene = side_scene(last(history) if now is None else now, scale, force_scale)
    return by_name(scene.solids), [(one.colour, one.at()) for one in scene.arrows]


def by_name(solids):
    return {one.name: one for one in solids}


def units(surfaces):
    """Corners of the cut units, (n, 4, 2): lower ones and then upper ones."""
    return surfaces["units"].points.reshape(-1, 4, 3)[..., [0, 2]]


def outlines(surfaces, kinds=("rigid shoes", "flexible shoes")):
    """Corners of the shoes' right sides, (n, 4, 2): lower ones and then upper ones."""
    points = [surfaces[kind].points for kind in kinds if kind in surfaces]
    return np.concatenate(points).reshape(-1, 8, 3)[:, [0, 1, 5, 4]][..., [0, 2]]


def axes_of_rollers(history, now):
    """Middles of the rollers' axes as the motion of the frame has them: array (rollers, 3)."""
    along = rotation_matrices(now.side_frame_angles.values[0])[:, 0]
    return now.side_frame_position.values + np.outer(history.case.undercarriage.rollers, along)


def treads(surface):
    """Middles of the treads, (rollers, rails, 3)."""
    return surface.points.reshape(-1, 2, 2 * SIDES, 3).mean(axis=2)


def test_scales_are_round_and_fit():
    found = [drawn_scale([1.0], length) for length in (0.0199, 2.0, 4.99, 731.0)]
    assert found == pytest.approx([0.01, 2, 2, 500])
    assert [round_up(value) for value in (0.0201, 2.0, 172.1, 84.8)] == pytest.approx([0.03, 2, 200, 100])
    assert drawn_scale([0.0, -0.003], 0.1) == pytest.approx(20.0)
    assert drawn_scale([0.0], 0.1) == 1.0


def test_the_greatest_force_of_a_run_gets_the_longest_arrow(translation):
    forces = shoe_forces(translation.dataset)[1]
    greatest = float((forces**2).sum(axis=-1).max() ** 0.5)
    assert greatest_shoe_force(translation) == pytest.approx(greatest)
    assert shoe_force_scale(translation) * greatest == pytest.approx(LONGEST_OF_SHOE)


def test_magnified_ground_lifts_the_shoes_with_it(translation):
    """Their depth in the ground is the same at every scale; the ground's own displacement is not."""
    drawn = {}
    for scale in (1.0, 5.0):
        surfaces, _ = side(translation, scale, force_scale=1e-6)
        shoes, ground = outlines(surfaces), units(surfaces)
        surface = np.concatenate(ground[:, [3, 2]]).T
        depth = np.interp(shoes[:, 0, 0], *surface) - shoes[:, 0, 1]
        drawn[scale] = (depth, ground[:, 2:, 1] - unloaded_level(translation.case))
    assert drawn[1.0][0] == pytest.approx(drawn[5.0][0], abs=1e-12)
    # shoes stand 6 to 7 cm deep (F-paper)
    assert np.all((drawn[1.0][0] > 0.03) & (drawn[1.0][0] < 0.09))
    assert drawn[5.0][1] == pytest.approx(5.0 * drawn[1.0][1], abs=1e-12)


def test_forces_are_where_the_history_has_them_none_on_a_lifted_shoe(translation):
    _, [(_, arrows)] = side(translation, force_scale=1e-6)
    now = last(translation).dataset
    centers, forces = (one[0] for one in shoe_forces(now))
    assert arrows[:, 1] == pytest.approx(centers)
    assert 1e-6 * forces == pytest.approx(arrows[:, 1] - arrows[:, 0])
    weight = 13 * (386.4e3 + translation.case.shoe.mass * 9.81)
    assert forces[:, 2].sum() == pytest.approx(weight, rel=0.05)
    lifted = now.assign(area=now.area.where(now.contact_shoe != 7, 0.0))
    _, [(_, arrows)] = side(translation, force_scale=1e-6, now=History(translation.case, lifted))
    assert arrows[:, 1] == pytest.approx(centers[translation.case.track.shoes != 7])


def test_shoes_are_seen_from_above_where_the_history_has_them(translation):
    now = last(translation)
    heave = 1e3 * translation.unit_heave.values
    above = by_name(plan_solids(now, (heave.min(), heave.max())))
    moment = now.dataset.isel(time=0)
    shoe = translation.case.shoe
    underneath = np.array([[*shoe.underside_center, -shoe.com_height]])
    expected = [shoe_pose(moment, int(n)).place(underneath)[0, :2] for n in now.shoe.values]
    lower = above["rigid shoes"].points.reshape(-1, 8, 3)[:, :4, :2]
    assert lower.mean(axis=1) == pytest.approx(np.array(expected), abs=1e-9)
    ground = above["ground"]
    assert ground.values.reshape(-1, 4)[:, 0] == pytest.approx(1e3 * moment.unit_heave.values)
    assert (ground.colourings[0].low, ground.colourings[0].high) == (heave.min(), heave.max())


def test_faces_of_uneven_ground_lie_at_their_heights(step):
    """Shoes stand as deep in the upper units as in the lower ones, at every scale of displacement."""
    now = last(step)
    for scale in (1.0, 20.0):
        surfaces, _ = side(step, scale)
        ground = units(surfaces)
        assert len(ground) == 13
        raised = ground[:, 3, 0] >= STEP_PLACE - 1e-3
        level = unloaded_level(step.case)
        heave = level + scale * (now.unit_heave.values[0] - level)
        # one unit climbs the step
        climbed = STEP_HEIGHT * np.clip(np.cumsum(raised) - 0.5, 0.0, 1.0)
        assert ground[:, 2:, 1].mean(axis=1) == pytest.approx(heave + climbed)
        surface = ground[:, [3, 2]]
        shoes = outlines(surfaces)
        for shoe in (0, 1, 2, 10, 11, 12):
            middle = shoes[shoe, :2].mean(axis=0)
            unit = np.flatnonzero((surface[:, 0, 0] <= middle[0]) & (middle[0] < surface[:, 1, 0]))[0]
            depth = np.interp(middle[0], *surface[unit].T) - middle[1]
            assert 0.03 < depth < 0.09
    assert windows(step)[1][2] == -MARGIN[2]


def test_a_ground_figure_shows_what_every_shoe_carries(step):
    figure = ground_figure(step, 0.05)
    view, carried = figure.axes
    assert view.get_title() == "step, t = 0.05 s"
    assert [text.get_text() for text in view.get_legend().get_texts()] == ["units", "shoes", "link pins"]
    heights = [bar.get_height() for bar in carried.patches]
    _, forces = shoe_forces(last(step).dataset)
    assert heights == pytest.approx(1e-3 * forces[0, :, 2])
    assert np.mean(heights) == pytest.approx(1e-3 * step.case.mean_load, rel=0.1)
    figure.draw_without_rendering()
    left, right = (ax.get_window_extent() for ax in (view, carried))
    assert left.width == pytest.approx(right.width, rel=0.02)


def test_rollers_stand_where_the_frame_has_them_and_press_where_the_history_says(rolled):
    now = last(rolled)
    surfaces, arrows = side(rolled, force_scale=1e-6)
    hubs, radius = axes_of_rollers(rolled, now), rolled.case.undercarriage.radius
    assert treads(surfaces["rollers"]).mean(axis=1)[:, [0, 2]] == pytest.approx(hubs[:, [0, 2]], abs=1e-4)
    assert hubs[:, 2].max() + radius < windows(rolled)[1][3]
    total = rolled.roller_force.isel(time=-1).sum("rail").transpose("roller", "axis").values
    pressing_there = arrows[1][1]
    assert pytest.approx(1e-6 * total) == pressing_there[:, 1] - pressing_there[:, 0]
    # right below the axes but for the tilt of shoes and of frame
    places = pressing_there[:, 1, [0, 2]]
    assert np.hypot(*(places - hubs[:, [0, 2]]).T) == pytest.approx(radius, abs=2e-3)
    # from above, treads are on their rails
    seen = treads(by_name(plan_solids(now, (0.0, 1.0)))["rollers"])
    assert seen[..., 0] == pytest.approx(np.repeat(hubs[:, :1], 2, axis=1), abs=1e-4)
    assert seen[..., 1] - hubs[:, 1:2] == pytest.approx(np.tile(rolled.case.shoe.rails.middles, (3, 1)))


def test_rollers_roll_without_slip(rolled):
    case = rolled.case
    spokes = []
    for row in (0, -1):
        _, mark = wheel_solids(History(case, rolled.dataset.isel(time=[row])))
        ends = mark.at().points[:8].reshape(2, 4, 3).mean(axis=1)
        spokes.append((ends[1] - ends[0])[[0, 2]])
    turned = np.arctan2(*spokes[1]) - np.arctan2(*spokes[0])
    way = float(np.ptp(rolled.side_frame_position.sel(axis="x").values))
    assert turned * case.undercarriage.radius == pytest.approx(way, rel=1e-3)


def test_rollers_keep_their_depth_in_rails_where_the_ground_is_magnified(rolled):
    """They rise with the shoes below them, by what the ground's displacement there is drawn larger."""
    now = last(rolled)
    heights = {}
    for scale in (1.0, 4.0, 7.0):
        surfaces, _ = side(rolled, scale)
        heights[scale] = treads(surfaces["rollers"]).mean(axis=1)[:, 2]
        tops = outlines(surfaces)[:, 2:].reshape(-1, 2)
        tops = tops[np.argsort(tops[:, 0])]
        heights[scale] -= np.interp(axes_of_rollers(rolled, now)[:, 0], *tops.T)
    # a shoe's drawn edge is straight, the ground below it may have a kink
    assert heights[4.0] == pytest.approx(heights[1.0], abs=0.02)
    assert heights[7.0] == pytest.approx(heights[1.0], abs=0.04)


def test_a_tread_is_a_closed_surface_with_the_volume_of_its_disc(rolled):
    frame = rolled.case.undercarriage
    tread, _ = wheel_solids(last(rolled))
    points, triangles = tread.points, tread.triangles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    disc = np.pi * frame.radius**2 * frame.tread_width
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(disc, rel=0.01)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_what_acts_on_a_shoe_is_ground_and_rollers(rolled):
    now = rolled.dataset.isel(time=[-1])
    own = now.isel(contact=now.contact_shoe.values == 5)
    contact = (own.normal_force + own.friction_force).sum("contact")
    pressed = rolled.rail_force.isel(time=[-1]).sel(shoe=5)
    places, forces = forces_on(now, 5)
    assert np.isfinite(places).all()
    assert forces.sum(axis=1) == pytest.approx((contact + pressed).values)
    # no roller stands on this one
    assert forces_on(now, 6)[1].shape[1] == ((now.contact_shoe == 6) & (now.area > 0.0)).sum()
