"""Results of a sweep: one row for each run, answers over the grid, sensitivities and scatter."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import binomtest, quantile_test, spearmanr

from exudyn_crawler.errors import NoAnswerError
from exudyn_crawler.results.history.catalogue import READ_IN
from exudyn_crawler.settings.fields import PREFIXES, prefix_of, value_text
from exudyn_crawler.sweep import answers, definition, worker
from exudyn_crawler.sweep.scatter import AnySweep
from exudyn_crawler.views.tables import write_table

MISSING = "missing"  # status of a run without an outcome
NOT_BUILT = "not built"
"""Status of a draw whose machine cannot be built."""
TABLE = "results.csv"
"""File name of the table of a sweep, in its folder."""
BINS = 8  # of a continuous variable, for main effects
LEAST_RUNS = 64  # least finished runs of a sample for an estimate of first-order indices
LEAST_SCATTERED = 10  # least finished runs of a sample for tables of scatter
PORTIONS = (0.01, 0.05, 0.1, 0.5, 0.9, 0.95, 0.99)
CONFIDENCE = 0.95
PARTS = (4, 2, 1)  # convergence shows quantiles of the first quarter, the first half and all of the runs
SMALL = 1e-12  # fraction of an answer's magnitude: spread below which it does not vary
EFFECTS = ("answer", "varied", "level", "mean", "least", "greatest", "runs")
SALIB = {"first": "S1", "first_conf": "S1_conf", "total": "ST", "total_conf": "ST_conf"}  # its names of these
INDICES = ("answer", "varied", *SALIB)
METHODS = {"grid": "variance of the grid's points", "saltelli": "Saltelli's estimators"}


@dataclass(frozen=True)
class SweepRun:
    """Sweep that was run into a folder: table of its runs, and answers over the grid or over the runs."""

    sweep: AnySweep
    table: pd.DataFrame
    dataset: xr.Dataset
    folder: Path

    def check_answers(self) -> str:
        """Return the number of runs without an answer and the reason; empty if all runs have one.

        Raises `NoAnswerError` if no run has an answer.
        """
        labels = [answer.label for answer in self.sweep.answers]
        without = self.table[self.table[labels].isna().all(axis="columns")]
        if without.empty:
            return ""
        counts = ", ".join(f"{count} {status}" for status, count in without["status"].value_counts().items())
        reasons = without.loc[without["reason"] != "", "reason"].value_counts()
        why = f"; {reasons.iloc[0]} of them: {reasons.index[0]}" if len(reasons) else ""
        told = f"{len(without)} of {len(self.table)} runs have no answer ({counts}){why}"
        if len(without) == len(self.table):
            raise NoAnswerError(f"{self.folder}: {told}; {TABLE} has each, --retry runs failed ones again")
        return told


def results_table(sweep: AnySweep, outcomes: dict[str, worker.Outcome]) -> pd.DataFrame:
    """Return one row for each run; `attrs` has "units" and "meanings" by column; missing answers are NaN."""
    table = sweep.table()
    records: list[worker.Outcome] = [
        {"status": NOT_BUILT, "reason": run.obstacle} if run.obstacle else outcomes.get(run.digest, {})
        for run in sweep.planned
    ]
    for name in sweep.columns:
        table[name] = table[name].map(_cell)
    for answer in sweep.answers:
        numbers = [record.get("answers", {}).get(answer.label) for record in records]
        table[answer.label] = np.array(numbers, dtype=float)
    table["status"] = [record.get("status", MISSING) for record in records]
    table["reason"] = [record.get("reason", "") for record in records]
    table["wall_time_s"] = np.array([record.get("wall_time_s") for record in records], dtype=float)
    table.attrs = {"units": sweep.units(), "meanings": sweep.meanings()}
    return table


def finished(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the finished runs."""
    return table[table["status"] == worker.DONE]


def _cell(value: Any) -> Any:
    """Return a value of the case for a table: a number or a text."""
    return value if isinstance(value, bool | int | float | str) else value_text(value)


def for_reading(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with forces in kN, stresses in MPa, angles in degrees, others with prefixes: MN/m."""
    made = table.copy()
    units = {}
    for name, unit in table.attrs["units"].items():
        prefix = prefix_of(table[name].dropna().tolist(), unit)
        units[name], factor = READ_IN.get(unit, (prefix + unit, 1.0 / PREFIXES[prefix]))
        if factor != 1.0:
            made[name] = factor * table[name]
    made.attrs = table.attrs | {"units": units}
    return made


def _attributes(table: pd.DataFrame, name: str) -> dict[str, str]:
    """Return unit and meaning of a column for NetCDF files."""
    units = table.attrs["units"] | {"wall_time_s": "s"}
    meanings = table.attrs["meanings"]
    return {"units": units.get(name, ""), "long_name": meanings.get(name, "")}


def results_dataset(sweep: AnySweep, table: pd.DataFrame) -> xr.Dataset:
    """Return the answers of a table, with units, over the varied values of a grid, else over the runs."""
    names = [answer.label for answer in sweep.answers]
    if sweep.design == "grid":
        coordinates: dict[str, Any] = {
            variable.label: [*map(_cell, variable.levels())] for variable in sweep.vary
        }
        shape = [len(values) for values in coordinates.values()]
        dimensions = [*coordinates]
    else:
        coordinates = {name: ("run", table[name].to_numpy()) for name in ("run", *sweep.columns)}
        shape = [len(table)]
        dimensions = ["run"]
    columns = {name: table[name].to_numpy(dtype=float) for name in (*names, "wall_time_s")}
    columns["run_number"] = table["run"].to_numpy()
    data = {name: (dimensions, values.reshape(shape)) for name, values in columns.items()}
    dataset = xr.Dataset(data, coords=coordinates)
    for name in map(str, dataset.variables):
        dataset[name].attrs |= {key: text for key, text in _attributes(table, name).items() if text}
    return dataset


def scatter_tables(sweep: AnySweep, table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the tables of a sample's scatter by file name; none for other designs and for few runs.

    The bounds of quantiles are order statistics, those of portions Clopper and Pearson's: both hold for any
    distribution of independent draws. A Latin hypercube or a Sobol sequence covers the drawn values more
    evenly. Its error is therefore less as a rule, and the bounds are on the safe side.
    """
    if not sweep.is_sampled or len(finished(table)) < LEAST_SCATTERED:
        return {}
    made = {"quantiles": quantiles, "sensitivities": sensitivities, "failures": failures}
    return {name: make(sweep, table) for name, make in made.items()}


def quantiles(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Return the quantiles of every answer over the finished runs, with bounds and those of fewer runs.

    Columns are answer, unit, runs (those with the answer), drawn (all of them), portion below, value, least
    and most (of `CONFIDENCE`; NaN if there are too few runs), and the value of the first quarter and of the
    first half of the runs.
    """
    done = finished(table)
    units = table.attrs["units"]
    rows = []
    for answer in sweep.answers:
        values = done[answer.label].dropna().to_numpy()
        parts = [values[: max(1, len(values) // part)] for part in PARTS]
        for portion in PORTIONS if len(values) else ():
            quarter, half, value = (float(np.quantile(part, portion)) for part in parts)
            bounds = quantile_test(values, q=value, p=portion).confidence_interval(CONFIDENCE)
            first = (answer.label, units[answer.label], len(values), len(table), portion, value)
            rows.append((*first, bounds.low, bounds.high, quarter, half))
    of_all = ["value", "least", "most", "of a quarter", "of half"]
    return pd.DataFrame(rows, columns=["answer", "unit", "runs", "drawn", "portion below", *of_all])


def sensitivities(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Return Spearman's rank correlation of each answer with each drawn number, and its p value."""
    done = finished(table)
    rows = []
    numeric = [name for name in sweep.columns if pd.api.types.is_numeric_dtype(done[name])]
    for answer in sweep.answers:
        known = done[done[answer.label].notna()]
        for name in numeric if known[answer.label].nunique() > 1 else ():
            ranks = spearmanr(known[name], known[answer.label])
            rows.append((answer.label, name, float(ranks.statistic), float(ranks.pvalue)))
    ranks = pd.DataFrame(rows, columns=["answer", "varied", "rank correlation", "p value"])
    ranks = ranks.sort_values("rank correlation", key=abs, ascending=False, kind="stable")
    return ranks.sort_values("answer", kind="stable", ignore_index=True)


def failures(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Return shoes of a fleet that crack before a rebuild, by answer of life, with bounds of `CONFIDENCE`.

    A run stands for a shoe. Columns are answer, hours, cracked (runs of all), portion with least and most,
    and shoes a year with least and most: the mean over the years until then. A cracked shoe counts once.
    """
    done = finished(table)
    fleet = sweep.fleet
    rows = []
    for answer in (output for output in sweep.answers if isinstance(output, answers.Life)):
        lives = done[answer.label].dropna()
        if lives.empty:
            continue
        for hours in dict.fromkeys((min(fleet.hours_a_year, fleet.rebuild), fleet.rebuild)):
            cracked = int((lives < hours).sum())
            bounds = binomtest(cracked, len(lives)).proportion_ci(CONFIDENCE)
            portions = np.array([cracked / len(lives), bounds.low, bounds.high])
            a_year = fleet.shoes * portions * fleet.hours_a_year / hours
            rows.append((answer.label, hours, f"{cracked} of {len(lives)}", *portions, *a_year))
    names = ["portion", "least", "most", "shoes a year", "least a year", "most a year"]
    return pd.DataFrame(rows, columns=["answer", "hours", "cracked", *names])


def write_units_csv(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV with units in its head: ``spring_stiffness in N/m``."""
    named = {name: f"{name} in {unit}" for name, unit in table.attrs["units"].items() if unit}
    write_table(table.rename(columns=named), path, overwrite=True)


def numbers_of(table: pd.DataFrame, name: str) -> tuple[np.ndarray, list[str]]:
    """Return a column of a varied value as numbers: itself, or the codes of its texts and these texts."""
    values = table[name]
    if pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values):
        return values.to_numpy(dtype=float), []
    codes, texts = pd.factorize(values.astype(str))
    return codes.astype(float), list(texts)


def main_effects(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Return mean and extremes of answers (`EFFECTS`) at levels of each varied value, or in bins if many."""
    done = finished(table)
    frames = [pd.DataFrame(columns=list(EFFECTS))]
    for name in sweep.columns if len(done) else ():
        values, texts = numbers_of(done, name)
        groups = values
        if len(np.unique(values)) > 2 * BINS:
            groups = (pd.Series(values).rank(method="first").to_numpy() - 1.0) * BINS // len(values)
        levels = pd.Series(values).groupby(groups).mean()
        for answer in sweep.answers:
            numbers = done[answer.label].where(np.isfinite(done[answer.label])).groupby(groups)
            by_level = numbers.agg(mean="mean", least="min", greatest="max", runs="count")
            by_level["level"] = [texts[round(level)] if texts else level for level in levels]
            frames.append(by_level[by_level["runs"] > 0].assign(answer=answer.label, varied=name))
    return pd.concat(frames[1:] or frames, ignore_index=True)[list(EFFECTS)]


def sobol_indices(sweep: AnySweep, table: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Return fractions of each answer's variance by each value alone and in total, `INDICES`; and how.

    On a whole grid the indices are exact for its points. First: variance of the means over all other values.
    Total: remainder after averaging over one value. Saltelli's points give estimates with their 95 %
    confidence (SALib, Saltelli 2010), other samples first-order ones by RBD-FAST (Tarantola 2006). The second
    result is the method or, without indices, the reason.
    """
    none = pd.DataFrame(columns=list(INDICES))
    done = finished(table)
    values = done[[answer.label for answer in sweep.answers]]
    spread = values.max() - values.min()
    varying = values.columns[values.notna().all() & (spread > SMALL * values.abs().max())]
    if varying.empty:
        return none, "no answer varies"
    if sweep.design in ("grid", "saltelli"):
        if len(done) < len(table):
            return none, f"design {sweep.design!r} needs all runs to have finished"
    elif sweep.design == "list" or len(done) < LEAST_RUNS:
        return none, f"they need a grid, or at least {LEAST_RUNS} finished runs of a sample"
    frames = [
        pd.DataFrame({"answer": name, "varied": sweep.columns} | _indices(sweep, done, name))
        for name in varying
    ]
    method = METHODS.get(sweep.design, "RBD-FAST, first order")
    return pd.concat(frames, ignore_index=True).reindex(columns=list(INDICES)), method


def _indices(sweep: AnySweep, done: pd.DataFrame, answer: str) -> dict[str, Any]:
    """Return the indices of an answer by column, in the order of the varied values."""
    values = done[answer].to_numpy()
    if sweep.design == "grid":
        values = values.reshape([len(variable.levels()) for variable in sweep.vary])
        axes = range(values.ndim)
        alone = [values.mean(axis=tuple(other for other in axes if other != axis)).var() for axis in axes]
        others = [values.mean(axis=axis).var() for axis in axes]
        return {"first": alone / values.var(), "total": 1.0 - others / values.var()}
    from SALib.analyze import rbd_fast, sobol

    problem = definition.salib_problem(len(sweep.vary))
    if sweep.design == "saltelli":
        indices = sobol.analyze(problem, values, calc_second_order=False, seed=sweep.seed)
    else:
        points = np.column_stack([numbers_of(done, name)[0] for name in sweep.columns])
        indices = rbd_fast.analyze(problem, points, values, seed=sweep.seed)
    return {name: indices[key] for name, key in SALIB.items() if key in indices}


def best_and_worst(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Return the best and worst finished run of every answer: answer, which, run, value, unit, folder."""
    done = finished(table)
    units = table.attrs["units"]
    rows = []
    for answer in sweep.answers:
        values = done[answer.label].dropna()
        if values.empty:
            continue
        ends = [values.idxmin(), values.idxmax()]
        best, worst = ends if answer.better == "less" else reversed(ends)
        for which, row in (("best", best), ("worst", worst)):
            run, folder = done.loc[row, ["run", "folder"]]
            rows.append((answer.label, which, run, values[row], units[answer.label], folder))
    return pd.DataFrame(rows, columns=["answer", "which", "run", "value", "unit", "folder"])
