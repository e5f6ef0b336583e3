"""Repetition of a finished run from starts that differ by rounding and with the other contact law.

A track that sticks and slips takes another path from a start that differs by rounding. More than one contact
law could stand for the same ground. Differences between such runs are therefore uncertainties of each of
them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import case_run, files
from exudyn_crawler.case import Case, PairContact
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.case_file import BARE
from exudyn_crawler.results.history.catalogue import variable
from exudyn_crawler.results.stress import hot_spots, recovery
from exudyn_crawler.run.folder import folder as folders, progress as parts, record
from exudyn_crawler.views.tables import write_table
from fem import judged

TABLE = "spread.csv"
NUDGE = 1e-9  # m, shift of the ground along the track from start to start
ONE_TIME = BARE.with_(picture_times=(0.0,))  # outputs of a repeated run
FIRST = "start 1"  # name of the judged run
OPEN_PARTS = ("spread", "choice")  # columns of a stress's uncertainty by starts and by laws of contact, Pa


@dataclass(frozen=True)
class Spread:
    """Stresses of a run and their differences from those of repeated runs.

    `dataset` has the spread's variables of the catalogue: shoe and node as in `StressResults`, run with that
    of `peak_von_mises` first; `peak_verdict` counts spread and choice. `hot_spots` has the tables of the
    first run's shoes with columns spread and choice (Pa) and the resulting verdict.
    """

    dataset: xr.Dataset
    hot_spots: Mapping[int, pd.DataFrame]

    def by_shoe(self) -> pd.DataFrame:
        """Return the highest stress of each shoe in each run (MPa), and its spread and choice in per cent."""
        rows = []
        for shoe, table in self.hot_spots.items():
            top = table.iloc[0]
            peaks = self.dataset.run_peak.sel(shoe=shoe, node=top["node"]) / hot_spots.MEGA
            row = {"shoe": shoe, "node": top["node"]}
            row |= {f"{run} in MPa": float(peaks.sel(run=run)) for run in self.dataset.run.values}
            row |= {f"{name} in %": 100.0 * float(top[name] / abs(top["value"])) for name in OPEN_PARTS}
            rows.append(row | {"verdict": top["verdict"]})
        return pd.DataFrame(rows)


def spread(
    run: str | Path,
    starts: int = 3,
    *,
    laws: bool = True,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = record.quiet,
) -> Spread:
    """Repeat a finished run into a folder "spread" in its own, and judge its stresses by the differences.

    The number of `starts` counts the run's own; from one to the next the ground lies 1e-9 m further along the
    track. With `laws` the run is also repeated with the other contact law: that of a pair, whole for each
    contact or shared by area. Rolled tracks and spheres have no other law. Repeated runs have folders of
    their own; finished ones are not repeated, and a stopped one continues. `overwrite` replaces earlier
    results, and repeated runs of other cases. Verdicts on lives of duties with the run count its spread.

    Raises before anything runs: FileNotFoundError or ValueError if the folder has no case or no finished
    history of it, there are no flexible shoes, or nothing is to be repeated; FileExistsError if the folder
    has results and `overwrite` is false. Other errors are those of `run_case`.
    """
    folder = Path(run)
    case_file = read_case(folder / record.CASE)
    history = folders.matching_history(folder, case_file)
    case = case_file.case
    if case.flexible is None:
        raise ValueError(f"the run in {folder} must have flexible shoes to have stresses")
    other_laws = laws_beside(case) if laws else {}
    if starts < 1 or (starts == 1 and not other_laws):
        raise ValueError(f"starts must be at least {2 - bool(other_laws)}, got {starts}")
    for name in (folders.SPREAD, TABLE):
        files.refuse_existing(folder / folders.SPREAD_FOLDER / name, overwrite)
    out = files.writable_folder(folder / folders.SPREAD_FOLDER)
    peaks = {}
    for name, variant in ({f"start {k + 1}": nudged(case, k) for k in range(1, starts)} | other_laws).items():
        path = out / name.replace(" ", "_")
        variant_file = case_file.with_(case=variant, outputs=ONE_TIME)
        say(f"{variant.name}: {name}")
        again = overwrite and path.exists()
        done = case_run.run_case(
            variant_file, path, overwrite=again, take_finished=True, progress=progress, say=say
        )
        peaks[name] = done.recovered().dataset.peak_von_mises
    with parts.heartbeat(f"{case.name}: recovering stresses"):
        spreads = spread_of(recovery.recover_stresses(history), peaks, starts)
    files.write_netcdf(
        spreads.dataset.assign_attrs(case=case.model_dump_json()), out / folders.SPREAD, overwrite
    )
    write_table(spreads.by_shoe(), out / TABLE, overwrite)
    for shoe, spots in spreads.hot_spots.items():
        table = hot_spots.hot_spot_table(spots, spreads.dataset)
        write_table(table, out / f"hot_spots_shoe_{shoe}.csv", overwrite)
    return spreads


def nudged(case: Case, times: int) -> Case:
    """Return a case with its ground some nudges further along the track."""
    x, y = case.terrain.origin
    return case.with_(terrain=case.terrain.with_(origin=(x + times * NUDGE, y)))


def laws_beside(case: Case) -> dict[str, Case]:
    """Return a case with the other contact laws for the same ground, by name."""
    contact = case.contact
    if not isinstance(contact, PairContact) or case.gear.kind == "rolled":
        return {}
    other = "area" if contact.sharing == "pair" else "pair"
    return {f"law by {other}": case.with_(contact=contact.with_(sharing=other))}


def spread_of(first: recovery.StressResults, others: Mapping[str, xr.DataArray], starts: int) -> Spread:
    """Return the spread of a run and others, by name, from their greatest stresses (shoe, node), Pa.

    The run and the first of the others, together as many as `starts`, differ only in their start.
    """
    peaks = [first.dataset.peak_von_mises, *others.values()]
    runs = np.stack([peak.transpose("shoe", "node").values for peak in peaks])
    low = runs[:starts].min(axis=0)
    high = runs[:starts].max(axis=0)
    range_ = high - low
    beyond = np.maximum(runs - high, low - runs).max(axis=0)
    columns = {"peak_spread": range_, "peak_choice": beyond, "run_peak": runs}
    dataset = first.dataset[["peak_von_mises", "node_position", "triangle", "in_spider", "truncation"]]
    dataset = dataset.assign({name: variable(name, values) for name, values in columns.items()})
    dataset = dataset.assign(peak_verdict=recovery.verdicts(first.dataset, range_ + beyond))
    bound = float(first.dataset.truncation)
    tables = {}
    for row, (shoe, table) in enumerate(first.hot_spots.items()):
        nodes = table["node"].to_numpy()
        wider = table.assign(spread=range_[row, nodes], choice=beyond[row, nodes])
        tables[shoe] = judged(wider, None if np.isnan(bound) else bound, wider["spread"], wider["choice"])
    return Spread(dataset.assign_coords(run=[FIRST, *others]), tables)
