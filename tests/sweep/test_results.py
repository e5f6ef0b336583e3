"""Tables, datasets and the page of outcomes; effects and indices of functions whose shares are known."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler.files import write_netcdf
from exudyn_crawler.sweep import page
from exudyn_crawler.sweep.results import (
    BINS,
    for_reading,
    main_effects,
    results_dataset,
    results_table,
    sobol_indices,
    write_units_csv,
)
from exudyn_crawler.sweep.vary import Vary
from tests.sweep.cases import DAMPING, FORCE, STIFFNESS, answered, small_case, small_sweep


@pytest.fixture(scope="module")
def sweep():
    """Two stiffnesses, on a logarithmic axis, with each of two laws."""
    stiffness = Vary(key=STIFFNESS, low=1e7, high=2e7, count=2, scale="log")
    return small_sweep(vary=(stiffness, Vary(key="contact.sharing", values=("pair", "area"))))


@pytest.fixture(scope="module")
def table(sweep):
    first, second, third, _ = sweep.planned
    found = {
        first.digest: {"status": "done", "answers": {FORCE.label: 1e3}, "wall_time_s": 2.0},
        second.digest: {"status": "done", "answers": {FORCE.label: None}, "wall_time_s": 3.0},
        third.digest: {"status": "failed", "answers": {}, "reason": "sank"},
    }
    return results_table(sweep, found)


def test_every_run_has_a_row_with_what_became_of_it(table):
    assert table["status"].tolist() == ["done", "done", "failed", "missing"]
    assert table["reason"].tolist() == ["", "", "sank", ""]
    assert table[FORCE.label].tolist() == pytest.approx([1e3, np.nan, np.nan, np.nan], nan_ok=True)
    assert table[["spring_stiffness", "sharing"]].values.tolist()[1] == [1e7, "area"]


def test_the_head_of_the_csv_has_units(table, tmp_path):
    write_units_csv(table, tmp_path / "t.csv")
    read, answer = pd.read_csv(tmp_path / "t.csv"), "joint_force_greatest in N"
    assert list(read)[:5] == ["run", "folder", "spring_stiffness in N/m", "sharing", answer]
    assert read[answer][0] == 1e3


def test_a_grid_is_a_dataset_over_what_varies(sweep, table, tmp_path):
    dataset = results_dataset(sweep, table)
    assert dataset[FORCE.label].dims == ("spring_stiffness", "sharing")
    assert float(dataset[FORCE.label].sel(spring_stiffness=1e7, sharing="pair")) == 1e3
    assert int(dataset.run_number.sel(spring_stiffness=2e7, sharing="pair")) == 3
    units = {name: dataset[name].attrs["units"] for name in ("spring_stiffness", FORCE.label, "wall_time_s")}
    assert units == {"spring_stiffness": "N/m", FORCE.label: "N", "wall_time_s": "s"}
    assert write_netcdf(dataset, tmp_path / "t.nc").is_file()


def test_other_designs_are_a_dataset_over_runs():
    vary = (Vary(key=STIFFNESS, low=1e7, high=2e7), Vary(key=DAMPING, low=1e4, high=2e4))
    sweep = small_sweep(vary=vary, design="latin_hypercube", runs=3)
    dataset = results_dataset(sweep, results_table(sweep, {}))
    assert dataset[FORCE.label].dims == ("run",)
    assert dataset.spring_stiffness.values.tolist() == [row[0] for row in sweep.rows]


TAG = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
NAMES = ("a", "b", "c")
KEYS = (STIFFNESS, DAMPING, "terrain.density")
LOW = (1e7, 1e4, 1000.0)


def sweep_of(design, function, count=None, **given):
    """Sweep of three values, each from its low to twice that, and its table with a function of 0 to 1."""
    vary = tuple(
        Vary(key=key, name=name, low=low, high=2.0 * low, count=count)
        for key, name, low in zip(KEYS, NAMES, LOW, strict=True)
    )
    sweep = small_sweep(vary=vary, design=design, **given)
    table = pd.DataFrame(sweep.rows, columns=list(NAMES))
    unit = table.to_numpy() / np.array(LOW) - 1.0
    return sweep, table.assign(joint_force_greatest=function(*unit.T), status="done")


def linear(a, b, _c):
    return 3.0 * a + 4.0 * b


def product(a, b, _c):
    return (a - 0.5) * (b - 0.5)


def ishigami(a, b, c):
    x, y, z = (math.pi * (2.0 * u - 1.0) for u in (a, b, c))
    return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


SQUARES = (9 / 25, 16 / 25, 0.0)
"""Shares of the linear function."""
ISHIGAMI = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
"""Ishigami and Homma (1990) with a = 7, b = 0.1."""


NONE = (np.nan, np.nan, np.nan)


@pytest.mark.parametrize(
    ("design", "function", "given", "first", "total", "within", "method"),
    [
        ("grid", linear, {"count": 4}, SQUARES, SQUARES, 1e-12, "variance of the grid's points"),
        ("grid", product, {"count": 3}, (0, 0, 0), (1, 1, 0), 1e-12, "variance of the grid's points"),
        ("saltelli", ishigami, {"runs": 1024}, *ISHIGAMI, 0.05, "Saltelli's estimators"),
        ("latin_hypercube", linear, {"runs": 512}, SQUARES, NONE, 0.05, "RBD-FAST, first order"),
        ("sobol", linear, {"runs": 512}, SQUARES, NONE, 0.05, "RBD-FAST, first order"),
    ],
)
def test_indices_are_those_by_hand_and_of_ishigami(design, function, given, first, total, within, method):
    """Samples give the first order alone."""
    indices, said = sobol_indices(*sweep_of(design, function, **given))
    assert indices["first"].to_numpy() == pytest.approx(first, abs=within)
    assert indices["total"].to_numpy() == pytest.approx(total, abs=within, nan_ok=True)
    assert said == method
    if design == "saltelli":
        assert (indices["first_conf"] < 0.15).all()


def test_designs_that_give_no_indices_say_so():
    few = sweep_of("latin_hypercube", linear, runs=8)
    assert sobol_indices(*few)[1] == "they need a grid, or at least 64 finished runs of a sample"
    sweep, table = sweep_of("grid", linear, count=2)
    assert sobol_indices(sweep, table.assign(joint_force_greatest=1.0))[1] == "no answer varies"
    table.loc[3, ["status", "joint_force_greatest"]] = ["failed", np.nan]
    indices, told = sobol_indices(sweep, table)
    assert indices.empty
    assert told == "design 'grid' needs all runs to have finished"


def test_main_effects_of_a_grid_are_means_over_all_else():
    effects = main_effects(*sweep_of("grid", linear, count=3))
    own = effects[effects["varied"] == "a"]
    assert own["level"].tolist() == [1e7, 1.5e7, 2e7]
    rows = [[2.0, 0.0, 4.0, 9], [3.5, 1.5, 5.5, 9], [5.0, 3.0, 7.0, 9]]
    assert own[["mean", "least", "greatest", "runs"]].to_numpy(dtype=float) == pytest.approx(np.array(rows))


def test_main_effects_of_samples_are_those_of_bins():
    effects = main_effects(*sweep_of("latin_hypercube", linear, runs=160))
    own = effects[effects["varied"] == "b"]
    assert own["runs"].tolist() == [160 // BINS] * BINS
    middles = (np.arange(BINS) + 0.5) / BINS
    assert own["level"].to_numpy() == pytest.approx(1e4 * (1.0 + middles), rel=0.01)
    assert own["mean"].to_numpy() == pytest.approx(1.5 + 4.0 * middles, abs=0.7)


def test_texts_are_levels_too():
    sweep = small_sweep(vary=(Vary(key="contact.sharing", values=("pair", "area")),))
    table = pd.DataFrame({"sharing": ["pair", "area"], "joint_force_greatest": [1.0, 2.0], "status": "done"})
    effects = main_effects(sweep, table)
    assert effects[["level", "mean"]].values.tolist() == [["pair", 1.0], ["area", 2.0]]


@pytest.fixture
def drawn(sweep):
    """Answers of three runs; the last one has failed."""
    return answered(sweep, **{FORCE.label: np.array([1.0, 3.0, 2.0, np.nan])})


def test_a_grid_has_a_curve_a_level_of_what_varies_next(sweep, drawn):
    figure = page.response_curves(sweep, for_reading(drawn), FORCE.label)
    assert [(one.name, list(one.x), [1e3 * force for force in one.y]) for one in figure.data] == [
        ("sharing = area", [10.0], [3.0]),
        ("sharing = pair", [10.0, 20.0], [1.0, 2.0]),
        ("spring_stiffness = 10 MN/m", ["area", "pair"], [3.0, 1.0]),
        ("spring_stiffness = 20 MN/m", ["pair"], [2.0]),
    ]
    assert [axis.title.text for axis in figure.select_xaxes()] == ["spring_stiffness in MN/m", "sharing"]
    assert next(figure.select_yaxes()).title.text == f"{FORCE.label} in kN"
    assert list(figure.layout.xaxis.ticktext) == ["10", "20"]


def test_other_designs_have_a_point_a_run(sweep, drawn):
    points = page.response_curves(small_sweep(vary=sweep.vary, design="list"), drawn, FORCE.label).data
    assert [(list(one.x), list(one.y)) for one in points] == [
        ([1e7, 1e7, 2e7], [1.0, 3.0, 2.0]),
        (["pair", "area", "pair"], [1.0, 3.0, 2.0]),
    ]


def test_effects_reach_from_the_least_to_the_greatest_over_axes_as_they_vary(sweep, drawn):
    figure = page.effect_figure(sweep, drawn, main_effects(sweep, drawn), FORCE.label)
    line = figure.data[0]
    found = [list(one) for one in (line.y, line.error_y.array, line.error_y.arrayminus)]
    assert found == [[2.0, 2.0], [1.0, 0.0], [1.0, 0.0]]
    assert (figure.layout.xaxis.type, figure.layout.xaxis2.type) == ("log", None)


def test_lives_are_on_logarithmic_axes_and_many_panels_in_rows(sweep, drawn):
    names = [f"v{k}" for k in range(8)]
    drawn[FORCE.label] = [1e4, 1e5, 2e6, np.nan]
    drawn[names] = 1.0
    drawn.attrs["units"] |= {FORCE.label: "h"}
    vary = [SimpleNamespace(label=name, scale="linear") for name in names]
    many = SimpleNamespace(vary=vary, columns=names, answers=sweep.answers, design="list")
    figure = page.response_curves(many, drawn, FORCE.label)
    assert {axis.type for axis in figure.select_yaxes()} == {"log"}
    assert [(one.xaxis, list(one.y)) for one in figure.data][7] == ("x8", [1e4, 1e5, 2e6])
    tops = [axis.domain[1] for axis in figure.select_yaxes()]
    assert tops[page.ACROSS] < min(tops[: page.ACROSS])


def test_the_page_links_to_runs_and_tells_of_failures_without_their_markup(sweep, drawn):
    text = page.sweep_page(sweep, drawn, {drawn["folder"][0]: "runs/a/report.html"})
    assert 'href="runs/a/report.html">1</a>' in text
    assert "it &lt;b&gt;sank&lt;/b&gt;" in text
    assert "<p>None: design &#39;grid&#39; needs all runs to have finished.</p>" in text
    assert "0.001 kN" in text
    assert f"{FORCE.label} in kN" in text


def test_no_name_is_markup_or_script_of_a_sweeps_page():
    named = small_case().case.with_(name=TAG)
    vary = (Vary(key=STIFFNESS, name=TAG, values=(1e7, 2e7)),)
    answer = FORCE.with_(name=f"answer {TAG}")
    tagged = small_sweep(case=small_case().with_(case=named), vary=vary, answers=(answer,))
    table = answered(tagged, **{answer.label: np.array([1.0, 2.0])})
    text = page.sweep_page(tagged, table, {})
    assert "&lt;img src=x" in text
    assert TAG not in text
    assert "<img src=x" not in text


def test_a_sweep_without_a_finished_run_has_a_page_without_figures(sweep, drawn):
    text = page.sweep_page(sweep, drawn.assign(**{FORCE.label: np.nan}), {})
    assert "No run has finished." in text
    assert "plotly" not in text.lower()


@pytest.mark.parametrize(("count", "shown"), [(4, 4), (page.MOST_DRAWN + 1, page.MOST_DRAWN // 2 + 1)])
def test_very_many_runs_are_thinned(sweep, table, count, shown):
    many = table.iloc[np.zeros(count, dtype=int)].assign(**{FORCE.label: np.arange(count, dtype=float)})
    (points, *_) = page.response_curves(small_sweep(vary=sweep.vary, design="list"), many, FORCE.label).data
    assert (len(points.y), points.y[0]) == (shown, 0.0)


def test_long_tables_are_cut(sweep, drawn, monkeypatch):
    monkeypatch.setattr(page, "LONGEST_TABLE", 3)
    text = page.sweep_page(sweep, drawn, {})
    assert "1 more are in results.csv." in text
    assert "sank" not in re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert "area" in text
