"""Values drawn from distributions against scipy, quantiles and their bounds, drawn lives, fleets."""

import dataclasses
import hashlib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import meshes
from exudyn_crawler import Case, CaseFile, Duty, FatigueMaterial, life, life_run
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.results.life.duty import DutyCase
from exudyn_crawler.sweep.answers import Life
from exudyn_crawler.sweep.definition import Fleet, Sweep, read_sweep
from exudyn_crawler.sweep.page import write_page
from exudyn_crawler.sweep.results import PORTIONS, failures, quantiles, scatter_tables, sensitivities
from exudyn_crawler.sweep.running import run_sweep
from exudyn_crawler.sweep.scatter import _with_all_cases, read_scatter
from exudyn_crawler.sweep.vary import Vary
from fem import Shapes
from meshes.shoe import STEEL, joint_interfaces
from tests.small_shoe import SMALL_SHOE
from tests.sweep.cases import DAMPING, FORCE, STIFFNESS, answered, small_sweep

NICRMO = FatigueMaterial.cast_nicrmo()
LIFE = Life(name="life", survival=0.5, material=NICRMO)
CASTING = "life.material.casting_factor"


def sample(count: int, **changes) -> Sweep:
    vary = (Vary(key=STIFFNESS, low=1e7, high=4e7, scale="log", distribution="normal"),)
    return small_sweep(**{"vary": vary, "design": "latin_hypercube", "runs": count} | changes)


@pytest.mark.parametrize("within", [0.8, 0.9, 0.99])
def test_drawn_values_have_scipys_quantiles(within):
    tail = 0.5 * (1.0 - within)
    portions = np.array([0.001, tail, 0.3, 0.5, 1.0 - tail, 0.999])

    def drawn(**given) -> np.ndarray:
        one = Vary(key=STIFFNESS, low=2.0, high=8.0, within=within, **given)
        values = np.array([one.at(u) for u in portions])
        np.testing.assert_allclose(values[[1, 4]], [2.0, 8.0], rtol=1e-12)
        return values

    score = stats.norm.ppf(1.0 - tail)
    np.testing.assert_allclose(drawn(distribution="normal"), stats.norm(5.0, 3.0 / score).ppf(portions))
    logarithmic = stats.lognorm(np.log(2.0) / score, scale=4.0)
    np.testing.assert_allclose(drawn(distribution="normal", scale="log"), logarithmic.ppf(portions))
    weibull = drawn(distribution="weibull")
    ends = np.log(-np.log1p(-np.array([tail, 1.0 - tail])))
    shape = (ends[1] - ends[0]) / np.log(4.0)
    scale = 2.0 / np.exp(ends[0] / shape)
    np.testing.assert_allclose(weibull, stats.weibull_min(shape, scale=scale).ppf(portions))


def test_a_drawn_run_keeps_its_values_and_the_same_seed_draws_the_same():
    sweep, again = sample(20), sample(20)
    assert sweep.rows == again.rows
    values = np.sort([row[0] for row in sweep.rows])
    # one value in each of 20 parts of equal probability
    distribution = stats.lognorm(np.log(2.0) / stats.norm.ppf(0.95), scale=2e7)
    np.testing.assert_array_equal(np.floor(20.0 * distribution.cdf(values)), np.arange(20))


def quantiles_of(sweep: Sweep, values: np.ndarray) -> pd.DataFrame:
    """Quantiles of answers, without the time that outcomes take."""
    table = pd.DataFrame({"run": np.arange(len(values)), "status": "done", FORCE.label: values})
    table.attrs = {"units": sweep.units()}
    return quantiles(sweep, table)


def test_bounds_of_quantiles_hold_as_often_as_they_say():
    random = np.random.default_rng(7)
    sweep, truth = sample(60), stats.weibull_min(1.5)
    held, known = np.zeros((2, len(PORTIONS)))
    exact = truth.ppf(PORTIONS)
    for _ in range(100):
        found = quantiles_of(sweep, truth.rvs(60, random_state=random))
        both = found[["least", "most"]].notna().all(axis=1).to_numpy()
        known += both
        held += both & (found["least"] <= exact).to_numpy() & (exact <= found["most"]).to_numpy()
    middle = known == 100
    assert middle.sum() >= 3
    assert (held[middle] >= 93).all()


@pytest.mark.parametrize("count", [60, 200])
def test_quantiles_and_bounds_are_scipys(count):
    """Linear between order statistics; bounds at the ranks of binomial quantiles, known or not."""
    values = stats.lognorm(0.8).rvs(count, random_state=np.random.default_rng(count))
    found = quantiles_of(sample(count), values).set_index("portion below")
    np.testing.assert_allclose(found["value"], stats.mstats.mquantiles(values, PORTIONS, alphap=1, betap=1))
    ranked = np.sort(values)
    for portion, row in found.iterrows():
        low = int(stats.binom.ppf(0.025, count, portion)) - 1
        high = int(stats.binom.ppf(0.975, count, portion))
        for bound, rank in ((row["least"], low), (row["most"], high)):
            known = 0 <= rank < count
            assert np.isnan(bound) != known
            if known:
                # ties of the binomial's tail may move a bound by a rank
                near = ranked[max(rank - 1, 0) : rank + 2]
                assert near[0] <= bound <= near[-1]


def test_fewer_runs_show_whether_a_quantile_has_settled():
    found = quantiles_of(sample(40), np.arange(40.0)).set_index("portion below").loc[0.5]
    assert (found["value"], found["of half"], found["of a quarter"]) == (19.5, 9.5, 4.5)
    assert found["runs"] == 40


def test_failed_runs_are_left_out_and_counted():
    sweep, values = sample(20), np.arange(20.0)
    values[3] = np.nan
    assert set(quantiles(sweep, answered(sweep, **{FORCE.label: values}))["runs"]) == {19}


def test_what_an_answer_depends_on_is_found():
    drawn = {"low": 1e4, "high": 4e4, "distribution": "normal"}
    sweep = sample(100, vary=(Vary(key=STIFFNESS, low=1e7, high=4e7), Vary(key=DAMPING, **drawn)))
    stiffness = np.array([row[0] for row in sweep.rows])
    found = sensitivities(sweep, answered(sweep, **{FORCE.label: -(stiffness**3)})).set_index("varied")
    assert found.loc["spring_stiffness", "rank correlation"] == pytest.approx(-1.0)
    assert found.loc["spring_stiffness", "p value"] < 1e-10
    assert abs(found.loc["spring_damping", "rank correlation"]) < 0.3
    assert found.loc["spring_damping", "p value"] > 1e-3


def flexible_sample(count: int, **changes) -> Sweep:
    given = {
        "case": CaseFile(case=Case.stress("coarse"), duration=0.1),
        "vary": (Vary(key=CASTING, low=1.2, high=1.4, distribution="normal"),),
        "answers": (LIFE, Life(name="path", region="roller path", survival=0.5, material=NICRMO)),
    }
    return sample(count, **given | changes)


def test_lives_are_drawn_for_all_answers_of_a_run():
    sweep = flexible_sample(4)
    for one in sweep.planned:
        assert [answer.material.casting_factor for answer in one.answers] == [one.values[0]] * 2
        assert [answer.region for answer in one.answers] == [None, "roller path"]
    assert len({one.digest for one in sweep.planned}) == 4
    assert sweep.units()["casting_factor"] == ""


def test_paths_and_values_of_a_life_that_cannot_be_are_refused_before_anything_runs():
    sweep = flexible_sample(20, vary=(Vary(key=CASTING, low=1.0, high=1.6, distribution="normal"),))
    with pytest.raises(ValueError, match=r"run 16 .*casting_factor: must be greater than or equal to 1"):
        sweep.table()
    with pytest.raises(ValueError, match="paths of life need an answer of model 'life'"):
        sample(20, vary=(Vary(key=CASTING, low=1.0, high=1.6),))
    with pytest.raises(ValueError, match=r"life\.material\.casting_factor"):
        flexible_sample(4, vary=(Vary(key=CASTING, values=(0.5, 1.0)),))


def test_shoes_of_a_fleet_crack_as_often_as_runs():
    sweep = flexible_sample(20, fleet=Fleet(shoes=100, hours_a_year=5000.0, rebuild=20_000.0))
    lives = np.full(20, 1e6)
    lives[:4] = [3000.0, 9000.0, 12_000.0, 19_000.0]
    found = failures(sweep, answered(sweep, life=lives, path=np.full(20, 1e9))).set_index(["answer", "hours"])
    year, whole = found.loc[("life", 5000.0)], found.loc[("life", 20_000.0)]
    assert (year["cracked"], whole["cracked"]) == ("1 of 20", "4 of 20")
    assert year["shoes a year"] == pytest.approx(100 * 0.05)
    # four of twenty in four years
    assert whole["shoes a year"] == pytest.approx(100 * 0.2 / 4)
    bounds = stats.beta.ppf([0.025, 0.975], [4, 5], [17, 16])
    np.testing.assert_allclose(whole[["least", "most"]].to_numpy(dtype=float), bounds)
    assert found.loc[("path", 20_000.0), "portion"] == 0.0


def test_runs_without_a_life_or_without_an_end_have_no_scatter_of_it():
    sweep = flexible_sample(20)
    lives = np.full(20, 1e6)
    table = answered(sweep, life=lives, path=lives)
    table["path"] = np.nan  # runs that finished and have no such life
    assert set(failures(sweep, table)["answer"]) == {"life"}
    assert set(quantiles(sweep, table)["answer"]) == {"life"}
    failed = answered(sweep, life=np.full(20, np.nan), path=lives)
    assert (failed["status"] == "failed").all()
    for scatter in (failures, quantiles, sensitivities):
        assert scatter(sweep, failed).empty


def test_a_sample_leaves_tables_and_a_part_of_the_page(tmp_path):
    sweep = sample(20)
    table = answered(sweep, **{FORCE.label: np.arange(20.0)})
    write_page(sweep, table, tmp_path, tmp_path / "runs", lambda _text: None)
    assert {"quantiles.csv", "sensitivities.csv", "failures.csv"} <= {one.name for one in tmp_path.iterdir()}
    assert "Rank correlations" in (tmp_path / "report.html").read_text()
    assert len(pd.read_csv(tmp_path / "quantiles.csv")) == len(PORTIONS)


def test_grids_and_few_runs_have_no_scatter():
    grid = small_sweep(vary=(Vary(key=STIFFNESS, low=1e7, high=2e7, count=12),))
    for sweep, runs in ((sample(4), 4.0), (grid, 12.0)):
        assert scatter_tables(sweep, answered(sweep, **{FORCE.label: np.arange(runs)})) == {}


def test_the_ready_sample_can_be_planned():
    sweep = read_sweep(Path(__file__).parents[2] / "studies" / "scatter.toml")
    assert len(sweep.planned) == 200
    stiffness = np.sort([row[0] for row in sweep.rows])
    # 90 % of the soils lie within what is known
    assert np.searchsorted(stiffness, [1.65e6, 5.45e6]).tolist() == [10, 190]


CASES = ("pass", "ends", "sand", "rock")


def hills(mesh, names) -> Shapes:
    """Shoe under check cases each of which pulls along x, most of all around a few places of its own."""
    random, stress = np.random.default_rng(3), np.zeros((len(mesh.nodes), 6, len(CASES)))
    for k in range(len(CASES)):
        for place in mesh.nodes[random.choice(mesh.surface_nodes, 6)]:
            away = np.linalg.norm(mesh.nodes - place, axis=1)
            stress[:, 0, k] += random.uniform(60e6, 200e6) * np.exp(-((away / 0.2) ** 2))
    modes = np.zeros((len(mesh.nodes), 3, len(names)))
    chosen = stress[..., [CASES.index(one) for one in names]]
    return Shapes(mesh, STEEL, tuple(joint_interfaces(mesh)), modes, chosen)


DUTY = """
survivals = [0.5, 0.975]
changes_an_hour = 0.5
material = { base = "cast_nicrmo", castings = [{ region = "web" }] }
stages = [{ name = "new", hours = 2000, check = "coarse" }, { name = "worn", hours = 500, check = "fine" }]
cases = [
    { name = "passes", case = "pass", after = "ends", an_hour = 10 },
    { name = "stones", case = "sand", an_hour = 2 },
]
"""
SCATTER = """
duty = "duty.toml"
runs = 12
vary = [
    { key = "survivals[0]", name = "strength", low = 0.01, high = 0.99 },
    { key = "material.castings[0].residual_stress", unit = "Pa", low = -50e6, high = 50e6 },
    { key = ["cases[0].an_hour", "cases[1].an_hour"], name = "often", factor = true, low = 0.5, high = 2.0, \
scale = "log", distribution = "normal" },
    { key = "cases[0].load", low = 0.8, high = 1.2 },
    { key = "cases[1].case", name = "ground", values = ["sand", "rock"] },
    { key = "stages[*].hours", name = "wear", factor = true, low = 0.7, high = 1.4 },
]
"""


@pytest.fixture
def drawn_duty(tmp_path, monkeypatch):
    (tmp_path / "duty.toml").write_text(DUTY)
    path = tmp_path / "scatter.toml"
    path.write_text(SCATTER)
    mesh = meshes.mesh_named(SMALL_SHOE)
    worn = dataclasses.replace(mesh, nodes=mesh.nodes + np.array([0.0, 0.0, 1e-4]))

    def shapes(check, names, _say):
        return hills(worn if check.mesh == "fine" else mesh, names)

    monkeypatch.setattr(life_run.solve, "case_shapes", shapes)
    return path


@pytest.mark.slow
def test_a_scatter_over_a_duty_leaves_what_a_sweep_leaves_with_the_lives_of_its_draws(drawn_duty, tmp_path):
    """Counted once for all draws of strength, residual stress, rates, loads, ground and wear.

    A life counts stresses within 1e-4 of the highest: a tenth as high, 0.5 % of its life.
    """
    scatter = read_scatter(drawn_duty)
    run = run_sweep(scatter, tmp_path / "out")
    assert {"results.csv", "results.nc", "quantiles.csv", "failures.csv", "sensitivities.csv"} <= {
        one.name for one in run.folder.iterdir()
    }
    assert run.table["status"].tolist() == ["done"] * 12
    assert set(failures(run.sweep, run.table)["answer"]) == {one.label for one in run.sweep.answers}
    page = (run.folder / "report.html").read_text()
    assert "duty duty, design latin_hypercube" in page
    assert "shoes a year" in page
    assert {one.cases[1].case for one in scatter.duties} == {"sand", "rock"}
    found = run.table.iloc[11]
    whole = life(scatter.duties[11])
    lives = pd.Series(whole.dataset.life.values[-1]).groupby(whole.regions).min().drop("bores")
    for region, hours in lives.items():
        assert found[f"life_{region}".replace(" ", "_")] == pytest.approx(hours, rel=0.01)
    assert found["life"] == pytest.approx(lives.min(), rel=1e-3)


@pytest.mark.slow
def test_a_drawn_defect_cracks_its_region_as_in_a_life(drawn_duty):
    text = drawn_duty.read_text().replace("residual_stress", "defect_size").replace('"Pa"', '"m"')
    drawn_duty.write_text(text.replace("-50e6", "2e-3").replace("= 50e6", "= 8e-3"))
    scatter = read_scatter(drawn_duty)
    found, duty = scatter.lives(), scatter.duties[3].with_(changes_an_hour=0.0)
    table = life(duty).table.set_index("region")
    assert found[3]["life_web"] <= table.loc["web", "life in h, defect"] * 1.001
    longer = table.loc["web"].filter(like="life in h that")
    assert found[3]["life_web"] < 0.9 * longer.item()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"cases[0].load"', '"criterion"', "criterion cannot be drawn"),
        ("low = 0.8", "low = -0.8", r"cases\[0\].load"),
        ('"cases[0].load"', '"cases[4].load"', "cases has 2 items"),
        ("runs = 12", "", "runs must be given"),
        ('"duty.toml"', '"other.toml"', r"scatter.toml: duty: there is no file .*other.toml"),
    ],
)
def test_faults_of_what_is_drawn_are_told(drawn_duty, old, new, told):
    drawn_duty.write_text(drawn_duty.read_text().replace(old, new))
    with pytest.raises(CaseFileError, match=told):
        read_scatter(drawn_duty)


def test_a_drawn_case_has_the_same_name_in_every_process():
    """Which seeds of hashes, one a process, do not change."""
    case = DutyCase(name="stones", case="sand", an_hour=2.0)
    expected = hashlib.sha256(b"stones\nsand\nunloaded").hexdigest()
    (named,) = _with_all_cases([Duty(cases=(case,), material=FatigueMaterial.cast_nicrmo())]).cases
    assert named.name == expected


def test_the_ready_scatter_over_a_duty_can_be_planned():
    scatter = read_scatter(Path(__file__).parents[2] / "studies" / "duty_scatter.toml")
    assert len(scatter.duties) == len(scatter.planned) == 1000
    assert {one.cases[9].case for one in scatter.duties} == {
        "stone at the edge, sand, mean",
        "stone at the edge, rock, mean",
    }


def test_a_broken_scatter_file_is_named(tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text("duty = 'duty.toml'\nruns = 20\nruns = 30\n")
    with pytest.raises(CaseFileError, match=r"^.*broken\.toml: not TOML: this key or table stands twice"):
        read_scatter(path)
