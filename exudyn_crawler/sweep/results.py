"""Results of a sweep: a row a run, with units, answers over the grid, and what the answers depend on."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case.parameters.paths import value_text
from exudyn_crawler.files import whole_file
from exudyn_crawler.sweep.definition import FOLDER_DIGITS, PlannedRun, Sweep, salib_problem
from exudyn_crawler.sweep.worker import DONE, Outcome
from exudyn_crawler.views.tables import write_table

MISSING = "missing"
"""Status of a run without an outcome."""
BINS = 8
"""Of what varies continuously, for main effects."""
LEAST_RUNS = 64
"""Finished runs of a sample from which first-order indices are estimated."""
SMALL = 1e-12
"""Of an answer's size: spread below which it does not vary."""
COLUMNS = ("answer", "varied", "first", "first_conf", "total", "total_conf")


def results_table(
    sweep: Sweep, planned: tuple[PlannedRun, ...], outcomes: Mapping[str, Outcome]
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
        outcome = outcomes.get(one.digest, {})
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
    columns = pa.Table.from_pandas(table, preserve_index=False)
    fields = [
        field.with_metadata({"units": units.get(field.name, ""), "long_name": meanings.get(field.name, "")})
        for field in columns.schema
    ]
    whole = columns.cast(pa.schema(fields, metadata=columns.schema.metadata))
    with whole_file(path, overwrite=True) as temporary:
        pq.write_table(whole, temporary)


def numbers_of(table: pd.DataFrame, name: str) -> tuple[np.ndarray, list[str]]:
    """A column of what varies as numbers: as it is, or the numbers of its texts, and these."""
    values = table[name]
    if pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values):
        return values.to_numpy(dtype=float), []
    texts = values.astype(str)
    different = list(dict.fromkeys(texts))
    return texts.map({text: k for k, text in enumerate(different)}).to_numpy(dtype=float), different


def main_effects(sweep: Sweep, table: pd.DataFrame) -> pd.DataFrame:
    """Mean and extremes of every answer at the levels of what varies, over all else.

    Returns
    -------
    pandas.DataFrame
        Columns answer, varied, level (number, or text of what has none), mean, least, greatest and runs.
        Of samples the levels are means of bins with as many runs each.
    """
    done = table[table["status"] == DONE]
    rows: list[dict[str, Any]] = []
    for name in sweep.columns if len(done) else ():
        values, texts = numbers_of(done, name)
        groups = _binned(values) if len(np.unique(values)) > 2 * BINS else values
        for answer in sweep.answers:
            numbers = done[answer.label].to_numpy(dtype=float)
            for group in np.unique(groups):
                chosen = numbers[(groups == group) & np.isfinite(numbers)]
                level = float(values[groups == group].mean())
                if len(chosen):
                    spread = {"mean": chosen.mean(), "least": chosen.min(), "greatest": chosen.max()}
                    at = texts[round(level)] if texts else level
                    rows.append(
                        {"answer": answer.label, "varied": name, "level": at} | spread | {"runs": len(chosen)}
                    )
    return pd.DataFrame(
        rows, columns=["answer", "varied", "level", "mean", "least", "greatest", "runs"], dtype=object
    ).infer_objects()


def _binned(values: NDArray) -> NDArray:
    """Bin of every value, as many values in each."""
    order = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    return (order * BINS) // len(values)


def sobol_indices(sweep: Sweep, table: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Shares of every answer's variance that what varies makes, alone (first) and in all (total).

    On a whole grid they are those of its points, exactly: the variance of the means over all else, and what
    is left when one is averaged over. Saltelli's points give estimates with their 95 % confidence (SALib,
    Saltelli 2010), other samples first-order ones by RBD-FAST (Tarantola 2006).

    Returns
    -------
    table : pandas.DataFrame
        Columns answer, varied, first, first_conf, total, total_conf; NaN where the design gives none. Empty
        where it gives no indices at all.
    method : str
        How they were computed, or why there are none.
    """
    done = table["status"] == DONE
    varying = [
        answer.label
        for answer in sweep.answers
        if table.loc[done, answer.label].notna().all() and _varies(table.loc[done, answer.label])
    ]
    if not varying:
        return pd.DataFrame(columns=list(COLUMNS)), "no answer varies"
    if sweep.design in ("grid", "saltelli") and not done.all():
        return pd.DataFrame(columns=list(COLUMNS)), f"design {sweep.design!r} needs all runs to have finished"
    if sweep.design == "grid":
        rows = [row for name in varying for row in _of_grid(sweep, table, name)]
        return pd.DataFrame(rows, columns=list(COLUMNS)), "variance of the grid's points"
    if sweep.design == "saltelli":
        rows = [row for name in varying for row in _of_saltelli(sweep, table, name)]
        return pd.DataFrame(rows, columns=list(COLUMNS)), "Saltelli's estimators"
    if sweep.design == "list" or int(done.sum()) < LEAST_RUNS:
        return (
            pd.DataFrame(columns=list(COLUMNS)),
            f"they need a grid, or at least {LEAST_RUNS} finished runs of a sample",
        )
    rows = [row for name in varying for row in _of_sample(sweep, table[done], name)]
    return pd.DataFrame(rows, columns=list(COLUMNS)), "RBD-FAST, first order"


def _varies(values: pd.Series) -> bool:
    return bool(values.max() - values.min() > SMALL * values.abs().max())


def _of_grid(sweep: Sweep, table: pd.DataFrame, answer: str) -> list[dict[str, Any]]:
    shape = [len(one.levels()) for one in sweep.vary]
    values = table[answer].to_numpy(dtype=float).reshape(shape)
    whole, axes = values.var(), tuple(range(len(shape)))
    rows = []
    for axis, name in enumerate(sweep.columns):
        first = values.mean(axis=tuple(one for one in axes if one != axis)).var() / whole
        total = 1.0 - values.mean(axis=axis).var() / whole
        rows.append({"answer": answer, "varied": name, "first": first, "total": total})
    return rows


def _of_saltelli(sweep: Sweep, table: pd.DataFrame, answer: str) -> list[dict[str, Any]]:
    from SALib.analyze.sobol import analyze

    values = table[answer].to_numpy(dtype=float)
    indices = analyze(salib_problem(len(sweep.vary)), values, calc_second_order=False, seed=sweep.seed)
    return [
        {
            "answer": answer,
            "varied": name,
            "first": indices["S1"][k],
            "first_conf": indices["S1_conf"][k],
            "total": indices["ST"][k],
            "total_conf": indices["ST_conf"][k],
        }
        for k, name in enumerate(sweep.columns)
    ]


def _of_sample(sweep: Sweep, done: pd.DataFrame, answer: str) -> list[dict[str, Any]]:
    from SALib.analyze.rbd_fast import analyze

    points = np.column_stack([numbers_of(done, name)[0] for name in sweep.columns])
    values = done[answer].to_numpy(dtype=float)
    indices = analyze(salib_problem(len(sweep.vary)), points, values, seed=sweep.seed)
    return [
        {"answer": answer, "varied": name, "first": indices["S1"][k], "first_conf": indices["S1_conf"][k]}
        for k, name in enumerate(sweep.columns)
    ]
