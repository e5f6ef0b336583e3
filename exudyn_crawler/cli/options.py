"""Options that commands share, and runs as a command line names them: by their folder or their history."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

RESULTS = Path("results")
"""Folder of the folders of runs and studies, where a command names no other."""

Run = Annotated[Path, typer.Argument(help="folder of a run, or its history (NetCDF)", metavar="RUN")]
Out = Annotated[Path, typer.Option(help="folder for the results")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace earlier results")]
Debug = Annotated[bool, typer.Option("--debug", help="show the traceback of an error")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="value in place of the file's, as terrain.spring_stiffness=1e7; repeatable"),
]


if TYPE_CHECKING:
    from exudyn_crawler.results.history.history import History


def run_folder(run: Path) -> Path:
    """Folder of a run, named itself or by a file in it.

    Raises
    ------
    NotADirectoryError
        If there is neither.
    """
    if run.is_file():
        return run.parent
    if not run.is_dir():
        raise NotADirectoryError(f"no folder {run}")
    return run


def history_path(run: Path) -> Path:
    """History of a run, named itself or by its folder.

    Raises
    ------
    FileNotFoundError
        If there is none, naming those in the folders below.
    """
    if run.is_file():
        return run
    if not run.is_dir():
        raise FileNotFoundError(f"no history at {run}")
    from exudyn_crawler.run.folder.reporting import HISTORY, STOPPED_HISTORY

    for name in (HISTORY, STOPPED_HISTORY):
        if (run / name).is_file():
            return run / name
    below = sorted(str(path.parent) for path in run.glob(f"*/{HISTORY}"))
    hint = f"; name one of {', '.join(below)}" if below else ""
    raise FileNotFoundError(f"no history at {run / HISTORY}{hint}")


def loaded(run: Path, shoe: int | None = None) -> "History":
    """History of a run, named itself or by its folder; errors are those of `history_path` and loading.

    A shoe that its track does not have is refused before the results are read.
    """
    path = history_path(run)
    if shoe is not None:
        from exudyn_crawler.results.history.case_in_file import case_in_file

        case_in_file(path).track.check_shoe(shoe)
    from exudyn_crawler.results.history.history import History

    return History.load(path)
