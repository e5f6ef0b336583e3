"""Tracks on ground of cells that remember: rest, slopes, balances, tangents and modal loads."""

import numpy as np
import pytest

from benchmarks.growth import longer
from exudyn_crawler import Case, Drive, LoadCycle, StepProfile, simulate
from exudyn_crawler.case.parameters.heights import Heights, Ramp, Ridge, Roughness, Stone
from exudyn_crawler.errors import EquilibriumError, ParameterError
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.results.balance import shoe_imbalance, track_imbalance
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.load_map import INERTIA, loads_by_kind, unit_loads
from exudyn_crawler.results.stress.recovery import recover_stresses
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.rest import settle
from tests.model.both import matrix_errors

pytestmark = pytest.mark.simulation

FREE = Drive.translation().with_(on=())
JERK = Drive.translation().with_(speed=StepProfile(times=(0.0, 0.05), values=(0.0, 0.2)))
"""Into full slip within 0.3 s."""
SAND, ROCK = BekkerSoil.lete_sand(), RockFloor.hard_floor()
BOTH_LAWS = pytest.mark.parametrize("law", [SAND, ROCK], ids=["sand", "rock"])


def three_shoes(law, relief=None, base=None, drive=FREE, **slope):
    """Three shoes on cells; the middle one is flexible where the base's are."""
    base = base or Case.translation()
    few = {"track.shoe_count": 3} | ({"flexible.shoes": (2,)} if base.flexible else {})
    terrain = base.terrain.with_(**slope)
    return base.with_(few, loads=LoadCycle.propel(3), terrain=terrain, drive=drive).on_cells(law, relief)


def weight(case):
    return case.loads.loads(0.0).sum() + case.track.shoe_count * case.shoe.mass * case.gravity


@pytest.fixture(scope="module")
def dragged():
    return simulate(three_shoes(SAND, drive=JERK).with_({"solver.residual": 1e-3}), 0.3, False)


def test_shoes_start_at_rest_and_the_ground_carries_them():
    case = three_shoes(SAND)
    start = simulate(case, 4e-3, False)
    assert np.abs(start.acceleration.isel(time=0)).max() < 1e-3  # m/s2
    carried = (start.normal_force + start.friction_force).isel(time=0).sum("contact").values
    assert carried[2] == pytest.approx(weight(case), rel=1e-6)
    assert np.abs(carried[:2]).max() < 1e-6 * weight(case)


def test_what_acts_on_dragged_shoes_is_the_rate_of_their_momentum(dragged):
    imbalance = shoe_imbalance(dragged)
    assert np.abs(imbalance.force).max() < 0.05  # N, of 400 kN in single precision
    assert np.abs(imbalance.moment).max() < 1.0  # N m: places are stored to a micrometre
    assert np.abs(track_imbalance(dragged).force).max() < 0.1


@pytest.mark.parametrize(
    ("case", "duration", "mean"),
    [
        (three_shoes(SAND, drive=JERK), 0.3, 1.1),
        pytest.param(longer(16).on_cells(SAND), 4.0, 1.3, marks=pytest.mark.slow),
    ],
    ids=["jerked", "16 shoes in the papers' drive"],
)
def test_newton_takes_one_or_two_iterations_on_sand(case, duration, mean, monkeypatch):
    """Of 2000 steps of 16 shoes 474 take two."""
    iterations, step = [], CompiledSystem.step

    def counted(self, *arguments):
        iterations.append(step(self, *arguments))
        return iterations[-1]

    monkeypatch.setattr(CompiledSystem, "step", counted)
    steps = simulate(case, duration, False).time.size - 1
    converged, made = np.array(iterations[-steps:]).T
    assert len(made) == steps > 100
    assert converged.all()
    assert made.mean() < mean
    assert made.max() <= 2


def test_a_dragged_track_is_held_back_by_the_strength_of_the_soil(dragged):
    # slipped by five shear deformations, all of it: c and tan(phi) of the normal force
    law = dragged.case.contact.law
    area = dragged.area.isel(time=-1).sum().item()
    normal = dragged.normal_force.isel(time=-1, axis=2).sum().item()
    strength = law.cohesion * area + np.tan(np.radians(law.friction_angle)) * normal
    assert 0.9 * strength < dragged.drive_force.values[-1] < 1.05 * strength


def stress_by_region(case):
    """Highest von Mises stress (Pa) of shoe 2 at rest by region, and the run."""
    run = simulate(case, 4e-3, False)
    table = recover_stresses(run, [0.0], peak=False).by_region[2]
    return table.set_index("region")["value"], run


@pytest.mark.slow
def test_a_stone_under_a_corner_tilts_a_dragged_shoe_and_bends_it():
    base = Case.stress("coarse")
    case = three_shoes(ROCK, base=base)
    x, y = case.gear.shoe_reference(case)[1, :2] + (0.0, 0.5 * case.shoe.width - 0.3)
    stone = Heights(parts=(Stone(x=x, y=y, height=0.08, width=0.2, flank=0.2),))
    level, _ = stress_by_region(case)
    lifted, run = stress_by_region(three_shoes(ROCK, stone, base))
    assert np.abs(run.acceleration.isel(time=0)).max() < 3e-3  # m/s2
    assert 0.02 < float(np.abs(run.angles.isel(time=0)).max()) < 0.08 / case.shoe.width
    for region in ("wings", "lugs"):
        assert lifted[region] > 4.0 * level[region]


PARTS = [
    Ridge(x=12.0, height=0.1, width=0.2, flank=0.3),
    Ramp(x=14.0, height=0.1, flank=0.3),
    Stone(x=13.0, y=10.7, height=0.08, width=0.2, flank=0.2),
]


@pytest.mark.parametrize("part", PARTS, ids=["ridge", "ramp", "stone"])
@BOTH_LAWS
def test_a_dragged_track_finds_its_rest_on_uneven_ground(law, part):
    case = Case.translation().on_cells(law, Heights(parts=(part,))).with_(drive=FREE)
    start = simulate(case, 4e-3, False)
    carried = (start.normal_force + start.friction_force).isel(time=0).sum("contact").values
    assert carried[2] == pytest.approx(weight(case), rel=1e-3)
    assert np.abs(carried[:2]).max() < 1e-3 * weight(case)
    assert np.abs(start.acceleration.isel(time=0)).max() < 0.01  # m/s2
    assert float(np.abs(start.angles.isel(time=0)).max()) > 0.005


@pytest.mark.parametrize("grade", [0.0, 0.1])
@BOTH_LAWS
def test_shoes_on_a_slope_below_friction_stay_where_they_are(law, grade):
    case = three_shoes(law, grade=grade, side_slope=0.1)
    run = simulate(case, 2.0, False)
    ground = (run.normal_force + run.friction_force).sum("contact").values
    assert ground[-1] == pytest.approx(-weight(case) * case.terrain.down, abs=1e-5 * weight(case))
    moved = run.position - run.position.isel(time=0)
    assert np.abs(moved).max() < 1e-4  # m


@pytest.mark.parametrize(
    "base",
    [Case.translation(), pytest.param(Case.stress("coarse"), marks=pytest.mark.slow)],
    ids=["rigid", "flexible"],
)
def test_newtons_matrix_is_the_derivative_of_the_residual(base):
    system = compiled_system(base.on_cells(SAND))
    q = static_equilibrium(system.case)
    settle(system, q)
    # deeper than ever before and slipping, away from the kinks of the law
    shoes = q[: 6 * system.layout.shoes].reshape(-1, 6)
    shoes[:, 2] -= 2e-3
    shoes[:, 0] += 3e-3
    assert matrix_errors(system, q, np.zeros(len(q)), by_acceleration=0.0).max() < 0.02


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(three_shoes(ROCK.with_(friction=0.05), side_slope=0.1), marks=pytest.mark.slow),
        three_shoes(SAND.with_(cohesion=0.0, friction_angle=0.0)),
    ],
    ids=["rock that is too steep", "sand without strength"],
)
def test_ground_that_cannot_hold_the_shoes_is_named(case):
    with pytest.raises(EquilibriumError, match="the ground's shear may be too weak to hold the shoes: comp"):
        static_equilibrium(case)


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_floor_without_friction_is_refused_and_one_with_next_to_none_carries():
    with pytest.raises(ParameterError, match=r"^friction: must be greater than 0, got 0\.0$"):
        ROCK.with_(friction=0.0)
    case = three_shoes(ROCK.with_(friction=1e-6))
    start = simulate(case, 4e-3, False)
    assert np.abs(start.acceleration.isel(time=0)).max() < 1e-3  # m/s2


@pytest.mark.slow
def test_modal_loads_of_histories_are_those_of_the_equations():
    case = Case.stress("coarse").on_cells(SAND)
    run = simulate(case, 4e-3, False)
    loads, units = loads_by_kind(run, 13), unit_loads(case)
    inertia = loads[Kind.INERTIA][[0]].toarray()[0, units.families[INERTIA]]
    ground = (loads[Kind.CONTACT][[0]] @ units.work @ units.integrated.inside)[0]
    # at rest the modes have neither momentum nor damping: their loads are their elastic forces, but for
    # forces at nodes that are stored in single precision
    assert np.abs(inertia).max() < 3e-5 * np.abs(ground).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    "relief", [Heights(), Heights(roughness=Roughness(spectrum=64e-6, seed=3))], ids=["level", "rough"]
)
def test_peak_stress_does_not_feel_the_cells(relief):
    """Of a flexible shoe at rest; 0.1 % apart on level sand, 0.9 % on rough."""
    base, peaks = Case.stress("coarse"), []
    case = three_shoes(SAND, relief, base, drive=base.drive)
    for cell in (0.1, 0.05):
        run = simulate(case.with_({"terrain.cell": cell}), 4e-3, False)
        peaks.append(recover_stresses(run, [0.0], peak=False).hot_spots[2]["value"].iloc[0])
    assert peaks[0] > 5e6  # Pa
    assert peaks[1] == pytest.approx(peaks[0], rel=0.02)


def assert_alike(compiled, engine, allowed):
    """Variables are the same within these absolute differences, as long as Exudyn's run lasts."""
    for name, most in allowed.items():
        own = compiled.dataset[name].isel(time=slice(engine.time.size))
        np.testing.assert_allclose(engine.dataset[name], own, rtol=0.0, atol=most, err_msg=name)


def test_exudyns_bodies_move_alike_on_cells(dragged):
    run = simulate(dragged.case.with_(formulation="engine"), 0.1, False)
    allowed = {"position": 1e-9, "joint_force": 0.2, "normal_force": 0.2, "friction_force": 0.2}
    assert_alike(dragged, run, allowed)


@pytest.mark.slow
def test_exudyns_floating_frame_moves_alike_on_cells():
    case = three_shoes(SAND, base=Case.stress("coarse"), drive=JERK).with_({"solver.residual": 1e-3})
    compiled, engine = (simulate(case.with_(formulation=one), 0.05, False) for one in ("compiled", "engine"))
    allowed = {"position": 1e-9, "modal_coordinate": 1e-8, "joint_force": 0.2, "normal_force": 0.2}
    allowed |= {"friction_force": 0.2, "node_force": 0.2}
    assert_alike(compiled, engine, allowed)
    assert float(np.abs(compiled.modal_coordinate).max()) > 1e-4
