"""Relief of units: they pitch so that their faces meet, and the pair law goes over it."""

import numpy as np
import pytest

from exudyn_crawler import Case, LoadCycle, Terrain, simulate
from exudyn_crawler.case import Heights, statics
from exudyn_crawler.case.parameters.heights import MeasuredGrid, Ramp, Roughness, Stone, Waves
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines.case_files import read_case
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.balance import shoe_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.views.scenes.pictures import side_scene
from exudyn_crawler.views.scenes.track import instants
from studies.sliding import check_sliding

SHOES = 4
HILLS = Heights(parts=(Waves(height=0.2, length=8.0),))


def short_track(relief=HILLS):
    """Few shoes on 1 m units with a relief."""
    few = {"track.shoe_count": SHOES, "terrain.relief": relief}
    return Case.stress("coarse").with_(few, loads=LoadCycle.propel(SHOES), flexible=None)


def rested(case):
    """Force of the ground on the track (3,) at rest, and the places of the shoes (shoes, 6)."""
    q = static_equilibrium(case)
    contact = compiled_system(case).contact
    forces = contact.forces(q, np.zeros_like(q))[: 6 * SHOES].reshape(-1, 6)
    return forces[:, :3].sum(axis=0), q[: 6 * SHOES].reshape(-1, 6)


def test_faces_meet_on_the_relief():
    terrain = Terrain.stress().with_(relief=HILLS)
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_height])
    c, s = np.cos(terrain.tilts), np.sin(terrain.tilts)
    for side in (-1.0, 1.0):
        # a positive pitch turns z towards x
        x = terrain.centers[:, 0] + side * half[0] * c + half[1] * s
        z = terrain.centers[:, 2] - side * half[0] * s + half[1] * c
        edge = terrain.middles[:, 0] + side * half[0]
        steepest = np.abs(terrain.slopes).max()
        assert x == pytest.approx(edge, abs=0.5 * half[0] * steepest**2)
        rise = HILLS.sample(edge, np.zeros_like(edge))[:, 0]
        assert z == pytest.approx(rise, abs=0.5 * half[0] * steepest**3)
        assert terrain.surface(edge) == pytest.approx(rise, abs=1e-12)


@pytest.mark.simulation
def test_a_lifted_ground_lifts_the_track_and_changes_nothing_else():
    even, lifted = rested(short_track(Heights())), rested(short_track(Heights(level=0.75)))
    np.testing.assert_allclose(lifted[0], even[0], rtol=1e-9, atol=1e-2)
    rise = lifted[1] - even[1]
    np.testing.assert_allclose(rise, np.tile([0, 0, 0.75, 0, 0, 0], (SHOES, 1)), atol=1e-9)


@pytest.mark.simulation
def test_on_an_incline_normals_lean_and_shoes_lie_along_it():
    incline = 0.06
    level, leaning = short_track(Heights()), short_track(Heights(slope_x=incline))
    (even, start), (found, places) = rested(level), rested(leaning)
    weight = level.loads.loads(0.0).sum() + SHOES * level.shoe.mass * level.gravity
    assert found[2] == pytest.approx(weight, rel=1e-6)
    # without slip there is no friction; units also tilt under the ends of the track, which even ground shows
    assert found[0] - even[0] == pytest.approx(-incline * weight, rel=0.01)
    assert (places - start)[:, 4].mean() == pytest.approx(-np.arctan(incline), rel=0.02)


@pytest.mark.simulation
def test_both_formulations_rest_alike_on_a_hill():
    case = short_track()
    compiled, engine = (static_equilibrium(case.with_(formulation=kind)) for kind in ("compiled", "engine"))
    np.testing.assert_allclose(compiled[: 6 * SHOES], engine[: 6 * SHOES], atol=1e-8)


@pytest.mark.simulation
def test_a_relief_that_is_too_much_at_once_rises_in_portions():
    hills = Heights(parts=(Waves(height=1.0, length=20.0),))
    case = Case.translation().with_({"terrain.relief": hills, "terrain.tilt": "pitch"})
    shoes = case.gear.shoe_reference(case) + static_equilibrium(case)[: 6 * 13].reshape(-1, 6)
    above = shoes[:, 2] - case.terrain.surface(shoes[:, 0])
    assert np.all((above > 0.0) & (above < 2.0 * case.shoe.com_height))


@pytest.mark.simulation
@pytest.mark.slow
def test_flexible_and_rigid_shoes_go_over_a_hill_in_balance():
    case = short_track()
    flexible = Case.stress("coarse").flexible.with_(shoes=(2,))
    history = simulate(case.with_(flexible=flexible), 0.05)
    assert np.abs(history.angles.sel(axis="y")).max() > 0.02
    weight = float(statics.pressed(case, case.loads.loads(0.0)[0]).sum())
    assert np.abs(shoe_imbalance(history).force.values).max() < 1e-6 * weight
    units = side_scene(instants(history, [history.duration])).solids[0]
    # corner 3 is the rear edge of a face and 2 the front one
    faces = units.points.reshape(-1, 4, 3)
    assert faces[1:, 3, 2] == pytest.approx(faces[:-1, 2, 2], abs=1e-3)


@pytest.mark.simulation
@pytest.mark.slow
def test_only_a_drive_beside_the_middle_starts_with_a_jolt_on_an_incline():
    """The node that is pulled lies 5 cm beside the middle, and friction needs slip to hold its moment."""
    incline = short_track(Heights(slope_x=0.06))
    flexible = Case.stress("coarse").flexible.with_(shoes=(SHOES,), static_fields=False)
    start = {}
    for point in ("com node", "frame"):
        history = simulate(incline.with_({"drive.point": point}, flexible=flexible), 0.02)
        start[point] = np.abs(history.angular_acceleration.isel(time=0, axis=2)).max()
        # creeping: 1 % of the stiction speed
        assert np.abs(history.velocity.values).max() < 1e-4
    assert start["frame"] < 0.05 < 1.0 < start["com node"] < 3.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"relief": Heights(parts=(Ramp(x=14.0, height=0.3, flank=1.0),))},
            "relief must not rise or fall by more than 0.2 m a metre along units, got 0.287",
        ),
        (
            {"relief": Heights(parts=(Stone(x=14.0, y=9.0, height=0.1, flank=1.0),))},
            "relief must be the same across y where units lie in rows, .* 0.0882 m; model 'cells' takes any",
        ),
        ({"relief": HILLS, "tilt": "roll"}, "tilt must be 'pitch' on a relief, along which units pitch"),
    ],
)
def test_bad_reliefs_are_refused(change, message):
    with pytest.raises(ParameterError, match=message):
        Terrain.stress().with_(**change)


def test_measured_heights_must_cover_the_units(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((40, 40)))
    measured = MeasuredGrid(file=tmp_path / "a.npy", spacing=0.5)
    with pytest.raises(ParameterError, match="must have heights over the whole terrain"):
        Terrain.stress().with_(relief=Heights(measured=measured))
    wide = Heights(measured=measured.with_(spacing=1.0))
    assert not Terrain.stress().with_(relief=wide).top_heights.any()
    assert wide == Heights(measured=measured.with_(spacing=1.0))


def test_what_takes_no_relief_says_so():
    with pytest.raises(ParameterError, match="terrain_formulation must be 'reduced' on a"):
        short_track().with_(terrain_formulation="constrained")
    with pytest.raises(ValueError, match=r"terrain\.relief must be level: a track has no steady state"):
        check_sliding(short_track(), 0.1)


def test_a_case_file_has_hills_and_roughness_in_a_few_lines(tmp_path):
    relief = """
[terrain.relief]
scale = 0.5
[[terrain.relief.parts]]
model = "waves"
height = 0.2
length = 10.0
"""
    (tmp_path / "a.toml").write_text('base = "stress"' + relief, encoding="utf-8")
    case = read_case(tmp_path / "a.toml").case
    x = np.array([10.0, 15.0])
    assert case.terrain.surface(x) == pytest.approx([0.0, 0.1], abs=0.01)
    rough = Heights(roughness=Roughness(spectrum=1e-3, shortest=4.0))
    strip = Terrain.stress().with_(rows=1, relief=rough)
    assert strip.top_heights.std() > 0.0
