"""The papers' studies with other choices, with plainly wrong ones, and from starts that differ by rounding.

The default follows the words and the means of the papers. Choices that only fit rows are variants. A row that
stays within its limit under all variants, also without friction or with half of the load, says nothing about
the model: it is an input. Extremes of a track that sticks and slips are draws; runs from other starts give
their medians and ranges.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from exudyn_crawler import Case, History, LoadCycle, PairContact, Shoe, SphereContact, simulate
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.results.stress.recovery import recover_stresses
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.spread_run import nudged
from studies import CYCLE_DURATION, DURATION, comparison
from studies.forces import compare_forces
from studies.grounds import pitching
from studies.kinematics import CASES
from studies.running import save
from studies.stress import compare_stresses

Change = Callable[[Case], Case]
ROW = ["study", "case", "quantity", "statistic", "unit", "class", "paper"]
"""Columns of a reported row."""
FIRST = "default"  # run without a change, which is the first start


def _contact(**changes: Any) -> Change:
    return lambda case: case.with_(contact=case.part(PairContact).with_(**changes))


def _friction(factor: float) -> Change:
    """Scale both coefficients of friction."""

    def scaled(case: Case) -> Case:
        contact = case.part(PairContact)
        static, dynamic = contact.static_friction, contact.dynamic_friction
        return _contact(static_friction=factor * static, dynamic_friction=factor * dynamic)(case)

    return scaled


def _half_load(case: Case) -> Case:
    phases = [
        phase.with_(loads=tuple(0.5 * load for load in phase.loads)) for phase in case.part(LoadCycle).phases
    ]
    return case.with_(loads=LoadCycle(phases=tuple(phases)))


def _forward(case: Case) -> Case:
    """Move the ground by half a unit, and with it all seams."""
    terrain = case.part(Terrain)
    x, y = terrain.origin
    return case.with_(terrain=terrain.with_(origin=(x + 0.5 * terrain.unit_length, y)))


def _spheres(case: Case) -> Case:
    return case.with_(shoe=Shoe.ph4100c(), contact=SphereContact.oil_sand())


WRONG: Mapping[str, Change] = {
    "no friction": _friction(0.0),
    "half the friction": _friction(0.5),
    "twice the friction": _friction(2.0),
    "half the load": _half_load,
}
"""Changes that contradict what the papers state."""

OPEN: Mapping[str, Change] = {
    "closest points": _contact(penetration="closest"),
    "face normal": lambda case: case.with_(contact=PairContact.oil_sand()),
    "no fingers": lambda case: case.with_(shoe=Shoe.ph4100c()),
    "units pitch": pitching,
    "uneven shoe": lambda case: case.with_(shoe=Shoe.uneven()),
    "uneven shoe, closest points": lambda case: _contact(penetration="closest")(
        case.with_(shoe=Shoe.uneven())
    ),
    "seams half a unit ahead": _forward,
    "spheres": _spheres,
}
"""Choices that the papers leave open in the rigid studies."""


class Repeated(NamedTuple):
    """Studies that share their runs."""

    cases: Mapping[str, Callable[[], Case]]
    compare: Callable[[Mapping[str, History]], pd.DataFrame]
    duration: float  # s
    variants: Mapping[str, Change]
    starts: int

    @property
    def runs(self) -> dict[str, Change]:
        """Changes of all runs by name: the default, variants, then starts from the second on."""
        starts = {f"start {k + 1}": partial(nudged, times=k) for k in range(1, self.starts)}
        return {FIRST: lambda case: case} | dict(self.variants) | starts


def _compare_rigid(histories: Mapping[str, History]) -> pd.DataFrame:
    return pd.concat([comparison.compare_kinematics(histories), compare_forces(histories)], ignore_index=True)


def _compare_cycle(histories: Mapping[str, History]) -> pd.DataFrame:
    history = histories["cycle"]
    return compare_stresses(history, recover_stresses(history))


STUDIES: dict[str, Repeated] = {
    "rigid": Repeated(CASES, _compare_rigid, DURATION, {**OPEN, **WRONG}, 16),
    "stress": Repeated(
        {"cycle": Case.stress},
        _compare_cycle,
        CYCLE_DURATION,
        {
            "no friction": WRONG["no friction"],
            "half the load": _half_load,
            "law shared by area": _contact(sharing="area"),
            "fitted seams": lambda case: case.with_(terrain=Case.stress(seams="fitted").terrain),
        },
        8,
    ),
}
"""Kinematics and forces, and the stress study."""


def study(
    name: str, out: Path, workers: int | None = None, say: Callable[[str], None] = quiet
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Repeat studies and write the tables of `repeat` and of `evidence` to `out`; return both."""
    table = repeat(name, out, workers, say)
    told = evidence(name, table)
    save(out, **{name: table, f"{name}_evidence": told})
    return table, told


def repeat(
    name: str, out: Path, workers: int | None = None, say: Callable[[str], None] = quiet
) -> pd.DataFrame:
    """Run studies with all changes and tabulate their rows: the columns `ROW`, then one per run.

    `name` is one of `STUDIES`. Each run leaves a small file in a folder of that name in `out`. Finished runs
    of the same cases are not repeated. `workers` is the number of processes; None takes one per core.
    """
    repeated = STUDIES[name]
    folder = writable_folder(out / name)
    paths = {run: folder / f"{run.replace(',', '').replace(' ', '_')}.json" for run in repeated.runs}
    missing = [run for run, path in paths.items() if not _is_of(path, repeated, run)]
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        started = {pool.submit(_run, name, run, paths[run]): run for run in missing}
        for number, done in enumerate(as_completed(started), start=1):
            done.result()
            say(f"{name}: {number} of {len(missing)} runs, {started[done]}")
    records = {run: json.loads(path.read_text(encoding="utf-8"))["rows"] for run, path in paths.items()}
    reported = [comparison.reported_values(one) for one in dict.fromkeys(records[FIRST]["study"])]
    rows = pd.concat(reported, ignore_index=True).rename(columns={"value": "paper"})[ROW]
    return rows.assign(**{run: values["computed"] for run, values in records.items()})


def _is_of(path: Path, repeated: Repeated, run: str) -> bool:
    """Return True if a file has the rows of a run of the same cases and duration."""
    if not path.is_file():
        return False
    kept = json.loads(path.read_text(encoding="utf-8"))
    try:
        cases = {name: Case.model_validate_json(text) for name, text in kept["cases"].items()}
    except ValueError:  # of a version with other parameters
        return False
    return kept["duration"] == repeated.duration and cases == _cases(repeated, run)


def _cases(repeated: Repeated, run: str) -> dict[str, Case]:
    return {name: repeated.runs[run](make()) for name, make in repeated.cases.items()}


def _run(name: str, run: str, path: Path) -> None:
    """Run the cases of a study with a change, and write their rows."""
    repeated = STUDIES[name]
    cases = _cases(repeated, run).items()
    histories = {key: simulate(case, repeated.duration, progress=False) for key, case in cases}
    write_rows(name, run, repeated.compare(histories), path)


def write_rows(name: str, run: str, table: pd.DataFrame, path: Path) -> None:
    """Write the compared rows of a run to its file."""
    repeated = STUDIES[name]
    cases = {key: case.model_dump_json() for key, case in _cases(repeated, run).items()}
    rows = table[["study", "computed"]].to_dict("list")
    kept = {"cases": cases, "duration": repeated.duration, "rows": rows}
    with whole_file(path, overwrite=True) as partial_file:
        partial_file.write_text(json.dumps(kept), encoding="utf-8")


def is_within(paper: float, computed: float, kind: str, unit: str) -> bool:
    """Return True if a value is within the limit of its class; a lateral one within a factor of 2."""
    if kind == "lateral":
        return comparison.verdict(abs(paper), abs(computed), "fluctuation", unit) == "yes"
    return comparison.verdict(paper, computed, kind, unit) == "yes"


def counts(table: pd.DataFrame) -> pd.DataFrame:
    """Count the rows of a `repeat` table within their class; lateral ones within a factor of 2.

    Columns variant, then one per study, case and class: number within, of the number of rows.
    """
    lines = []
    for name in table.columns[len(ROW) :]:
        line = {"variant": name}
        for (case, kind), rows in table.groupby(["case", "class"], sort=False):
            line[f"{case} {kind}"] = f"{sum(_within(rows, name))} of {len(rows)}"
        lines.append(line)
    return pd.DataFrame(lines)


def _within(rows: pd.DataFrame, run: str) -> Iterator[bool]:
    each = zip(rows["paper"], rows[run], rows["class"], rows["unit"], strict=True)
    return (is_within(*row) for row in each)


def evidence(name: str, table: pd.DataFrame) -> pd.DataFrame:
    """Return how much each row of a `repeat` table says.

    Columns study, case, quantity, statistic, paper; within and variants: in how many variants (the default is
    one) the row is within its limit, and their number; outside, the names of the others; starts, and median,
    least and greatest value of these.
    """
    repeated = STUDIES[name]
    variants = [FIRST, *repeated.variants]
    starts = table[[run for run in repeated.runs if run not in repeated.variants]].to_numpy()
    within = pd.DataFrame({run: list(_within(table, run)) for run in variants})
    return table[comparison.ROW].assign(
        within=within.sum(axis=1),
        variants=len(variants),
        outside=["; ".join(within.columns[~row]) for row in within.to_numpy()],
        starts=repeated.starts,
        median=np.median(starts, axis=1),
        least=starts.min(axis=1),
        greatest=starts.max(axis=1),
    )
