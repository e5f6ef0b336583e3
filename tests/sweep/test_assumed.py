"""Sweeps over what is assumed of a machine from its datasheet."""

import numpy as np
import pytest

from exudyn_crawler.errors import CaseFileError, ImplausibleWarning
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.sweep.definition import read_sweep
from exudyn_crawler.sweep.page import sweep_page
from exudyn_crawler.sweep.results import results_table, scatter_tables
from exudyn_crawler.sweep.running import run_sweep

MACHINE = """
duration = 0.1
[datasheet]
operating_weight = "35.4 t"
gauge = "2.59 m"
length_on_ground = "4.03 m"
shoe_width = "0.8 m"
shoes = 48
pitch = "215.9 mm"
[gear]
rolling_resistance = 0.04
"""
SCATTER = """
case = "mine.toml"
assumed = true
design = "latin_hypercube"
runs = 4
[[answers]]
name = "tension"
quantity = "link_tension"
"""


@pytest.fixture
def sweep(tmp_path):
    """Write a machine and a sweep over it, and read the sweep."""

    def read(text, machine=MACHINE):
        (tmp_path / "mine.toml").write_text(machine)
        (tmp_path / "scatter.toml").write_text(text)
        return read_sweep(tmp_path / "scatter.toml")

    return read


def test_one_line_draws_all_that_is_assumed_from_its_range_and_the_machine_follows(sweep):
    scatter = sweep(SCATTER)
    drawn = {one.label: one for one in scatter.vary}
    assert (drawn["roller_diameter"].low, drawn["roller_diameter"].high) == (0.75, 0.9)
    cases = [scatter.case_of(row)[0].case for row in scatter.rows]
    column = scatter.columns.index("roller_diameter")
    for row, case in zip(scatter.rows, cases, strict=True):
        assert case.gear.roller_radius == pytest.approx(0.5 * row[column] * 0.2159)
        # what the file says stays
        assert case.gear.rolling_resistance == 0.04
        assert case.track.shoe_count == 96
    assert len({case.shoe.mass for case in cases}) == 4


def test_assumed_values_of_no_datasheet_are_refused(sweep):
    with pytest.raises(CaseFileError, match="assumed needs a case with a datasheet"):
        sweep(SCATTER, 'base = "closed"\nduration = 0.1\n')


def test_draws_whose_machine_cannot_be_built_are_named_and_counted(sweep):
    # with a shoe less, some of the drawn idlers stand in the last road wheel
    marder = library.machines()["marder"].read_text(encoding="utf-8").replace("shoes = 78", "shoes = 77")
    scatter = sweep(SCATTER.replace("runs = 4", "runs = 32"), marder)
    with pytest.warns(ImplausibleWarning) as warned:
        planned = scatter.planned
    unbuilt = [run for run in planned if run.obstacle]
    assert 0 < len(unbuilt) < len(planned) == 32
    told = f"{len(unbuilt)} of 32 draws cannot be built and are left out: runs {unbuilt[0].number}"
    assert any(str(one.message).startswith(told) for one in warned)
    outcomes = {
        run.digest: {"status": "done", "answers": {"tension": float(run.number)}}
        for run in planned
        if not run.obstacle
    }
    table = results_table(scatter, outcomes)
    assert (table["status"] == "not built").sum() == len(unbuilt)
    assert table.set_index("run").loc[unbuilt[0].number, "reason"] == unbuilt[0].obstacle
    quantiles = scatter_tables(scatter, table)["quantiles"]
    assert set(quantiles["runs"]) == {len(outcomes)}
    assert set(quantiles["drawn"]) == {32}
    tensions = sorted(outcome["answers"]["tension"] for outcome in outcomes.values())
    assert quantiles.set_index("portion below")["value"][0.5] == np.median(tensions)
    page = sweep_page(scatter, table, {})
    assert f"{len(outcomes)} done, {len(unbuilt)} not built" in page
    assert f"Quantiles of the finished runs, {len(outcomes)} of 32 that were drawn" in page


@pytest.mark.slow
@pytest.mark.simulation
def test_draws_of_what_is_assumed_run_and_scatter_the_tension(sweep, scheduler, tmp_path):
    scatter = sweep(SCATTER.replace("runs = 4", "runs = 2"))
    run = run_sweep(scatter, tmp_path / "scattered", scheduler=scheduler, progress=False, say=str)
    assert run.table["status"].tolist() == ["done", "done"]
    tension = run.table["tension"]
    assert (tension > 1e3).all()
    # the weight of the chain, its sag and the carriers under it are drawn
    assert tension.max() > 1.05 * tension.min()
