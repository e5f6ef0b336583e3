"""Run the cases of a study, each into its own folder, and compare them with the paper."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypedDict, Unpack

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


Compared = tuple[dict[str, CaseRun], pd.DataFrame]
"""Runs of a study by case, and their comparison with the paper, or what else a table says of them."""


def save(out: Path | None, **tables: pd.DataFrame) -> None:
    """Write tables by the names of their files into a folder, if there is one."""
    if out is not None:
        for name, table in tables.items():
            write_table(table, out / f"{name}.csv", overwrite=True)


def by_name(what: str, tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Tables one below the other, with a column of their names first."""
    whole = pd.concat([table.assign(**{what: name}) for name, table in tables.items()], ignore_index=True)
    return whole[[what, *[name for name in whole.columns if name != what]]]


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
    """Run cases into folders of their names in `out`, and hold it while a study writes its results there.

    None writes nothing. A study that was stopped continues: cases that have finished are used as they are.
    `reuse` has by case the folder of an earlier run whose history replaces the simulation; the others are as
    of `run_case`. FileExistsError before anything runs if the folder has results and `overwrite` is false,
    BlockingIOError if another run works there, else errors of `run_case`.
    """
    with run_in(out, overwrite=overwrite, report=say, cases=cases) as folder:
        how: dict[str, Any] = {"overwrite": folder.overwrites, "progress": progress, "say": folder.say}
        runs = {}
        for name, case in cases.items():
            source = None if reuse is None else reuse[name]
            runs[name] = run_case(case, out and out / name, take_finished=True, reuse=source, **how)
        yield runs


def compare_cases(
    cases: Mapping[str, CaseFile],
    out: Path | None,
    compare: Callable[[Mapping[str, History]], pd.DataFrame],
    write: Callable[[Mapping[str, History], Path], None],
    reuse: Mapping[str, Path | None] | None = None,
    **how: Unpack[Running],
) -> Compared:
    """Run cases as `study_runs`, `compare` their histories with a paper, and `write` more files of them."""
    with study_runs(out, cases, reuse, **how) as runs:
        histories = {name: run.history for name, run in runs.items()}
        table = compare(histories)
        save(out, comparison=table)
        if out is not None:
            write(histories, out)
    return runs, table
