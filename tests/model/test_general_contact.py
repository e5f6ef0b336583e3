"""Second contact model: its balance, its agreement with the pair law, and bad input."""

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.case.parameters.contact import SphereContact as Spheres
from exudyn_crawler.case.statics import mean_load, settled_penetration
from exudyn_crawler.engine.rest import RESIDUAL
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import EquilibriumError, SimulationStopped
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.results.balance import powers, shoe_imbalance, track_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from studies.comparison import compare_kinematics
from studies.forces import compare_forces, study as forces_study
from studies.grounds import plain
from tests.model.both import sphere_wrenches

pytestmark = pytest.mark.simulation

SPHERES = Spheres.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)
TURNING = Case.turning().with_(contact=SPHERES)
EVEN = plain(CASE).with_(contact=SPHERES)
WEIGHT = CASE.track.shoe_count * mean_load(CASE)


@pytest.fixture(scope="module")
def general() -> History:
    return simulate(CASE, 0.5)


@pytest.fixture(scope="module")
def rest() -> np.ndarray:
    return static_equilibrium(EVEN)


def test_track_rests_before_the_run():
    """On units that pitch: those that roll push aside at first, as `tests.run.test_equilibrium` shows."""
    start = simulate(EVEN, 0.01).dataset.isel(time=0)
    for name in ("acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        assert float(abs(start[name]).max()) < 1e-3
    carried = float((start.normal_force + start.friction_force).sel(axis="z").sum())
    coordinates = 6 * (CASE.track.shoe_count + CASE.terrain.unit_count)
    assert carried == pytest.approx(WEIGHT, abs=coordinates * RESIDUAL)


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


@pytest.mark.parametrize("is_turning", [False, True], ids=["straight", "turning"])
def test_contact_forces_close_every_shoes_balance(is_turning, general):
    history = simulate(TURNING, 0.5) if is_turning else general
    # far into full friction, where forces by the law alone miss the engine's at every change of branch
    assert float(abs(history.slip_velocity).max()) > 0.002
    # Newton's method ends at a mean residual of 0.2 N
    assert float(abs(shoe_imbalance(history).force).max()) < 1e-6 * WEIGHT
    assert float(abs(shoe_imbalance(history).moment).max()) < 1e-6 * WEIGHT
    assert float(abs(track_imbalance(history).force).max()) < 1e-5 * WEIGHT


def test_a_contact_is_what_the_spheres_of_a_shoe_do_together(rest):
    wrenches = sphere_wrenches(EVEN, rest)
    results, _ = ground_contact(EVEN).results(rest[None], np.zeros_like(rest)[None], wrenches[None])
    shoe, point = results[:, RESULT["shoe"]].astype(int), results[:, RESULT["point"]]
    force = results[:, RESULT["normal_force"]] + results[:, RESULT["friction_force"]]
    assert shoe.tolist() == list(range(CASE.track.shoe_count))
    assert force == pytest.approx(wrenches[:, :3], rel=1e-12)
    coms = CASE.track.com_positions(CASE.shoe.com_height) + rest[: 6 * len(shoe)].reshape(-1, 6)[:, :3]
    moment = results[:, RESULT["friction_torque"]] + np.cross(point - coms, force)
    assert moment == pytest.approx(wrenches[:, 3:], abs=1e-9 * WEIGHT)
    # the point of a contact, which is moved onto the face, takes up the moment
    assert np.abs(results[:, RESULT["friction_torque"]]).max() < 1e-3 * np.abs(wrenches[:, 3:]).max()
    assert results[2, RESULT["area"]] == pytest.approx(EVEN.shoe.length * EVEN.shoe.width)


def test_powers_are_refused(general):
    with pytest.raises(ValueError, match=r"contact\.model 'pair'"):
        powers(general)


@pytest.mark.slow
def test_spheres_without_rest_are_named():
    with pytest.raises(EquilibriumError, match=r"radius of 0\.07 m may be too small for a .* of 0\.06575 m"):
        static_equilibrium(CASE.with_({"contact.radius": 0.07}))


@pytest.mark.slow
def test_spheres_that_sink_through_stop_the_run():
    """They stand at rest; the pull of the drive presses shoe 12 deeper until its spheres lose the ground."""
    with pytest.raises(SimulationStopped, match=r"spheres of shoes \[12\] sank through the ground") as stop:
        simulate(CASE.with_({"contact.radius": 0.08}), 2.0)
    kept = stop.value.history
    assert 0.5 < kept.duration < 2.0
    assert float(kept.position.sel(axis="z").min()) > 0.0


def test_centres_below_a_face_are_found(rest):
    contact = ground_contact(EVEN)
    assert contact.sunken(rest) == []
    lower = rest.copy()
    height = SPHERES.radius - settled_penetration(CASE)
    lower[6 * 3 + 2] -= 0.9 * height
    assert contact.sunken(lower) == []
    lower[6 * 3 + 2] -= 0.2 * height
    assert contact.sunken(lower) == [4]


def test_terrain_needs_no_other_formulation():
    """The engine takes the units as bodies whatever the case says of the terrain's formulation."""
    assert CASE.terrain_formulation == "reduced"
    assert ExudynSystem(CASE).contact.size == 6 * (CASE.track.shoe_count + CASE.terrain.unit_count)


def test_forces_study_refuses_histories_of_the_other_model_which_are_saved_as_they_were(general, tmp_path):
    (tmp_path / "translation").mkdir()
    path = general.save(tmp_path / "translation" / "history.nc")
    before = path.read_bytes()
    out = tmp_path / "forces"
    with pytest.raises(ValueError, match=r"another case: contact\.model is spheres, not pair"):
        forces_study(out, ["translation"], duration=general.duration, reuse=tmp_path)
    assert path.read_bytes() == before
    again = History.load(path)
    assert again.case == general.case
    np.testing.assert_array_equal(again.normal_force, general.normal_force)
    assert not out.exists()


def statics(case: Case, duration: float) -> pd.Series:
    """Computed `statics` rows of both studies by quantity and statistic, those that the duration allows."""
    histories = {"translation": simulate(case, duration, progress=False)}
    table = pd.concat((compare_kinematics(histories), compare_forces(histories)))
    chosen = table[(table["class"] == "statics") & (table["case"] == "translation")]
    return chosen.set_index(["quantity", "statistic"])["computed"].dropna()


SETTLED = [
    ("penetration depth of a shoe", "mean greatest"),
    ("shoe 10 penetration depth", "mean"),
    ("normal force z", "mean greatest of shoes"),
    ("shoe 10 normal force z", "mean"),
    ("contact force z", "mean greatest of shoes"),
]
"""Rows that need no slip; before the track slips both laws' friction differs."""


@pytest.mark.parametrize(
    ("duration", "rows"), [(0.2, SETTLED), pytest.param(10.0, None, marks=pytest.mark.slow)]
)
def test_statics_agree_with_the_pair_law(duration, rows):
    """In ten seconds straight every `statics` row of both studies is within 5 % of the pair model."""
    ratios = statics(EVEN, duration) / statics(plain(CASE), duration)
    chosen = ratios if rows is None else ratios.loc[rows]
    assert len(chosen) == (12 if rows is None else 5)
    assert chosen.to_numpy() == pytest.approx(1.0, abs=0.05)
