"""Second contact model: its law against the engine's, its agreement with the pair law, and bad input."""

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.case import Terrain
from exudyn_crawler.case.parameters.contact import SphereContact as Spheres
from exudyn_crawler.errors import EquilibriumError, SimulationStopped
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.ground.coordinates import ConstrainedCoordinates
from exudyn_crawler.ground.triplets import Weights
from exudyn_crawler.model.system import build
from exudyn_crawler.results.loads.balance import powers, shoe_imbalance, track_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.integration import integrate
from studies.comparison import compare_kinematics
from studies.force_comparison import compare_forces
from studies.forces import study as forces_study
from studies.grounds import uneven_case

pytestmark = pytest.mark.simulation

SPHERES = Spheres.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)
TURNING = Case.turning().with_(contact=SPHERES)
DRAWN_BACK = CASE.with_(contact=SPHERES.with_(faces="drawn_back"))
CASES = {"straight": CASE, "turning": TURNING, "drawn back": DRAWN_BACK, "step": uneven_case("step")}
WEIGHT = CASE.track.shoe_count * CASE.mean_load
SHOE_COORDINATES = 6 * CASE.track.shoe_count


def contact_of(case: Case):
    """Contact of a case without a system round it."""
    return ground_contact(case, ConstrainedCoordinates(case.terrain.unit_count, case.terrain.tilt_axis))


@pytest.fixture(scope="module")
def general() -> History:
    return simulate(CASE, 0.4)


@pytest.fixture(scope="module")
def rest() -> np.ndarray:
    return static_equilibrium(CASE)


def test_track_rests_before_the_run(general):
    start = general.dataset.isel(time=0)
    for name in ("acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        assert float(abs(start[name]).max()) < 1e-3
    carried = float((start.normal_force + start.friction_force).sel(axis="z").sum())
    assert carried == pytest.approx(WEIGHT, rel=1e-9)


def test_shoes_settle_as_deep_as_by_the_pair_law(general, translation):
    ours, theirs = (history.contacts_by_shoe().isel(time=0) for history in (general, translation))
    # not the shoe over the seam of two units, of which the pair law makes two contacts, nor its neighbours
    alone = [1, 2, 3, 4, 9, 10, 11, 12, 13]
    ratio = (ours.penetration / theirs.penetration).sel(shoe=alone).values
    # links bend the load from shoe to shoe by some per cent, which a linear and a quadratic spring tell apart
    assert ratio == pytest.approx(1.0, abs=0.04)
    assert ratio.mean() == pytest.approx(1.0, abs=0.005)
    heave = general.unit_heave.isel(time=0) / translation.unit_heave.isel(time=0)
    assert heave.sel(unit=[7, 12]).values == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_law_repeats_the_engines_forces(case):
    system = build(case)
    system.set_initial(static_equilibrium(case))
    # full friction is not reached yet: within a step the engine keeps its branch of the law
    integrate(system, 0.06)
    data = system.mbs.systemData
    state = [np.array(values) for values in (data.GetODE2Coordinates(), data.GetODE2Coordinates_t())]
    assert system.general is not None
    engine = np.asarray(system.general.GetSystemODE2RhsContactForces(copy=True))
    law = system.contact.forces(*state)
    assert np.abs(law[:SHOE_COORDINATES]).max() > 4e5
    assert engine == pytest.approx(law, abs=1e-9 * WEIGHT)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("factors", [(1.0, 0.0), (0.0, 1.0)], ids=["position", "velocity"])
def test_derivatives_are_those_of_the_forces(case, factors):
    contact = contact_of(case)
    q = static_equilibrium(case)
    random = np.random.default_rng(3)
    q[:SHOE_COORDINATES] += random.normal(0.0, 1e-3, SHOE_COORDINATES)
    q_t = np.zeros_like(q)
    if factors[1]:  # some spheres beyond the slip of full friction, some not
        q_t[:SHOE_COORDINATES] = random.normal(0.0, 0.01, SHOE_COORDINATES)
    position, velocity = factors
    triplets = contact.derivatives(q, q_t, Weights(position, velocity))
    matrix = np.zeros((q.size, q.size))
    np.add.at(matrix, tuple(triplets[:, :2].T.astype(int)), triplets[:, 2])
    units = np.arange(SHOE_COORDINATES, q.size).reshape(-1, 6)
    ours = np.concatenate((np.arange(SHOE_COORDINATES), units[:, 2], units[:, 4]))
    change = np.zeros_like(q)
    change[ours] = 1e-7 * random.normal(size=len(ours))
    ahead, behind = (contact.forces(q + s * position * change, q_t + s * velocity * change) for s in (1, -1))
    numerical = 0.5 * (ahead - behind)
    # central differences of forces of 4e5 N and stiffnesses of 7e6 N/m
    assert (matrix @ change)[ours] == pytest.approx(numerical[ours], abs=1e-5 * np.abs(numerical).max())


@pytest.mark.parametrize("case", [CASE, TURNING], ids=["straight", "turning"])
def test_contact_forces_close_every_shoes_balance(case):
    history = simulate(case, 0.5)
    # far into full friction, where forces by the law alone miss the engine's at every change of branch
    assert float(abs(history.slip_velocity).max()) > 0.002
    # Newton's method ends at a mean residual of 0.2 N
    assert float(abs(shoe_imbalance(history).force).max()) < 1e-6 * WEIGHT
    assert float(abs(shoe_imbalance(history).moment).max()) < 1e-6 * WEIGHT
    assert float(abs(track_imbalance(history).force).max()) < 1e-5 * WEIGHT


def test_results_of_a_pair_are_sums_over_its_spheres(rest):
    contact = contact_of(CASE)
    results = contact.results(rest, np.zeros_like(rest))
    generalized = contact.forces(rest, np.zeros_like(rest))[:SHOE_COORDINATES].reshape(-1, 6)
    carried = np.bincount(results[:, 0].astype(int), results[:, 10], CASE.track.shoe_count)
    assert carried == pytest.approx(generalized[:, 2], rel=1e-12)
    whole = results[results[:, 0] == 2.0]
    assert whole[0, 4] == pytest.approx(CASE.shoe.length * CASE.shoe.width)


def test_history_saves_and_loads(general, tmp_path):
    general.save(tmp_path / "general.nc")
    again = History.load(tmp_path / "general.nc")
    assert again.case == general.case
    np.testing.assert_array_equal(again.normal_force, general.normal_force)


def test_powers_are_refused(general):
    with pytest.raises(ValueError, match=r"contact\.model 'pair'"):
        powers(general)


def small_spheres(radius: float) -> Case:
    return CASE.with_(contact=SPHERES.with_(radius=radius))


def test_spheres_without_rest_are_named():
    with pytest.raises(EquilibriumError, match=r"radius of 0\.07 m may be too small for a .* of 0\.06575 m"):
        static_equilibrium(small_spheres(0.07))


def test_spheres_that_sink_through_stop_the_run():
    """They stand at rest; the pull of the drive presses shoe 12 deeper until its spheres lose the ground."""
    with pytest.raises(SimulationStopped, match=r"spheres of shoes \[12\] sank through the ground") as stop:
        simulate(small_spheres(0.08), 2.0)
    kept = stop.value.history
    assert 0.5 < kept.duration < 2.0
    assert float(kept.position.sel(axis="z").min()) > 0.0


def test_centres_below_a_face_are_found(rest):
    contact = contact_of(CASE)
    assert contact.sunken(rest) == []
    lower = rest.copy()
    height = SPHERES.radius - CASE.settled_penetration
    lower[6 * 3 + 2] -= 0.9 * height
    assert contact.sunken(lower) == []
    lower[6 * 3 + 2] -= 0.2 * height
    assert contact.sunken(lower) == [4]


def test_terrain_needs_no_other_formulation():
    """The engine takes the units as bodies whatever the case says of the terrain's formulation."""
    assert CASE.terrain_formulation == "reduced"
    assert isinstance(CASE.terrain, Terrain)
    assert build(CASE).contact.size == 6 * (CASE.track.shoe_count + CASE.terrain.unit_count)


def test_forces_study_refuses_histories_of_the_other_model(general, tmp_path):
    (tmp_path / "translation").mkdir()
    path = general.save(tmp_path / "translation" / "history.nc")
    before = path.read_bytes()
    out = tmp_path / "forces"
    with pytest.raises(ValueError, match=r"other parameters: contact\.model is spheres, not pair"):
        forces_study(out, ["translation"], duration=general.duration, reuse=tmp_path)
    assert path.read_bytes() == before
    assert not out.exists()


def statics(case: Case, duration: float) -> pd.Series:
    """Computed `statics` rows of both studies by quantity and statistic, those that the duration allows."""
    histories = {"translation": simulate(case, duration, progress=False)}
    table = pd.concat((compare_kinematics(histories), compare_forces(histories)))
    chosen = table[(table["class"] == "statics") & (table["case"] == "translation")]
    return chosen.set_index(["quantity", "statistic"])["computed"].dropna()


def test_settled_statics_agree_with_the_pair_law():
    """Rows that need no slip, in a short run; before the track slips both laws' friction differs."""
    ratios = statics(CASE, 0.2) / statics(Case.translation(), 0.2)
    rows = [
        ("penetration depth of a shoe", "mean greatest"),
        ("shoe 10 penetration depth", "mean"),
        ("normal force z", "mean greatest of shoes"),
        ("shoe 10 normal force z", "mean"),
        ("contact force z", "mean greatest of shoes"),
    ]
    assert ratios.loc[rows].to_numpy() == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
def test_statics_agree_with_the_pair_law():
    """Ten seconds straight: every `statics` row of both studies within 5 % of the pair model."""
    ratios = statics(CASE, 10.0) / statics(Case.translation(), 10.0)
    assert len(ratios) == 12
    for name, ratio in ratios.items():
        assert ratio == pytest.approx(1.0, abs=0.05), name
