"""Gear of a closed track as solids, and the tension along its chain, of instants that are made by hand."""

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Case, History
from exudyn_crawler.model.forces.teeth import Profile, tooth
from exudyn_crawler.results.history.summary import tension_along_chain
from exudyn_crawler.views.figures import chain_figure
from exudyn_crawler.views.scenes import gear

ANGLE = 0.7
"""rad that the tumbler turns between the two instants."""
MOVED = 0.02
"""m that the idler slides forward meanwhile."""


@pytest.fixture(scope="module")
def closed():
    """Two instants of a closed track: as assembled, and with another angle of its tumbler."""
    case = Case.closed()
    start, shoes = case.assembled, case.track.shoe_count
    forces = np.zeros((2, shoes, 3))
    forces[:, 5] = 0.0, 0.0, -2e5
    moments = np.zeros_like(forces)
    moments[:, 5] = 0.0, 4e4, 0.0  # of the force 0.2 m ahead of the COM
    links = np.zeros((2, shoes, 3))
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
            "tooth_force": (per_shoe, np.zeros_like(forces)),
            "tooth_moment": (per_shoe, np.zeros_like(forces)),
            "joint_force": (("time", "joint", "axis"), links),
        },
        {
            "time": [0.0, 1.0],
            "shoe": case.track.shoes,
            "joint": case.joints,
            "axis": ["x", "y", "z"],
            "wheel": case.closed_track.wheel_names,
        },
    )
    return History(case, data)


def solids(history):
    return {one.name: one for one in gear.gear_solids(history)}


def test_outline_of_the_teeth_is_where_lugs_touch(closed):
    case = closed.case
    profile = Profile(*case.closed_track.tumbler.profile(case.track))
    for x, z in gear.tooth_outline(case):
        assert np.hypot(x, z) <= profile.addendum + 1e-12
        # a lug that touches there from within its gap has no depth
        k = round(np.arctan2(z, x) / (2.0 * np.pi / profile.gaps)) * 2.0 * np.pi / profile.gaps
        center = profile.center * np.array([np.cos(k), np.sin(k)])
        inward = center + (1.0 - profile.lug / profile.arc) * (np.array([x, z]) - center)
        assert tooth(profile, *inward)[0] == pytest.approx(0.0, abs=1e-9)


def test_lugs_sit_in_the_gaps_of_the_tumbler_and_turn_with_it(closed):
    found, case = solids(closed), closed.case
    wheel, lugs = found["tumbler"], found["lugs"]
    profile = Profile(*case.closed_track.tumbler.profile(case.track))
    local = np.einsum("nj,jk->nk", lugs.origin[0] - wheel.origin[0, 0], wheel.turn[0, 0])
    near = np.hypot(local[:, 0], local[:, 2]) < profile.addendum
    assert near.sum() >= 8  # four shoes with a lug on either side
    assert max(tooth(profile, x, z)[0] for x, _, z in local[near]) < 1e-3
    turned = wheel.turn[0, 0].T @ wheel.turn[1, 0]
    assert turned[0, 2] == pytest.approx(np.sin(ANGLE))


def test_wheels_stand_below_the_rails_and_roll_with_the_chain(closed):
    found, case = solids(closed), closed.case
    table = case.closed_track.wheels(case.assembled.take_up)
    kinds = ("rollers", "idler", "carriers")
    axes = np.concatenate([found[name].origin[0, ::2] for name in kinds]) - case.assembled.frame
    assert axes[:, [0, 2]] == pytest.approx(table[:, :2])
    slid = {name: found[name].origin[1] - found[name].origin[0] for name in kinds}
    assert slid["idler"] == pytest.approx(np.tile([MOVED, 0.0, 0.0], (2, 1)))
    assert np.concatenate([slid["rollers"], slid["carriers"]]) == pytest.approx(0.0)
    radii = [np.abs(found[name].points[:, 2]).max() for name in kinds]
    assert radii == pytest.approx([0.4, 0.9, 0.25])
    way = ANGLE * case.closed_track.travel_per_angle(case.track)
    for name, radius in zip(kinds, radii, strict=True):
        turn = found[name].turn[0, 0].T @ found[name].turn[1, 0]
        assert turn[0, 2] == pytest.approx(np.sin(way / radius))


def test_slides_are_bars_below_the_upper_run(closed):
    case = closed.case.with_({"closed_track.carriers": (), "closed_track.slides": ((-2.0, 1.0, 1.9),)})
    found = solids(History(case, closed.dataset))
    bar, (x, z) = found["slide 1"], closed.case.assembled.frame[[0, 2]]
    points = bar.points + bar.origin[0, 0]
    assert bar.origin.shape == (2, 2, 3)
    assert [points[:, 0].min() - x, points[:, 0].max() - x] == pytest.approx([-2.0, 1.0])
    assert points[:, 2].max() - z == pytest.approx(1.9)
    assert "carriers" not in found


def test_forces_act_along_their_lines(closed):
    wheels, teeth = (heads for _, _, heads, _ in gear.gear_forces(closed.dataset))
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
    with pytest.raises(ValueError, match="needs a closed track"):
        tension_along_chain(History(Case.rolled(), xr.Dataset()))
