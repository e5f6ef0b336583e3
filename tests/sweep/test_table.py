"""Tables and datasets of outcomes: values, units, what is missing."""

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from exudyn_crawler import Vary
from exudyn_crawler.netcdf import write_netcdf
from exudyn_crawler.sweep.table import results_dataset, results_table, write_parquet, write_units_csv
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
    return results_table(sweep, sweep.planned, found)


def test_every_run_has_a_row_with_what_became_of_it(table):
    assert table["status"].tolist() == ["done", "done", "failed", "missing"]
    assert table["reason"].tolist() == ["", "", "sank", ""]
    assert table[FORCE.label].tolist() == pytest.approx([1e3, np.nan, np.nan, np.nan], nan_ok=True)
    assert table[["spring_stiffness", "sharing"]].values.tolist()[1] == [1e7, "area"]


def test_the_head_of_the_csv_has_units(table, tmp_path):
    write_units_csv(table, tmp_path / "t.csv")
    read = pd.read_csv(tmp_path / "t.csv")
    assert list(read)[:5] == [
        "run",
        "folder",
        "spring_stiffness in N/m",
        "sharing",
        "joint_force_greatest in N",
    ]
    assert read["joint_force_greatest in N"][0] == 1e3


def test_parquet_keeps_units_in_its_metadata(table, tmp_path):
    write_parquet(table, tmp_path / "t.parquet")
    schema = pq.read_schema(tmp_path / "t.parquet")
    assert schema.field("spring_stiffness").metadata[b"units"] == b"N/m"
    assert schema.field(FORCE.label).metadata[b"units"] == b"N"
    assert schema.field(FORCE.label).metadata[b"long_name"].startswith(b"greatest of force of the spherical")
    assert pd.read_parquet(tmp_path / "t.parquet").equals(table)


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
    dataset = results_dataset(sweep, results_table(sweep, sweep.planned, {}))
    assert dataset[FORCE.label].dims == ("run",)
    assert dataset.spring_stiffness.values.tolist() == [row[0] for row in sweep.rows]
