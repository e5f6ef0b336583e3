"""Cases of a study, each run into a folder of its own."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from exudyn_crawler import CaseFile, CaseRun, run_case
from exudyn_crawler.run.folder import kept_run
from exudyn_crawler.run.keeper import Keeper


@contextmanager
def kept_study(
    out: Path | None,
    cases: Mapping[str, CaseFile],
    *,
    overwrite: bool,
    progress: bool | None,
    say: Callable[[str], None],
    reuse: Mapping[str, Path | None] | None = None,
) -> Iterator[tuple[dict[str, CaseRun], Keeper]]:
    """Run cases into folders of their names; hold the study's folder while it writes what it makes of them.

    A study that was stopped goes on: cases that have finished are taken as they are.

    Parameters
    ----------
    out : Path, optional
        Folder of the study; None keeps nothing.
    overwrite, progress, say
        As of `run_case`.
    reuse : mapping, optional
        By case, folder of an earlier run whose history takes the place of the simulation.

    Raises
    ------
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    with kept_run(out, overwrite=overwrite, tell=say, cases=cases) as keeper:
        runs = {
            name: run_case(
                one,
                out and out / name,
                overwrite=keeper.overwrites,
                finished_since=keeper.begun if keeper.overwrites else "",
                reuse=None if reuse is None else reuse[name],
                progress=progress,
                say=keeper.say,
            )
            for name, one in cases.items()
        }
        yield runs, keeper
