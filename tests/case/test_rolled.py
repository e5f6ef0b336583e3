"""Cases of a side frame that rolls, with a shovel's force and moment on it: files, and what is refused."""

import re

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, LoadCycle, Shoe
from exudyn_crawler.case import MachineCycle, Rails, Rolled, ph4100c, statics
from exudyn_crawler.case.parameters.checks import implausible
from exudyn_crawler.case.parameters.machine_cycle import MachinePhase, Pose
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import CaseFile, read_case, write_case
from exudyn_crawler.model.flexible_shoes import check_shoe
from meshes import mesh_named
from meshes.rails import rail_outline, station_weights
from tests.rolled import SHOES, small_case, small_flexible_case

ROLLED = Case.rolled()
FRAME = Rolled.ph4100c()
DOWN = np.array([0.0, 0.0, -1.0])
NOTHING = (0.0, 0.0, 0.0)
SHOVEL, PAYLOAD = ph4100c.SHOVEL, 9e4
WHOLE = SHOVEL["mass"] + PAYLOAD
LEVER = (SHOVEL["front"] + PAYLOAD) * 15.0 + SHOVEL["upper"] * SHOVEL["upper_place"][0]
"""kg m, by hand: payload and front at 15 m to the one side, the upper structure 2.5 m to the other."""


def test_machine_is_plausible_and_rollers_carry_half_of_it_without_its_shoes():
    assert (Case.translation().gear.kind, ROLLED.gear.kind) == ("dragged", "rolled")
    assert list(implausible(ROLLED, 10.0)) == []
    assert FRAME.mass == pytest.approx(630_185, abs=1.0)
    assert ROLLED.shoe.rails == Rails.ph4100c()
    assert small_case().loads.shoe_count == SHOES


def test_case_file_gives_the_case_again(read, tmp_path):
    whole = CaseFile(case=ROLLED, duration=3.0)
    assert read_case(write_case(whole, tmp_path / "case.toml")) == whole
    short = 'base = "rolled"\nduration = 3.0\n[gear]\nbase = "ph4100c"\nradius = 0.38\n'
    assert read(short).case.gear.radius == 0.38


@pytest.mark.parametrize(
    ("base", "change", "said"),
    [
        (
            FRAME,
            {"rollers": (-1.0, -0.3, 1.0)},
            "rollers must be in order and at least a diameter, 0.8 m, apart",
        ),
        (FRAME, {"rollers": (-5.6, 0.0)}, "rollers must be within the frame"),
        (FRAME, {"ends": (5.8, -5.8)}, "ends must be rear and front end in this order"),
        (FRAME, {"tumbler": 7.0}, "tumbler must be within the frame's ends"),
        (FRAME, {"inertia": (1.0, 1.0, 10.0, 0.0, 0.0, 0.0)}, "inertia: must be the inertia of a body"),
        (FRAME, {"rollers": (0.0,)}, "at least 2"),
        (ROLLED, {"shoe": Shoe.ph4100c()}, "shoe.rails must be given"),
        (ROLLED, {"terrain_formulation": "constrained"}, "terrain_formulation 'constrained' do not go with"),
        (ROLLED, {"drive": Drive.turning()}, "drive.turn_rate must be none"),
        (ROLLED, {"drive": Drive.to_rest()}, "drive.on must be none"),
        (ROLLED, {"loads": LoadCycle.propel(24)}, "loads must be zero"),
        (ROLLED, {"gear.tread_width": 0.3}, "tread_width must not exceed the rails' width"),
        (ROLLED, {"gear.start": 12.0}, "track must be long enough for the drive: at t = 0 s"),
        (
            ROLLED,
            {"shoe.rails.rear": 0.1, "gear.radius": 0.2},
            "must leave a gap from shoe to shoe that rollers cross",
        ),
        (ROLLED, {"shoe.rails.left": -0.1}, "left must be beyond right = -0.24 by the width 0.22, got -0.1"),
    ],
)
def test_frames_that_are_none_and_cases_that_do_not_go_with_one_are_refused(base, change, said):
    with pytest.raises(ParameterError, match=re.escape(said)):
        base.with_(change)


def test_track_shorter_than_the_drive_is_refused():
    case = small_case()
    case.check_support(1.0)
    with pytest.raises(ValueError, match=r"the front roller is at x = .* more shoes"):
        case.check_support(20.0)


def test_rails_of_the_mesh_are_those_of_the_rigid_shoe():
    for rails in (Shoe.from_mesh("coarse").rails.model_dump(), rail_outline(mesh_named("coarse"))._asdict()):
        assert rails == pytest.approx(Rails.ph4100c().model_dump(), abs=1e-9)


def test_mesh_whose_rails_are_elsewhere_is_refused():
    case = small_flexible_case()
    rails = case.shoe.rails.with_(height=0.25)
    with pytest.raises(ValueError, match=r"must have the rails of shoe\.rails within 0\.005 m"):
        check_shoe(case.with_(shoe=case.shoe.with_(rails=rails)))


def test_mesh_without_rails_is_refused():
    bare = mesh_named("coarse").with_surfaces({})
    del bare.surfaces["rails"]
    with pytest.raises(ValueError, match="must have the surface 'rails'"):
        rail_outline(bare)


def test_shares_of_a_force_on_a_rail_have_its_force_and_moment():
    mesh = mesh_named("coarse")
    places = [(-0.2957, -0.24), (0.0, 0.3), (0.304, 0.18)]
    weights = station_weights(mesh, places)
    for row, (x, y) in zip(weights, places, strict=True):
        assert row.sum() == pytest.approx(1.0)
        assert tuple(row @ mesh.nodes[:, :2]) == pytest.approx((x, y), abs=1e-9)


def pose(swing, payload=PAYLOAD):
    return Pose(f"at {swing:g}", 1.0, swing, 15.0, 5.0, payload)


def resultant(swing, side=1.0):
    """Vertical force on the frame (N, downward) with its weight, and x and y where it acts, m."""
    (phase,) = MachineCycle.shovel(poses=[pose(swing)], side=side).phases
    weight = FRAME.mass * ph4100c.GRAVITY * DOWN
    force, moment = np.array(phase.force) + weight, np.array(phase.moment) + np.cross(FRAME.com, weight)
    return -force[2], moment[1] / -force[2], -moment[0] / -force[2]


@pytest.mark.parametrize("swing", [0.7, np.pi / 2])
def test_both_tracks_carry_the_whole(swing):
    assert resultant(swing)[0] + resultant(swing, side=-1.0)[0] == pytest.approx(WHOLE * ph4100c.GRAVITY)


def test_shares_are_those_of_statics():
    share = 0.5 * WHOLE + LEVER / ph4100c.GAUGE
    assert resultant(np.pi / 2)[0] == pytest.approx(share * ph4100c.GRAVITY)


def test_straight_ahead_the_weight_moves_ahead_and_the_tracks_share_alike():
    carried, x, y = resultant(0.0)
    assert carried == pytest.approx(0.5 * WHOLE * ph4100c.GRAVITY)
    assert x == pytest.approx(LEVER / WHOLE)
    assert y == pytest.approx(0.0, abs=1e-9)


def test_papers_machine_can_stand():
    case = Case.rolled().with_(machine=MachineCycle.shovel())
    force, moment = statics.machine_wrench(case, np.linspace(0.0, 40.0, 9))
    assert force.shape == moment.shape == (9, 3)
    assert np.ptp(force[:, 2]) > 1e6


def test_wrench_is_joined_by_steps():
    first = MachinePhase(name="a", end=0.0, force=NOTHING, moment=NOTHING)
    second = MachinePhase(name="b", end=2.0, force=(0.0, 0.0, -4.0), moment=(0.0, 8.0, 0.0))
    force, moment = MachineCycle(phases=(first, second)).wrench([0.0, 1.0, 5.0])
    np.testing.assert_allclose(force[:, 2], [0.0, -2.0, -4.0])
    np.testing.assert_allclose(moment[:, 1], [0.0, 4.0, 8.0])


def test_machine_that_tips_over_a_track_has_odd_times_or_no_frame_is_refused():
    with pytest.raises(ValueError, match="the machine tips sideways at the end of"):
        MachineCycle.shovel(poses=[pose(np.pi / 2, payload=1e6)])
    with pytest.raises(ParameterError, match="the phases' ends must increase"):
        MachineCycle.shovel(poses=[pose(0.0, payload=0.0), pose(0.1, payload=0.0)])
    with pytest.raises(ParameterError, match=r"machine must be none with gear\.kind 'dragged'"):
        Case.translation().with_(machine=MachineCycle.shovel())


@pytest.mark.parametrize(
    ("force", "moment", "said"),
    [
        ((0.0, 0.0, 7e6), NOTHING, "it lifts the side frame"),
        (
            NOTHING,
            (0.0, 3e7, 0.0),
            r"it tips: rollers are from -4\.375 to 4\.375 m, what they carry, .* N without the chain on the "
            r"ground, acts at x = ",
        ),
        (NOTHING, (3e6, 0.0, 0.0), "the side frame tips"),
    ],
)
def test_cycles_in_which_a_roller_would_pull_are_refused(force, moment, said):
    phase = MachinePhase(name="wrong", end=1.0, force=force, moment=moment)
    with pytest.raises(ParameterError, match=said):
        Case.rolled().with_(machine=MachineCycle(phases=(phase,)))
