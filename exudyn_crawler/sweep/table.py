"""Results of a sweep: a row a run, with units, and answers over the grid."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case.files.text import value_text
from exudyn_crawler.files import whole_file
from exudyn_crawler.sweep.definition import FOLDER_DIGITS, PlannedRun, Sweep
from exudyn_crawler.sweep.storage import Outcome
from exudyn_crawler.views.tables import write_table

MISSING = "missing"
"""Status of a run without an outcome."""


def results_table(
    sweep: Sweep, planned: tuple[PlannedRun, ...], found: Mapping[str, Outcome]
) -> pd.DataFrame:
    """A row a run.

    Returns
    -------
    pandas.DataFrame
        Columns run, folder, what varies, answers (NaN where there is none), status, reason and wall_time_s;
        `attrs` has "units" and "meanings" by column.
    """
    rows: list[dict[str, Any]] = []
    for one in planned:
        outcome = found.get(one.digest, {})
        answers = outcome.get("answers", {})
        rows.append(
            {"run": one.number, "folder": one.digest[:FOLDER_DIGITS]}
            | {name: _cell(value) for name, value in zip(sweep.columns, one.values, strict=True)}
            | {answer.label: _number(answers.get(answer.label)) for answer in sweep.answers}
            | {
                "status": outcome.get("status", MISSING),
                "reason": outcome.get("reason", ""),
                "wall_time_s": _number(outcome.get("wall_time_s")),
            }
        )
    table = pd.DataFrame(rows)
    table.attrs = {"units": dict(sweep.units()), "meanings": dict(sweep.meanings())}
    return table


def _cell(value: Any) -> Any:
    """Value of the case in a table: a number or a text."""
    return value if isinstance(value, bool | int | float | str) else value_text(_tuples(value))


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list | tuple) else value


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)


def results_dataset(sweep: Sweep, table: pd.DataFrame) -> xr.Dataset:
    """Answers over what varies if the design is a grid, else over the runs; with units and meanings.

    Parameters
    ----------
    table : pandas.DataFrame
        Of `results_table`.
    """
    names = [answer.label for answer in sweep.answers]
    if sweep.design == "grid":
        levels = {one.label: [_cell(value) for value in one.levels()] for one in sweep.vary}
        shape = [len(values) for values in levels.values()]
        dimensions: list[str] = list(levels)
        coordinates: dict[str, Any] = levels
    else:
        shape, dimensions = [len(table)], ["run"]
        coordinates = {"run": table["run"].to_numpy()}
        coordinates |= {name: ("run", table[name].to_numpy()) for name in sweep.columns}
    columns = {name: table[name].to_numpy(dtype=float) for name in (*names, "wall_time_s")}
    columns["run_number"] = table["run"].to_numpy()
    dataset = xr.Dataset(
        {name: (dimensions, values.reshape(shape)) for name, values in columns.items()}, coords=coordinates
    )
    units, meanings = sweep.units() | {"wall_time_s": "s"}, sweep.meanings()
    for name in dataset.variables:
        attributes = {"units": units.get(str(name), ""), "long_name": meanings.get(str(name), "")}
        dataset[name].attrs |= {key: text for key, text in attributes.items() if text}
    return dataset


def write_units_csv(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV with the units in its head: ``spring_stiffness in N/m``."""
    units = table.attrs["units"]
    named = {name: f"{name} in {unit}" for name, unit in units.items() if unit}
    write_table(table.rename(columns=named), path, overwrite=True)


def write_parquet(table: pd.DataFrame, path: Path) -> None:
    """Write a table as Parquet; every column's metadata hold its `units` and `long_name`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    units, meanings = table.attrs["units"] | {"wall_time_s": "s"}, table.attrs["meanings"]
    found = pa.Table.from_pandas(table, preserve_index=False)
    fields = [
        field.with_metadata({"units": units.get(field.name, ""), "long_name": meanings.get(field.name, "")})
        for field in found.schema
    ]
    whole = found.cast(pa.schema(fields, metadata=found.schema.metadata))
    with whole_file(path, overwrite=True) as temporary:
        pq.write_table(whole, temporary)


def numbers_of(table: pd.DataFrame, name: str) -> tuple[np.ndarray, list[str]]:
    """A column of what varies as numbers: as it is, or places among its texts, and these."""
    values = table[name]
    if pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values):
        return values.to_numpy(dtype=float), []
    texts = values.astype(str)
    different = list(dict.fromkeys(texts))
    return texts.map({text: k for k, text in enumerate(different)}).to_numpy(dtype=float), different
