"""Smooth ground by a profile: units pitch so that their faces meet, and the pair law goes over it."""

import numpy as np
import pytest

from exudyn_crawler import Case, LoadCycle, SphereContact, Terrain, simulate
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.loads.balance import shoe_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.views.scenes.pictures import side_scene
from exudyn_crawler.views.scenes.track import instants
from studies.sliding import check_sliding

SHOES = 4


def short_track(profile=None, base=None):
    """Few shoes on 1 m units, whose ground is a function of x."""
    base = Case.stress("coarse") if base is None else base
    case = base.with_(track=base.track.with_(shoe_count=SHOES), loads=LoadCycle.propel(SHOES), flexible=None)
    return case if profile is None else case.with_(terrain=case.terrain.with_profile(profile))


def hill(x):
    return 0.1 * (1.0 - np.cos(2.0 * np.pi * x / 8.0))


def rested(case):
    """Force of the ground on the track (3,) at rest, and the places of the shoes (shoes, 6)."""
    q = static_equilibrium(case)
    contact = compiled_system(case).contact
    forces = contact.forces(q, np.zeros_like(q))[: 6 * SHOES].reshape(-1, 6)
    return forces[:, :3].sum(axis=0), q[: 6 * SHOES].reshape(-1, 6)


def test_faces_meet_at_the_profile():
    terrain = Terrain.stress().with_profile(hill)
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_height])
    c, s = np.cos(terrain.tilts), np.sin(terrain.tilts)
    for side in (-1.0, 1.0):
        # a positive pitch turns z towards x
        x = terrain.centers[:, 0] + side * half[0] * c + half[1] * s
        z = terrain.centers[:, 2] - side * half[0] * s + half[1] * c
        edge = terrain.middles[:, 0] + side * half[0]
        steepest = np.abs(terrain.slopes).max()
        assert x == pytest.approx(edge, abs=0.5 * half[0] * steepest**2)
        assert z == pytest.approx(hill(edge), abs=0.5 * half[0] * steepest**3)


@pytest.mark.simulation
def test_a_lifted_ground_lifts_the_track_and_changes_nothing_else():
    even, lifted = rested(short_track()), rested(short_track(lambda x: 0.75))
    np.testing.assert_allclose(lifted[0], even[0], rtol=1e-9, atol=1e-2)
    rise = lifted[1] - even[1]
    np.testing.assert_allclose(rise, np.tile([0, 0, 0.75, 0, 0, 0], (SHOES, 1)), atol=1e-9)


@pytest.mark.simulation
def test_on_an_incline_normals_lean_and_shoes_lie_along_it():
    incline = 0.06
    level, leaning = short_track(), short_track(lambda x: incline * x)
    (even, start), (found, places) = rested(level), rested(leaning)
    weight = level.loads.loads(0.0).sum() + SHOES * level.shoe.mass * level.gravity
    assert found[2] == pytest.approx(weight, rel=1e-6)
    # without slip there is no friction; units also tilt under the ends of the track, which even ground shows
    assert found[0] - even[0] == pytest.approx(-incline * weight, rel=0.01)
    assert (places - start)[:, 4].mean() == pytest.approx(-np.arctan(incline), rel=0.02)


@pytest.mark.simulation
def test_both_formulations_rest_alike_on_a_hill():
    case = short_track(hill)
    compiled, engine = (static_equilibrium(case.with_(formulation=kind)) for kind in ("compiled", "engine"))
    np.testing.assert_allclose(compiled[: 6 * SHOES], engine[: 6 * SHOES], atol=1e-8)


@pytest.mark.simulation
def test_a_profile_that_is_too_much_at_once_rises_in_portions():
    case = Case.translation()
    case = case.with_(terrain=case.terrain.with_profile(lambda x: 0.5 * (1.0 - np.cos(0.1 * np.pi * x))))
    q = static_equilibrium(case)
    shoes = case.track.com_positions(case.shoe.com_height) + q[: 6 * 13].reshape(-1, 6)[:, :3]
    above = shoes[:, 2] - case.terrain.profile_along(shoes[:, 0])
    assert np.all((above > 0.0) & (above < 2.0 * case.shoe.com_height))


@pytest.mark.simulation
def test_flexible_and_rigid_shoes_go_over_a_hill_in_balance():
    case = short_track(hill)
    flexible = Case.stress("coarse").flexible.with_(shoes=(2,))
    history = simulate(case.with_(flexible=flexible), 0.05)
    assert np.abs(history.angles.sel(axis="y")).max() > 0.02
    weight = float(case.pressed(case.loads.loads(0.0)[0]).sum())
    assert np.abs(shoe_imbalance(history).force.values).max() < 1e-6 * weight
    units = side_scene(history.case, instants(history, [history.duration])).solids[0]
    # corner 3 is the rear edge of a face and 2 the front one
    faces = units.points.reshape(-1, 4, 3)
    assert faces[1:, 3, 2] == pytest.approx(faces[:-1, 2, 2], abs=1e-3)


@pytest.mark.simulation
def test_only_a_drive_beside_the_middle_starts_with_a_jolt_on_an_incline():
    """The node that is pulled lies 5 cm beside the middle, and friction needs slip to hold its moment."""
    incline = short_track(lambda x: 0.06 * x)
    flexible = Case.stress("coarse").flexible.with_(shoes=(SHOES,), static_fields=False)
    start = {}
    for point in ("com node", "frame"):
        drive = incline.drive.with_(point=point)
        history = simulate(incline.with_(flexible=flexible, drive=drive), 0.02)
        start[point] = np.abs(history.angular_acceleration.isel(time=0, axis=2)).max()
        # creeping: 1 % of the stiction speed
        assert np.abs(history.velocity.values).max() < 1e-4
    assert start["frame"] < 0.05 < 1.0 < start["com node"] < 3.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"profile": (0.0,) * 19}, r"profile must name every edge of columns \(20\), got 19"),
        (
            {"profile": (0.0,) * 19 + (0.3,)},
            "must not rise or fall by more than 0.2 m a metre, got 0.3",
        ),
        ({"profile": (0.0,) * 20, "heights": (0.0,) * 247}, "heights must be None where a profile is given"),
        (
            {"profile": (0.0,) * 20, "tilt": "roll"},
            "tilt must be 'pitch' where a profile is given",
        ),
        ({"profile": (0.0,) * 19 + (float("nan"),)}, "finite"),
    ],
)
def test_bad_profiles_are_refused(change, message):
    with pytest.raises(ParameterError, match=message):
        Terrain.stress().with_(**change)


def test_what_takes_no_profile_says_what_does():
    case = short_track(hill)
    with pytest.raises(ParameterError, match=r"terrain.profile must be None with contact\.model 'spheres'"):
        case.with_(contact=SphereContact.oil_sand())
    with pytest.raises(ParameterError, match="terrain_formulation must be 'reduced' on a"):
        case.with_(terrain_formulation="constrained")
    with pytest.raises(ParameterError, match=r"no steps between units but a smooth terrain\.profile"):
        Case.stress("coarse").with_(terrain=Terrain.stress().with_step(14.0, 0.1))
    with pytest.raises(ValueError, match=r"terrain\.profile must be None: a track has no steady state"):
        check_sliding(case, 0.1)
