"""Tables and datasets of outcomes; effects and indices of functions whose shares are known."""

import math

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler.files import write_netcdf
from exudyn_crawler.sweep.results import (
    BINS,
    main_effects,
    results_dataset,
    results_table,
    sobol_indices,
    write_units_csv,
)
from exudyn_crawler.sweep.vary import Vary
from tests.sweep.cases import DAMPING, FORCE, STIFFNESS, small_sweep


@pytest.fixture(scope="module")
def sweep():
    return small_sweep(
        vary=(Vary(key=STIFFNESS, values=(1e7, 2e7)), Vary(key="contact.sharing", values=("pair", "area")))
    )


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
ISHIGAMI_FIRST, ISHIGAMI_TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
"""Ishigami and Homma (1990) with a = 7, b = 0.1."""


@pytest.mark.parametrize(
    ("function", "count", "first", "total"),
    [(linear, 4, SQUARES, SQUARES), (product, 3, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0))],
)
def test_shares_on_a_grid_are_those_by_hand(function, count, first, total):
    indices, method = sobol_indices(*sweep_of("grid", function, count=count))
    assert indices["first"].to_numpy() == pytest.approx(first, abs=1e-12)
    assert indices["total"].to_numpy() == pytest.approx(total, abs=1e-12)
    assert method == "variance of the grid's points"


def test_saltellis_points_give_ishigamis_indices():
    indices, _ = sobol_indices(*sweep_of("saltelli", ishigami, runs=1024))
    assert indices["first"].to_numpy() == pytest.approx(ISHIGAMI_FIRST, abs=0.05)
    assert indices["total"].to_numpy() == pytest.approx(ISHIGAMI_TOTAL, abs=0.05)
    assert (indices["first_conf"] < 0.15).all()


@pytest.mark.parametrize("design", ["latin_hypercube", "sobol"])
def test_samples_give_first_order(design):
    indices, method = sobol_indices(*sweep_of(design, linear, runs=512))
    assert indices["first"].to_numpy() == pytest.approx(SQUARES, abs=0.05)
    assert indices["total"].isna().all()
    assert method == "RBD-FAST, first order"


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
    assert own["mean"].to_numpy() == pytest.approx([2.0, 3.5, 5.0])
    assert own["least"].to_numpy() == pytest.approx([0.0, 1.5, 3.0])
    assert own["greatest"].to_numpy() == pytest.approx([4.0, 5.5, 7.0])
    assert own["runs"].tolist() == [9, 9, 9]


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
