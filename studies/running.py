"""How studies run their cases: each into a folder of its own, then all of them compared with the paper."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, TypedDict

import pandas as pd

from exudyn_crawler import CaseFile, CaseRun, History, run_case
from exudyn_crawler.run.folder import kept_run, quiet
from exudyn_crawler.views.tables import write_table


class Running(TypedDict, total=False):
    """What every study takes of the arguments of `run_case`, and hands on."""

    overwrite: bool
    progress: bool | None
    say: Callable[[str], None]


class Compared(NamedTuple):
    """Runs of a study by case, and their comparison with the paper."""

    runs: dict[str, CaseRun]
    comparison: pd.DataFrame


def run_cases(
    files: Mapping[str, CaseFile],
    out: Path | None,
    reuse: Mapping[str, Path | None] | None = None,
    *,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> dict[str, CaseRun]:
    """Run cases, each into the folder in `out` that is named after it.

    Parameters
    ----------
    files : mapping
        Cases by name.
    out : Path, optional
        None writes nothing.
    reuse : mapping, optional
        Folders of earlier runs by the names of the cases they take the place of.
    overwrite, progress, say
        As of `run_case`, and so are the errors.

    Returns
    -------
    dict
        Runs by name.
    """
    runs = {}
    for name, one in files.items():
        earlier = None if reuse is None else reuse[name]
        folder = out and out / name
        runs[name] = run_case(one, folder, overwrite=overwrite, reuse=earlier, progress=progress, say=say)
    return runs


def compare_cases(
    files: Mapping[str, CaseFile],
    out: Path | None,
    compare: Callable[[Mapping[str, History]], pd.DataFrame],
    write: Callable[[Mapping[str, History], Path, bool], None],
    reuse: Mapping[str, Path | None] | None = None,
    *,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> Compared:
    """Run cases as `run_cases` does and compare them with a paper, in one folder that is held meanwhile.

    Parameters
    ----------
    compare : callable
        Makes the comparison of the histories by case; it is written as `comparison.csv`.
    write : callable
        Writes what else there is to see of the histories into a folder, replacing files or not.

    Raises
    ------
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    with kept_run(out, overwrite=overwrite, tell=say) as keeper:
        runs = run_cases(files, out, reuse, overwrite=overwrite, progress=progress, say=keeper.say)
        histories = {name: run.history for name, run in runs.items()}
        table = compare(histories)
        if out is not None:
            write_table(table, out / "comparison.csv", overwrite)
            write(histories, out, overwrite)
    return Compared(runs, table)
