"""Second contact model: its law against the engine's, its agreement with the pair law, and bad input."""

import math

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from exudyn_crawler import Case, CrawlerModel, History
from exudyn_crawler.balance import powers, shoe_imbalance, track_imbalance
from exudyn_crawler.comparison import compare_kinematics
from exudyn_crawler.contact_forces import contacts_by_shoe
from exudyn_crawler.engine import build
from exudyn_crawler.force_comparison import compare_forces
from exudyn_crawler.general_contact import SphereContact, seam, sphere_places
from exudyn_crawler.parameters import FlexibleShoes, GeneralContact, Terrain
from exudyn_crawler.simulation import integrate
from exudyn_crawler.workflows.uneven_ground import uneven_case

CASE = Case.translation().with_(contact_model="general")
TURNING = Case.turning().with_(contact_model="general")
WEIGHT = CASE.track.shoe_count * CASE.mean_load
SHOE_COORDINATES = 6 * CASE.track.shoe_count


@pytest.fixture(scope="module")
def general() -> History:
    return CrawlerModel(CASE).simulate(0.4)


@pytest.fixture(scope="module")
def rest() -> np.ndarray:
    return CrawlerModel(CASE).equilibrium()


def test_spheres_carry_the_mean_load_at_the_pair_laws_depth():
    depth = math.sqrt(432.3e3 / 1e8)  # papers: 6.57 cm
    assert CASE.settled_penetration == pytest.approx(depth, rel=1e-3)
    spheres = CASE.general_contact.spheres_x * CASE.general_contact.spheres_y
    assert spheres * CASE.sphere_stiffness * CASE.settled_penetration == pytest.approx(
        CASE.mean_load, rel=1e-12
    )


def test_spheres_stand_evenly_inside_the_underside():
    places = sphere_places(CASE)
    low_x, high_x, low_y, high_y, z = CASE.shoe.footprint
    assert len(places) == 20
    assert places.mean(axis=0)[:2] == pytest.approx(
        [0.5 * (low_x + high_x), 0.5 * (low_y + high_y)], abs=1e-12
    )
    assert places[:, 0].min() - low_x == pytest.approx(0.63 / 8.0, rel=1e-12)
    assert places[:, 1].max() - high_y == pytest.approx(-3.505 / 10.0, rel=1e-12)
    assert places[:, 2] == pytest.approx(z + CASE.general_contact.radius)


def test_two_faces_push_over_the_seam_as_hard_as_one():
    radius, depth = CASE.general_contact.radius, CASE.settled_penetration
    height = radius - depth
    slant = math.hypot(seam(CASE)[0], height)
    assert 2.0 * (radius - slant) * height / slant == pytest.approx(depth, rel=1e-12)


def test_track_rests_before_the_run(general):
    start = general.dataset.isel(time=0)
    for name in ("acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        assert float(abs(start[name]).max()) < 1e-3
    carried = float((start.normal_force + start.friction_force).sel(axis="z").sum())
    assert carried == pytest.approx(WEIGHT, rel=1e-9)


def test_shoes_settle_as_deep_as_by_the_pair_law(general, translation):
    ours, theirs = (contacts_by_shoe(history).isel(time=0) for history in (general, translation))
    # not the shoe over the seam of two units, of which the pair law makes two contacts, nor its neighbours
    alone = [1, 2, 3, 4, 9, 10, 11, 12, 13]
    ratio = (ours.penetration / theirs.penetration).sel(shoe=alone).values
    # links bend the load from shoe to shoe by some per cent, which a linear and a quadratic spring tell apart
    assert ratio == pytest.approx(1.0, abs=0.04)
    assert ratio.mean() == pytest.approx(1.0, abs=0.005)
    heave = general.unit_heave.isel(time=0) / translation.unit_heave.isel(time=0)
    assert heave.sel(unit=[7, 12]).values == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("case", [CASE, TURNING, uneven_case("step")], ids=["straight", "turning", "step"])
def test_law_repeats_the_engines_forces(case):
    system = build(case)
    system.set_initial(CrawlerModel(case).equilibrium())
    # full friction is not reached yet: within a step the engine keeps its branch of the law
    integrate(system, 0.06)
    data = system.mbs.systemData
    state = [np.array(values) for values in (data.GetODE2Coordinates(), data.GetODE2Coordinates_t())]
    assert system.general is not None
    engine = np.asarray(system.general.GetSystemODE2RhsContactForces(copy=True))
    law = system.contact.forces(*state)
    assert np.abs(law[:SHOE_COORDINATES]).max() > 4e5
    assert engine == pytest.approx(law, abs=1e-9 * WEIGHT)


@pytest.mark.parametrize("case", [CASE, TURNING, uneven_case("step")], ids=["straight", "turning", "step"])
@pytest.mark.parametrize("factors", [(1.0, 0.0), (0.0, 1.0)], ids=["position", "velocity"])
def test_derivatives_are_those_of_the_forces(case, factors):
    contact = SphereContact(case)
    q = CrawlerModel(case).equilibrium()
    random = np.random.default_rng(3)
    q[:SHOE_COORDINATES] += random.normal(0.0, 1e-3, SHOE_COORDINATES)
    q_t = np.zeros_like(q)
    if factors[1]:  # some spheres beyond the slip of full friction, some not
        q_t[:SHOE_COORDINATES] = random.normal(0.0, 0.01, SHOE_COORDINATES)
    position, velocity = factors
    triplets = contact.derivatives(q, q_t, position, velocity)
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
    history = CrawlerModel(case).simulate(0.5)
    # far into full friction, where forces by the law alone miss the engine's at every change of branch
    assert float(abs(history.slip_velocity).max()) > 0.002
    # Newton's method ends at a mean residual of 0.2 N
    assert float(abs(shoe_imbalance(history).force).max()) < 1e-6 * WEIGHT
    assert float(abs(shoe_imbalance(history).moment).max()) < 1e-6 * WEIGHT
    assert float(abs(track_imbalance(history).force).max()) < 1e-5 * WEIGHT


def test_results_of_a_pair_are_sums_over_its_spheres(rest):
    contact = SphereContact(CASE)
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
    with pytest.raises(ValueError, match="contact_model 'pair'"):
        powers(general)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spheres_x": 1}, "spheres_x"),
        ({"spheres_y": 0}, "spheres_y"),
        ({"radius": -0.1}, "radius"),
        ({"damping": -1.0}, "damping"),
        ({"friction": -0.1}, "friction"),
        ({"friction_speed": 0.0}, "friction_speed"),
        ({"radius": math.inf}, "radius"),
    ],
)
def test_bad_spheres_are_refused(changes, message):
    with pytest.raises(ValidationError, match=message):
        GeneralContact.oil_sand().with_(**changes)


def test_spheres_that_would_sink_through_are_refused():
    spheres = GeneralContact.oil_sand().with_(radius=0.06)
    with pytest.raises(
        ValidationError, match=r"radius must exceed the settled penetration .* 0\.0657.* m, got 0\.06"
    ):
        CASE.with_(general_contact=spheres)
    Case.translation().with_(general_contact=spheres)  # the pair law has no spheres


def test_spheres_too_large_for_the_units_are_refused():
    with pytest.raises(ValidationError, match=r"quarter of a unit's side, 1\.75 m, got 2"):
        CASE.with_(general_contact=GeneralContact.oil_sand().with_(radius=2.0))


def test_flexible_shoes_are_refused():
    with pytest.raises(ValidationError, match="flexible must be None with contact_model 'general'"):
        CASE.with_(flexible=FlexibleShoes.ph4100c("coarse"))


def test_unknown_model_is_refused():
    with pytest.raises(ValidationError, match="contact_model"):
        CASE.with_(contact_model="hertz")


def test_terrain_needs_no_other_formulation():
    """The engine takes the units as bodies whatever the case says of the terrain's formulation."""
    assert CASE.terrain_formulation == "reduced"
    assert isinstance(CASE.terrain, Terrain)
    assert build(CASE).contact.size == 6 * (CASE.track.shoe_count + CASE.terrain.unit_count)


@pytest.mark.slow
def test_statics_agree_with_the_pair_law():
    """Ten seconds straight: every `statics` row of both studies within 5 % of the pair model."""
    computed = []
    for case in (Case.translation(), CASE):
        histories = {"translation": CrawlerModel(case).simulate(10.0, progress=False)}
        table = pd.concat((compare_kinematics(histories), compare_forces(histories)))
        chosen = table[(table["class"] == "statics") & (table["case"] == "translation")]
        computed.append(chosen.set_index(["quantity", "statistic"])["computed"])
    ratios = computed[1] / computed[0]
    assert len(ratios) == 12
    for name, ratio in ratios.items():
        # the least mean penetration is that of the shoe over two units, whose load the pair law gives to two
        # contacts, each with the stiffness of a whole shoe: together they sink less than one
        allowed = 0.08 if name == ("penetration depth of a shoe", "mean least") else 0.05
        assert ratio == pytest.approx(1.0, abs=allowed), name
