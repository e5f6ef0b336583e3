"""Cases of a side frame that rolls: files, and what is refused."""

import re

import pytest

from exudyn_crawler import Case, Drive, LoadCycle, Shoe
from exudyn_crawler.case import CaseFile, Rails, Undercarriage, read_case, write_case
from exudyn_crawler.case.parameters.checks import implausible
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.flexible_shoes import check_shoe
from meshes import mesh_named
from meshes.rails import rail_outline, station_weights
from tests.rolled import SHOES, small_case, small_flexible_case

ROLLED = Case.rolled()
FRAME = Undercarriage.ph4100c()


def test_machine_is_plausible_and_rollers_carry_half_of_it_without_its_shoes():
    assert (Case.translation().is_rolled, ROLLED.is_rolled) == (False, True)
    assert list(implausible(ROLLED, 10.0)) == []
    assert FRAME.mass == pytest.approx(630_185, abs=1.0)
    assert ROLLED.shoe.rails == Rails.ph4100c()
    assert small_case().loads.shoe_count == SHOES


def test_case_file_gives_the_case_again(read, tmp_path):
    whole = CaseFile(case=ROLLED, duration=3.0)
    assert read_case(write_case(whole, tmp_path / "case.toml")) == whole
    short = 'base = "rolled"\nduration = 3.0\n[undercarriage]\nbase = "ph4100c"\nradius = 0.38\n'
    assert read(short).case.undercarriage.radius == 0.38


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rollers": (-1.0, -0.3, 1.0)}, "rollers must stand in order and a diameter 0.8 m apart"),
        ({"rollers": (-5.6, 0.0)}, "rollers must be within the frame"),
        ({"ends": (5.8, -5.8)}, "ends must be rear and front end in this order"),
        ({"tumbler": 7.0}, "tumbler must be within the frame's ends"),
        ({"inertia": (1.0, 1.0, 10.0, 0.0, 0.0, 0.0)}, "inertia: must be that of a body"),
        ({"rollers": (0.0,)}, "at least 2"),
    ],
)
def test_undercarriages_that_are_none_are_refused(change, said):
    with pytest.raises(ParameterError, match=re.escape(said)):
        FRAME.with_(**change)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"shoe": Shoe.ph4100c()}, "shoe.rails must be given"),
        ({"formulation": "engine"}, "formulation 'engine'"),
        ({"drive": Drive.turning()}, "drive.turn_rate must be None"),
        ({"drive": Drive.to_rest()}, "drive.on must be None"),
        ({"loads": LoadCycle.propel(24)}, "loads must be zero"),
        ({"undercarriage": FRAME.with_(tread_width=0.3)}, "tread_width must not exceed the rails' width"),
        ({"undercarriage": FRAME.with_(start=12.0)}, "track must be long enough for the drive: at t = 0 s"),
        (
            {"shoe.rails.rear": 0.1, "undercarriage.radius": 0.2},
            "must leave a gap from shoe to shoe that rollers cross",
        ),
        ({"shoe.rails.left": -0.1}, "left must be beyond right = -0.24 by the width 0.22, got -0.1"),
    ],
)
def test_cases_that_do_not_go_with_a_frame_are_refused(change, said):
    with pytest.raises(ParameterError, match=re.escape(said)):
        ROLLED.with_(change)


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
    mesh = mesh_named("coarse")
    bare = mesh.with_surfaces({})
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
