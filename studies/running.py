"""How studies run their cases: each into a folder of its own, then all of them compared with the paper."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypedDict, Unpack

import pandas as pd

from exudyn_crawler import CaseFile, CaseRun, History, run_case
from exudyn_crawler.run.folder.folder import run_in
from exudyn_crawler.run.folder.reporting import quiet
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


@contextmanager
def kept_study(
    out: Path | None,
    cases: Mapping[str, CaseFile],
    reuse: Mapping[str, Path | None] | None = None,
    *,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> Iterator[dict[str, CaseRun]]:
    """Run cases into folders of their names; hold the study's folder while it writes what it makes of them.

    A study that was stopped goes on: cases that have finished are taken as they are.

    Parameters
    ----------
    out : Path, optional
        Folder of the study; None keeps nothing.
    cases : mapping
        Cases by name.
    reuse : mapping, optional
        By case, folder of an earlier run whose history takes the place of the simulation.
    overwrite, progress, say
        As of `run_case`.

    Raises
    ------
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    with run_in(out, overwrite=overwrite, report=say, cases=cases) as folder:
        runs = {
            name: run_case(
                one,
                out and out / name,
                overwrite=folder.overwrites,
                take_finished=True,
                reuse=None if reuse is None else reuse[name],
                progress=progress,
                say=folder.say,
            )
            for name, one in cases.items()
        }
        yield runs


def compare_cases(
    cases: Mapping[str, CaseFile],
    out: Path | None,
    compare: Callable[[Mapping[str, History]], pd.DataFrame],
    write: Callable[[Mapping[str, History], Path], None],
    reuse: Mapping[str, Path | None] | None = None,
    **how: Unpack[Running],
) -> Compared:
    """Run cases as `kept_study` does, and compare them with a paper.

    Parameters
    ----------
    compare : callable
        Makes the comparison of the histories by case; it is written as `comparison.csv`.
    write : callable
        Writes what else there is to see of the histories into a folder.
    """
    with kept_study(out, cases, reuse, **how) as runs:
        histories = {name: run.history for name, run in runs.items()}
        table = compare(histories)
        if out is not None:
            write_table(table, out / "comparison.csv", overwrite=True)
            write(histories, out)
    return Compared(runs, table)
