"""Static equilibrium before a run: nothing accelerates and the ground carries the weight."""

import time

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, FlexibleShoes, LoadCycle, Terrain, simulate
from exudyn_crawler.case import statics
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from studies.grounds import plain
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

CASES = {
    "translation": plain(Case.translation()),
    "turning": plain(Case.turning()),
    "constrained": plain(Case.translation()).with_(terrain_formulation="constrained"),
    "constrained turning": plain(Case.turning()).with_(terrain_formulation="constrained"),
    "fine grid": plain(Case.translation()).with_(terrain=Terrain.stress()),
}


# units of either kind and turns are seen apart from each other
BOTH = pytest.param("constrained turning", marks=pytest.mark.slow)


@pytest.fixture(scope="module", params=[*(name for name in CASES if name != "constrained turning"), BOTH])
def start(request):
    """First states of a run: at rest, and after a first step too short for the drive to be felt."""
    case = CASES[request.param]
    # a shorter step would show rounding: accelerations lose digits with its square
    return simulate(case.with_(solver=case.solver.with_(step=1e-4, residual=0.02)), 1e-4)


def test_no_shoe_or_unit_accelerates(start):
    for name in ("acceleration", "angular_acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        for when in (0, -1):
            assert np.abs(start.dataset[name].isel(time=when)).max() < 1e-3, (name, when)  # m/s2 or rad/s2
    # after the step it is really computed
    assert np.abs(start.acceleration.isel(time=-1)).max() > 0.0


def test_contact_carries_the_track_and_springs_carry_the_terrain_too(start):
    case = start.case
    weight = 13 * (case.shoe.mass * case.gravity + 386.4e3)
    carried = (start.normal_force + start.friction_force).isel(time=0).sum("contact")
    assert float(carried.sel(axis="z")) == pytest.approx(weight, rel=1e-6)
    # on tilted units the normal forces lean by some N, which the held front shoe takes
    assert abs(float(carried.sel(axis="x"))) < 1e-3 * weight
    assert abs(float(carried.sel(axis="y"))) < 1e-6 * weight
    springs = -case.terrain.heave_stiffness * float(start.unit_heave.isel(time=0).sum())
    units = case.terrain.unit_count * case.terrain.unit_mass * case.gravity
    assert springs == pytest.approx(weight + units, rel=1e-6)


def test_a_long_track_rests_on_normals_that_lean():
    # twice as long as the papers' track: from the first guess alone Newton's method does not find it
    shoes, base = 24, Case.translation()
    track, terrain = base.track.with_(shoe_count=shoes), base.terrain.with_(columns=8)
    case = base.with_(track=track, terrain=terrain, loads=LoadCycle.constant([386.4e3] * shoes))
    rest, system = static_equilibrium(case), compiled_system(case)
    contacts, _ = system.contact.results(rest[None], np.zeros_like(rest)[None])
    carried = contacts[:, RESULT["normal_force"]].sum(axis=0)
    assert carried[2] == pytest.approx(shoes * (case.shoe.mass * case.gravity + 386.4e3), rel=1e-6)


def test_units_that_roll_push_a_track_aside_until_friction_takes_hold(translation):
    """Their normals lean; friction, which needs slip, has none at rest."""
    history = translation.dataset.sel(time=slice(0.0, 0.0201))
    weight, mass = 13 * statics.mean_load(translation.case), 13 * translation.case.shoe.mass
    aside = (history.normal_force + history.friction_force).sel(axis="y").sum("contact").values
    start, end = history.isel(time=0), history.isel(time=-1)
    assert 0.0 < -aside[0] < float(np.abs(start.unit_tilt).max()) * weight
    assert float(start.acceleration.sel(axis="y").mean()) == pytest.approx(aside[0] / mass, rel=1e-3)
    for name in ("unit_heave_acceleration", "unit_tilt_acceleration"):
        assert np.abs(start[name]).max() < 1e-3
    assert abs(aside[-1]) < 0.1 * abs(aside[0])
    assert np.abs(end.velocity.sel(axis="y")).max() < 3e-4  # m/s of creep


@pytest.mark.parametrize("point", ["com node", "front pins"])
def test_a_shoe_that_is_pulled_at_a_point_is_held_there(point):
    """The ground leans on the front shoe, and the drive takes over what held it.

    Measured: 1e-4 m/s2 where the frame, held in place of the point, would start at 0.04 m/s2. What is left
    comes of the points' places beside the shoe's middle: nothing but friction, which needs slip, withstands
    the turn.
    """
    case = plain(Case.translation()).with_(
        terrain=Terrain.stress(),
        drive=Drive.translation().with_(point=point),
        flexible=FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=(13,)),
    )
    start = simulate(case, 2e-3).dataset.isel(time=0)
    assert 200.0 < -float(start.drive_force) < 400.0
    assert np.abs(start.acceleration).max() < 1e-3
    assert np.abs(start.unit_heave_acceleration).max() < 1e-3
    front = case.track.com_positions(case.shoe.com_height)[-1, 0]
    assert start.drive_point.sel(axis="x") == pytest.approx(
        front + compiled_system(case).point.place[0], abs=1e-9
    )


def test_every_shoe_sinks_about_as_deep_as_the_papers_say(translation):
    depth = translation.penetration.isel(time=0)[np.isin(translation.contact_shoe, [3, 10, 12])]
    assert depth.values == pytest.approx(np.full(3, 0.0657), rel=0.1)


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (Case.rolled().on_cells(BekkerSoil.lete_sand()), r"a shoe of 0\.404 m would sink by [\d.]+ m$"),
        (Case.closed(), r"a shoe of 0\.404 m would sink by [\d.]+ m into units that sink by [\d.]+ m$"),
    ],
)
def test_a_machine_that_no_ground_carries_is_not_searched_a_rest_for(case, words):
    """Creeping had no end where shoes sank by 100 of their heights: 84 of them took over 10 minutes."""
    heavy = case.with_({"gear.mass": 9e8})
    start = time.process_time()
    with pytest.raises(EquilibriumError, match=rf"^no static equilibrium of case .*{words}"):
        static_equilibrium(heavy)
    assert time.process_time() - start < 5.0
    # three times the weight still has a place where shoes may rest
    assert checks.bottomless(case.with_({"gear.mass": 3.0 * case.gear.mass})) is None
