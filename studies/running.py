"""Run the cases of a study, each into its own folder, and compare them with the paper."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypedDict, Unpack

import pandas as pd

from exudyn_crawler import CaseFile, History, run_case
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.run.folder.folder import run_in
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.views.tables import write_table


class Running(TypedDict, total=False):
    """Arguments of `run_case` that every study takes and passes on."""

    overwrite: bool
    progress: bool | None
    say: Callable[[str], None]


class Compared(NamedTuple):
    """Runs of a study by case, and their comparison with the paper."""

    runs: dict[str, CaseRun]
    comparison: pd.DataFrame


@contextmanager
def study_runs(
    out: Path | None,
    cases: Mapping[str, CaseFile],
    reuse: Mapping[str, Path | None] | None = None,
    *,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> Iterator[dict[str, CaseRun]]:
    """Run cases into folders of their names, and hold the study's folder while it writes its results.

    A study that was stopped continues: cases that have finished are used as they are.

    Parameters
    ----------
    out : Path, optional
        Folder of the study; None writes nothing.
    cases : mapping
        Cases by name.
    reuse : mapping, optional
        By case, folder of an earlier run whose history replaces the simulation.
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
    """Run cases as `study_runs` does, and compare them with a paper.

    Parameters
    ----------
    compare : callable
        Returns the comparison of the histories by case, which is written as `comparison.csv`.
    write : callable
        Writes further files of the histories into a folder.
    """
    with study_runs(out, cases, reuse, **how) as runs:
        histories = {name: run.history for name, run in runs.items()}
        table = compare(histories)
        if out is not None:
            write_table(table, out / "comparison.csv", overwrite=True)
            write(histories, out)
    return Compared(runs, table)
