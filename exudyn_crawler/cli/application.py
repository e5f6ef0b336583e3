"""Common behaviour of all commands: example and `--debug` in help, errors in a line each, exit codes.

Commands import heavy modules within their functions, so that help appears at once.
"""

import inspect
import os
import re
import signal
import sys
import tomllib
import traceback
import warnings
from collections.abc import Callable, Iterable
from functools import partial, wraps
from importlib import resources
from importlib.metadata import EntryPoints, entry_points, requires
from importlib.util import find_spec
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any

import typer

import exudyn_crawler as crawler
from exudyn_crawler import errors

RESULTS = Path("results")  # default folder of the folders of runs and studies

Run = Annotated[Path, typer.Argument(help="folder of a run, or its history (NetCDF)", metavar="RUN")]
Out = Annotated[Path, typer.Option(help="folder for the results")]
OfName = Annotated[
    Path | None,
    typer.Option("--out", help=f"folder for the results; default: {RESULTS}/NAME of the file"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace earlier results")]
Debug = Annotated[bool, typer.Option("--debug", help="show the traceback of an error")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="replace a value, such as terrain.spring_stiffness=1e7; repeatable"),
]


def needs(what: str, modules: Iterable[str], extra: str) -> str:
    """Return a line with the missing modules of an extra, and the command that installs them."""
    return f"{what} must have {', '.join(modules)}, of the extra {extra!r}: {_installing(extra)}"


def require_sweeps() -> None:
    """Raise ValueError if a module of the extra `sweep` is missing."""
    if missing := [module for module in SWEEPS if find_spec(module) is None]:
        raise ValueError(needs("sweeps", missing, "sweep"))


def _installing(extra: str) -> str:
    """Return the command that adds what is missing to an installed wheel or checkout, in any shell.

    pip keeps the installed package itself, and looks for it nowhere.
    """
    return f'pip install "{DISTRIBUTION}{extra and f"[{extra}]"}"'


def run_folder(run: Path) -> Path:
    """Return the folder of a run, given itself or as a file in it.

    Raises `NotADirectoryError` if there is neither.
    """
    if run.is_file():
        return run.parent
    if not run.is_dir():
        raise NotADirectoryError(f"there is no folder {run}")
    return run


def history_path(run: Path) -> Path:
    """Return the history of a run, given itself or by its folder.

    Raises `FileNotFoundError` if there is none; the message names histories below the folder.
    """
    if run.is_file():
        return run
    if not run.is_dir():
        raise FileNotFoundError(f"no history at {run}")
    from exudyn_crawler.run.folder.record import HISTORY, STOPPED_HISTORY

    for name in (HISTORY, STOPPED_HISTORY):
        if (run / name).is_file():
            return run / name
    below = sorted(str(path.parent) for path in run.glob(f"*/{HISTORY}"))
    hint = f"; name one of {', '.join(below)}" if below else ""
    raise FileNotFoundError(f"no history at {run / HISTORY}{hint}")


def loaded(run: Path) -> "crawler.History":
    """Return the history of a run."""
    return crawler.History.load(history_path(run))


def report_made(path: Path, what_now: str = "") -> None:
    """Report a file made of a run, and record it, so that overwriting the run removes it."""
    from exudyn_crawler.run.folder.record import note_file

    note_file(path)
    typer.echo(f"{path}{what_now}")


OTHER, BAD_INPUT, STOPPED = 1, 2, 3  # exit codes
OF_PATHS = FileNotFoundError, FileExistsError, NotADirectoryError, IsADirectoryError, PermissionError
BAD_INPUT_ERRORS = (ValueError, BlockingIOError, *OF_PATHS)
DISTRIBUTION = "exudyn-crawler"
SWEEPS = ("distributed", "SALib")
"""Modules of the extra `sweep`."""
SUMS = ("all", "dev")
"""Extras that contain others."""
OF_EXTRA = re.compile(r"extra == ['\"]([\w-]+)['\"]")
CASES = "exudyn_crawler.cases"  # group of entry points: functions that return a `CaseFile` to start from


def study_cases() -> EntryPoints:
    """Return the cases of studies to start from, by name."""
    return entry_points(group=CASES)


def study_files() -> dict[str, Path]:
    """Return the files of studies to start from (cases, duties, sweeps) by name, from their packages."""
    packages = {point.module.partition(".")[0] for point in study_cases()}
    folders = [Path(str(resources.files(package))) for package in packages]
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.toml"))}


def is_case(file: Path) -> bool:
    """Return True if a file of parameters is a case file."""
    from exudyn_crawler.settings import fields

    content = tomllib.loads(file.read_text(encoding="utf-8"))
    return content.keys() <= {fields.BASE, *fields.file_fields(crawler.CaseFile)}


def study_names(cases: bool = False) -> list[str]:
    """Return the names of all studies to start from, or of those with `cases` alone."""
    files = [name for name, file in study_files().items() if not cases or is_case(file)]
    return sorted({*study_cases().names, *files})


def study_case(name: str) -> "crawler.CaseFile":
    """Return the case of a study to start from.

    Raises `ValueError` if there is no such study, or it has no case.
    """
    if name in study_cases().names:
        return study_cases()[name].load()()
    if name in study_names(cases=True):
        return crawler.read_case(study_files()[name])
    raise ValueError(f"study must be one of {', '.join(study_names(cases=True))}, got {name!r}")


def file_named(file: Path | None) -> Path | None:
    """Return a given file.

    Raises FileNotFoundError for the name of a machine or study to start from; the message shows the command.
    """
    # a suffix means a file, whose reader reports that it is missing
    if file is None or file.suffix or os.path.exists(file):
        return file
    name = str(file)
    if os.path.exists(f"{name}.toml"):
        raise FileNotFoundError(f"there is no file {file}; did you mean {name}.toml?")
    from exudyn_crawler.machines.datasheet import library

    kinds = {"machine of the library": ("machine", [*library.machines()])}
    kinds["study"] = ("study", study_names())
    for kind, (option, names) in kinds.items():
        by_folded = {known.casefold(): known for known in names}
        if known := by_folded.get(name.casefold()):
            begin = f"exudyn-crawler init my_{known} --{option} {known}"
            raise FileNotFoundError(
                f"there is no file {file}; {known} is a {kind}: begin from it with {begin}, which writes "
                f"my_{known}.toml"
            )
    return file


file_argument = partial(typer.Argument, callback=file_named)
"""Argument of a command for a file of parameters."""


def command(app: typer.Typer, example: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register a function as a command, with an example in its help and the option `--debug`."""

    def register(function: Callable[..., None]) -> Callable[..., None]:
        @wraps(function)
        def run(debug: bool = False, **options: Any) -> None:
            try:
                function(**options)
            except (Exception, KeyboardInterrupt):
                if debug:
                    traceback.print_exc()
                raise

        signature = inspect.signature(function)
        option = inspect.Parameter("debug", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Debug)
        parameters = [*signature.parameters.values(), option]
        run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        return app.command(epilog=f"Example: {example}")(run)

    return register


def call(app: typer.Typer) -> None:
    """Call a command line; errors and warnings are one line each, and a request to terminate acts as Ctrl-C.

    The exit code is 2 for bad input, 3 for a run that stopped early or a sweep without an answer, 130 for an
    interrupt outside of a run, and 1 for all other errors, such as a full disk.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # a console or pipe of Windows has not all letters that a name may have
            stream.reconfigure(errors="backslashreplace")
    lines: list[str] = []
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            # an empty path would mean the current folder
            if any(not word or re.fullmatch("--[a-z-]+=", word) for word in sys.argv[1:]):
                raise ValueError(f"no value may be empty, got {sys.argv[1:]}")
            code = app(standalone_mode=False) or 0
            # Typer turns an interrupt into an exit code
            if code == errors.ENDED_FROM_OUTSIDE:
                raise KeyboardInterrupt
        except (Exception, KeyboardInterrupt) as error:
            lines, code = _lines(error)
    for line in lines:
        print(f"error: {errors.cut_line(line)}", file=sys.stderr)
    sys.exit(code)


def _show_warning(message: Warning | str, *_where: Any, **_how: Any) -> None:
    print(f"warning: {errors.cut_line(' '.join(str(message).split()))}", file=sys.stderr)


def _lines(error: BaseException) -> tuple[list[str], int]:
    """Return the lines that report an error, and the exit code."""
    if isinstance(error, errors.SimulationStopped):
        how = f"; {errors.GOES_ON}" if error.reason == errors.INTERRUPTED else ""
        return [f"{error}; what was computed is in its folder{how}"], STOPPED
    if _interrupted(error):
        return [f"{errors.INTERRUPTED}; {errors.GOES_ON}"], errors.ENDED_FROM_OUTSIDE
    if isinstance(error, errors.EquilibriumError | errors.NoAnswerError):
        return [str(error)], STOPPED
    if isinstance(error, BAD_INPUT_ERRORS):
        return str(error).splitlines() or [repr(error)], BAD_INPUT
    # Typer's errors share no public class across its versions
    if hasattr(error, "format_message"):
        words = " ".join(error.format_message().split())
        return [f"{words}; --help shows what is allowed"] if words else [], BAD_INPUT
    if isinstance(error, ModuleNotFoundError) and (missing := _missing(error)):
        return [missing], BAD_INPUT
    text = " ".join(str(error).split())
    of_system = isinstance(error, OSError)
    return [text if of_system else f"{type(error).__name__}: {text} (unexpected; --debug shows where)"], OTHER


def _missing(error: ModuleNotFoundError) -> str:
    """Return the command that installs a missing package; empty for a module missing in an installed one."""
    if "pip install" in str(error):
        return str(error)
    package = (error.name or "").partition(".")[0]
    if not package or find_spec(package) is not None:
        return ""
    lines = [line for line in requires(DISTRIBUTION) or () if line.lower().startswith(package.lower())]
    extras = [found[1] for line in lines if (found := OF_EXTRA.search(line)) and found[1] not in SUMS]
    return f"the package {package} is not installed: {_installing(extras[0] if extras else '')}"


def _interrupted(error: BaseException | None) -> bool:
    """Return True if an interrupt caused an error, which a library may have replaced by another one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
