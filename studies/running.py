"""Runs of a study's cases, each in its own folder, and their comparison with the paper."""

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
"""Runs of a study by case, and their comparison with the paper or another table."""


def save(out: Path | None, **tables: pd.DataFrame) -> None:
    """Write tables to a folder, if given, under their names."""
    if out is not None:
        for name, table in tables.items():
            write_table(table, out / f"{name}.csv", overwrite=True)


def by_name(what: str, tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Stack tables one below the other, with a first column of their names."""
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
    """Run cases in folders of their names in `out`, and hold `out` while a study writes its results there.

    Nothing is written if `out` is None. A stopped study continues: finished cases are used as they are.
    `reuse` has the folder of an earlier run by case; its history replaces the simulation. See `run_case` for
    other arguments. Before anything runs, raises `FileExistsError` if the folder has results and `overwrite`
    is false, and `BlockingIOError` if another run works there. Other errors are those of `run_case`.
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
    """Run cases by `study_runs`, `compare` their histories with a paper, and `write` more files from them."""
    with study_runs(out, cases, reuse, **how) as runs:
        histories = {name: run.history for name, run in runs.items()}
        table = compare(histories)
        save(out, comparison=table)
        if out is not None:
            write(histories, out)
    return runs, table
