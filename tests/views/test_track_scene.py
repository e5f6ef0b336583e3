"""The track in space, from the side and from above, and a closed one's gear: all is where runs have it."""

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.case import statics
from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.gear.running_gear import Bogie
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.forces.teeth import tooth
from exudyn_crawler.results.history.summary import tension_along_chain
from exudyn_crawler.views.figures import chain_figure, history_series
from exudyn_crawler.views.scenes.gear import gear_forces, gear_solids, tooth_outline, wheel_solids
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
from tests.rolled import ROLLERS, small_case

ANGLE = 0.7
"""rad that the tumbler turns between the two instants."""
MOVED = 0.02
"""m that the idler slides forward meanwhile."""


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
    return now.side_frame_position.values + np.outer(history.case.gear.rollers, along)


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
    greatest = float(np.linalg.norm(forces, axis=-1).max())
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
    ground, colours = above["ground"], above["ground"].colourings[0]
    assert ground.values.reshape(-1, 4)[:, 0] == pytest.approx(1e3 * moment.unit_heave.values)
    assert (colours.low, colours.high) == (heave.min(), heave.max())


@pytest.mark.simulation
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


@pytest.mark.simulation
def test_a_ground_figure_shows_what_every_shoe_carries(step):
    figure = ground_figure(step, 0.05)
    view, carried = figure.axes
    assert view.get_title() == "step, t = 0.05 s"
    assert [text.get_text() for text in view.get_legend().get_texts()] == ["ground", "shoes", "link pins"]
    heights = [bar.get_height() for bar in carried.patches]
    _, forces = shoe_forces(last(step).dataset)
    assert heights == pytest.approx(1e-3 * forces[0, :, 2])
    assert np.mean(heights) == pytest.approx(1e-3 * statics.mean_load(step.case), rel=0.1)
    figure.draw_without_rendering()
    left, right = (ax.get_window_extent() for ax in (view, carried))
    assert left.width == pytest.approx(right.width, rel=0.02)


def test_rollers_stand_where_the_frame_has_them_and_press_where_the_history_says(rolled):
    now = last(rolled)
    surfaces, arrows = side(rolled, force_scale=1e-6)
    hubs, radius = axes_of_rollers(rolled, now), rolled.case.gear.radius
    assert treads(surfaces["rollers"]).mean(axis=1)[:, [0, 2]] == pytest.approx(hubs[:, [0, 2]], abs=1e-4)
    assert hubs[:, 2].max() + radius < windows(rolled)[1][3]
    total = rolled.roller_force.isel(time=-1).sum("rail").transpose("roller", "axis").values
    pressing = arrows[1][1]
    assert pressing[:, 1] - pressing[:, 0] == pytest.approx(1e-6 * total)
    # right below the axes but for the tilt of shoes and of frame
    assert np.hypot(*(pressing[:, 1] - hubs)[:, [0, 2]].T) == pytest.approx(radius, abs=2e-3)
    # from above, treads are on their rails
    seen = treads(by_name(plan_solids(now, (0.0, 1.0)))["rollers"])
    assert seen[..., 0] == pytest.approx(np.repeat(hubs[:, :1], 2, axis=1), abs=1e-4)
    assert seen[..., 1] - hubs[:, 1:2] == pytest.approx(np.tile(rolled.case.shoe.rails.middles, (3, 1)))


def test_rollers_roll_without_slip(rolled):
    spokes = []
    for row in (0, -1):
        _, mark = wheel_solids(History(rolled.case, rolled.dataset.isel(time=[row])))
        ends = mark.at().points[:8].reshape(2, 4, 3).mean(axis=1)
        spokes.append((ends[1] - ends[0])[[0, 2]])
    turned = np.arctan2(*spokes[1]) - np.arctan2(*spokes[0])
    way = float(np.ptp(rolled.side_frame_position.sel(axis="x").values))
    assert turned * rolled.case.gear.radius == pytest.approx(way, rel=1e-3)


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
    frame = rolled.case.gear
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


@pytest.fixture(scope="module")
def closed():
    """Two instants of a taut closed track: as assembled, and with another angle of its tumbler."""
    case = Case.closed().with_({"gear.idler.slack": 0.0})
    start, shoes = case.gear.assembled(case), case.track.shoe_count
    forces, moments, links, nothing = np.zeros((4, 2, shoes, 3))
    forces[:, 5] = 0.0, 0.0, -2e5
    moments[:, 5] = 0.0, 4e4, 0.0  # of the force 0.2 m ahead of the COM
    links[0, :, 0] = 1e6 + 1e3 * np.arange(shoes)
    links[1, :, 0] = 2e6
    per_shoe, along = ("time", "shoe", "axis"), ("time", "axis")
    data = xr.Dataset(
        {
            "position": (per_shoe, np.tile(start.shoes[:, :3], (2, 1, 1))),
            "angles": (per_shoe, np.tile(start.shoes[:, 3:], (2, 1, 1))),
            "side_frame_position": (along, np.tile(start.frame, (2, 1))),
            "side_frame_angles": (along, np.zeros((2, 3))),
            "tumbler_position": (along, np.tile(start.tumbler[:3], (2, 1))),
            "tumbler_angle": ("time", [0.0, ANGLE]),
            "take_up": ("time", [start.take_up, start.take_up + MOVED]),
            "wheel_force": (("time", "wheel", "axis"), np.zeros((2, 12, 3))),
            "wheel_load": (per_shoe, forces),
            "wheel_moment": (per_shoe, moments),
            "tooth_force": (per_shoe, nothing),
            "tooth_moment": (per_shoe, nothing),
            "joint_force": (("time", "joint", "axis"), links),
        },
        {
            "time": [0.0, 1.0],
            "shoe": case.track.shoes,
            "joint": case.gear.joints(case.track),
            "axis": ["x", "y", "z"],
            "wheel": case.gear.wheel_names,
        },
    )
    return History(case, data)


def gear_of(history):
    return {one.name: one for one in gear_solids(history)}


def test_outline_of_the_teeth_is_where_lugs_touch(closed):
    case = closed.case
    profile = case.gear.tumbler.profile(case.track)
    for x, z in tooth_outline(case):
        assert np.hypot(x, z) <= profile.addendum + 1e-12
        # a lug that touches there from within its gap has no depth
        k = round(np.arctan2(z, x) / (2.0 * np.pi / profile.gaps)) * 2.0 * np.pi / profile.gaps
        center = profile.center * np.array([np.cos(k), np.sin(k)])
        inward = center + (1.0 - profile.lug / profile.arc) * (np.array([x, z]) - center)
        assert tooth(profile, *inward)[0] == pytest.approx(0.0, abs=1e-9)


def test_lugs_sit_in_the_gaps_of_the_tumbler_and_turn_with_it(closed):
    found, case = gear_of(closed), closed.case
    wheel, lugs = found["tumbler"], found["lugs"]
    profile = case.gear.tumbler.profile(case.track)
    local = np.einsum("nj,jk->nk", lugs.origin[0] - wheel.origin[0, 0], wheel.turn[0, 0])
    near = np.hypot(local[:, 0], local[:, 2]) < profile.addendum
    assert near.sum() >= 8  # four shoes with a lug on either side
    assert max(tooth(profile, x, z)[0] for x, _, z in local[near]) < 1e-3
    assert (wheel.turn[0, 0].T @ wheel.turn[1, 0])[0, 2] == pytest.approx(np.sin(ANGLE))


def test_wheels_stand_below_the_rails_and_roll_with_the_chain(closed):
    found, case = gear_of(closed), closed.case
    table = case.gear.wheels(case.gear.assembled(case).take_up)
    kinds = ("rollers", "idler", "carriers")
    axes = np.concatenate([found[name].origin[0, ::2] for name in kinds]) - case.gear.assembled(case).frame
    assert axes[:, [0, 2]] == pytest.approx(table[:, :2])
    slid = {name: found[name].origin[1] - found[name].origin[0] for name in kinds}
    assert slid["idler"] == pytest.approx(np.tile([MOVED, 0.0, 0.0], (2, 1)))
    assert np.concatenate([slid["rollers"], slid["carriers"]]) == pytest.approx(0.0)
    radii = [np.abs(found[name].points[:, 2]).max() for name in kinds]
    assert radii == pytest.approx([0.4, 0.9, 0.25])
    way = ANGLE * case.gear.travel_per_angle(case.track)
    for name, radius in zip(kinds, radii, strict=True):
        turn = found[name].turn[0, 0].T @ found[name].turn[1, 0]
        assert turn[0, 2] == pytest.approx(np.sin(way / radius))


def test_slides_are_bars_below_the_upper_run(closed):
    case = closed.case.with_({"gear.carriers": (), "gear.slides": ((-2.0, 1.0, 1.9),)})
    found = gear_of(History(case, closed.dataset))
    bar, (x, z) = found["slide 1"], closed.case.gear.assembled(closed.case).frame[[0, 2]]
    points = bar.points + bar.origin[0, 0]
    assert bar.origin.shape == (2, 2, 3)
    assert [points[:, 0].min() - x, points[:, 0].max() - x] == pytest.approx([-2.0, 1.0])
    assert points[:, 2].max() - z == pytest.approx(1.9)
    assert "carriers" not in found


def test_forces_act_along_their_lines(closed):
    wheels, teeth = (heads for _, _, heads, _ in gear_forces(closed.dataset))
    assert wheels[0, 5] - closed.dataset.position.values[0, 5] == pytest.approx([0.2, 0.0, 0.0])
    assert np.isnan(wheels[0, 4]).all()
    assert np.isnan(teeth).all()


def test_tension_of_a_closed_chain_by_links_and_by_places_that_they_come_through(closed):
    along = tension_along_chain(closed)
    assert along.least.values == pytest.approx(1e6 + 1e3 * np.arange(38))
    assert along.greatest.values == pytest.approx(2e6)
    # at the first instant link k is at place k, at the second it is further back
    assert along.mean_at.values == pytest.approx(0.5 * (along.least.values + 2e6))
    parts = along.part.values
    assert (parts == "tumbler").sum() in (4, 5, 6)
    assert parts[2] == "lower run"
    assert parts[parts != "lower run"][0] == "idler"
    assert len(chain_figure(closed).axes) == 4
    with pytest.raises(ValueError, match="must be 'closed' or 'machine'"):
        tension_along_chain(History(Case.rolled(), xr.Dataset()))


BOGIE = {"mass": 2e3, "inertia": (100.0, 800.0, 800.0, 0.0, 0.0, 0.0)}


def test_drawn_rollers_of_a_bogie_stand_on_their_rails():
    """Their axes are a radius from where treads press; the bogie has swung, since a ridge is below one."""
    bogie = Bogie(rollers=(1, 2), pivot=(-0.6, 0.2), **BOGIE)
    ridge = Heights(parts=(Ridge(x=11.4, height=0.06, width=0.3, flank=0.4),))
    case = small_case(bogies=(bogie,)).on_cells(RockFloor.hard_floor(), ridge)
    history = simulate(case, 2e-3, progress=False)
    now = instants(history, [0.0])
    assert now.bogie_angle.item() > 0.02
    solids = by_name(gear_solids(now))
    assert "bogie 1" in solids
    axes = solids["rollers"].origin[0].reshape(-1, 2, 3).mean(axis=1)
    force = now.tread_force.isel(time=0)
    feet = now.tread_foot.isel(time=0).where(np.abs(force).sum("axis") > 0.0)
    feet = feet.mean(("rail", "strip", "neighbour")).transpose("roller", "axis").values
    apart = np.linalg.norm((axes - feet)[:, [0, 2]], axis=1)
    assert apart == pytest.approx(np.full(len(axes), case.gear.radius), abs=1e-3)


def test_drawn_road_wheels_of_arms_stand_on_their_rails():
    """Their axes are a radius from where treads press; arms are drawn from pivot to axis."""
    values = {"mass": 20.0, "inertia": (10.0, 20.0, 20.0, 0.0, 0.0, 0.0), "torque": 5e5, "stiffness": 5e6}
    arms = tuple(Arm(roller=k, pivot=(x + 0.8, 0.1), **values) for k, x in enumerate(ROLLERS, start=1))
    ridge = Heights(parts=(Ridge(x=11.4, height=0.06, width=0.3, flank=0.4),))
    history = simulate(small_case(arms=arms).on_cells(RockFloor.hard_floor(), ridge), 2e-3, progress=False)
    now = instants(history, [0.0])
    assert np.ptp(now.arm_angle.values) > 0.02
    solids = by_name(gear_solids(now))
    assert {"arm 1", "arm 2", "arm 3"} <= set(solids)
    axes = solids["rollers"].origin[0].reshape(-1, 2, 3).mean(axis=1)
    force = now.tread_force.isel(time=0)
    feet = now.tread_foot.isel(time=0).where(np.abs(force).sum("axis") > 0.0)
    feet = feet.mean(("rail", "strip", "neighbour")).transpose("roller", "axis").values
    apart = np.linalg.norm((axes - feet)[:, [0, 2]], axis=1)
    assert apart == pytest.approx(np.full(len(axes), history.case.gear.radius), abs=1e-3)
    pivots = np.array([solids[f"arm {k}"].origin[0, 0] for k in (1, 2, 3)])
    assert np.linalg.norm((axes - pivots)[:, [0, 2]], axis=1) == pytest.approx(np.full(3, np.hypot(0.8, 0.1)))


def test_bogies_of_two_tracks_are_drawn_and_read_on_each():
    rollers = Case.shovel().gear.rollers
    bogie = Bogie(rollers=(1, 2), pivot=(0.5 * (rollers[0] + rollers[1]), 0.2), **BOGIE)
    history = simulate(Case.shovel().with_({"gear.bogies": (bogie,)}), 0.01, progress=False)
    assert history.bogie.values.tolist() == ["right bogie 1", "left bogie 1"]
    left = history.of_track("left")
    assert left.bogie.values.tolist() == ["bogie 1"]
    assert left.wheel.values.tolist() == left.case.gear.wheel_names
    np.testing.assert_array_equal(left.bogie_angle[:, 0], history.bogie_angle[:, 1])
    angles = history_series(history)["angle of the bogies"].values
    assert angles["item"].values.tolist() == ["right bogie 1", "left bogie 1"]
    names = {one.name for one in gear_solids(instants(history, [0.0]))}
    assert {"right bogie 1", "left bogie 1"} <= names


def test_drawn_teeth_of_a_half_pitch_sprocket_have_straight_flanks_and_leave_their_lugs_alone():
    sprocket = {"teeth": 21, "gaps_per_shoe": 2, "depth": None, "reach": None}
    case = Case.closed()
    changes = {f"gear.tumbler.{name}": value for name, value in sprocket.items()}
    case = case.with_(changes | {"gear.carriers": ()})
    outline = tooth_outline(case)
    profile = case.gear.tumbler.profile(case.track)
    radii = np.hypot(*outline.T)
    assert radii.max() == pytest.approx(profile.addendum)
    assert radii.min() == pytest.approx(profile.center - profile.arc)
    # corners of the tips: two a gap
    assert np.isclose(radii, profile.addendum).sum() == 42
    depths = [tooth(profile, *place)[0] for place in outline]
    assert np.array(depths) == pytest.approx(np.full(len(outline), profile.lug), abs=1e-9)
