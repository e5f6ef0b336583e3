"""What every command line is: errors in a line each with exit codes, and commands that packages register.

A command is a function as Typer takes it, to which the option `--debug` is added; its options `out` and
`overwrite` are those of here. A case is a function without arguments that returns a `CaseFile`, to start from
with ``init --study NAME``. Neither is loaded before it is asked for, so that a package's module of commands
should import what is heavy in its functions; `docs/usage.md` shows how it registers them.
"""

import inspect
import os
import re
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from functools import wraps
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Annotated, Any

import typer

import exudyn_crawler as crawler
from exudyn_crawler import errors

RESULTS = Path("results")  # folder of the folders of runs and studies, where a command names no other

Run = Annotated[Path, typer.Argument(help="folder of a run, or its history (NetCDF)", metavar="RUN")]
Out = Annotated[Path, typer.Option(help="folder for the results")]
OfName = Annotated[
    Path | None,
    typer.Option("--out", help=f"folder of the results; {RESULTS}/NAME of the file, if not given"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace earlier results")]
Debug = Annotated[bool, typer.Option("--debug", help="show the traceback of an error")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="replace a value of the file, as terrain.spring_stiffness=1e7; repeatable"),
]


def run_folder(run: Path) -> Path:
    """Folder of a run, named itself or by a file in it; `NotADirectoryError` if there is neither."""
    if run.is_file():
        return run.parent
    if not run.is_dir():
        raise NotADirectoryError(f"no folder {run}")
    return run


def history_path(run: Path) -> Path:
    """History of a run, named itself or by its folder; `FileNotFoundError`, with those below, if none."""
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
    """History of a run."""
    return crawler.History.load(history_path(run))


def report_made(path: Path, what_now: str = "") -> None:
    """Say where a file is that was made of a run, and record it, so that overwriting the run removes it."""
    from exudyn_crawler.run.folder.record import note_file

    note_file(path)
    typer.echo(f"{path}{what_now}")


OTHER, BAD_INPUT, STOPPED = 1, 2, 3  # exit codes
OF_PATHS = FileNotFoundError, FileExistsError, NotADirectoryError, IsADirectoryError, PermissionError
BAD_INPUT_ERRORS = (ValueError, BlockingIOError, *OF_PATHS)


def readable(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command's errors and warnings in a line each, and the option `debug`, which shows tracebacks.

    Its exit code is 2 for bad input, 3 for a run that stopped early, 130 for an interrupt outside of a run
    and 1 for all else, such as a full disk.
    """

    def show(message: Warning | str, *_where: Any, **_how: Any) -> None:
        print(f"warning: {' '.join(str(message).split())}", file=sys.stderr)

    @wraps(function)
    def reporting(*args: Any, debug: bool = False, **options: Any) -> None:
        try:
            with warnings.catch_warnings():
                warnings.showwarning = show
                function(*args, **options)
        except BrokenPipeError as error:
            # who reads has had enough, as head does; what Python still writes at its end must not fail again
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise SystemExit(OTHER) from error
        except (Exception, KeyboardInterrupt) as error:
            if debug:
                traceback.print_exc()
            lines, code = _lines(error)
            for line in lines:
                print(f"error: {line}", file=sys.stderr)
            raise SystemExit(code) from error

    signature = inspect.signature(function)
    option = inspect.Parameter("debug", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Debug)
    parameters = [*signature.parameters.values(), option]
    reporting.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return reporting


def with_example(words: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Put an example of its words into the help of a command."""

    def described(function: Callable[..., None]) -> Callable[..., None]:
        function.__doc__ = f"{function.__doc__}\n\nExample: {words}"
        return function

    return described


def _interrupted(error: BaseException | None) -> bool:
    """Whether an interrupt led to an error, of which a library may have made another one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _lines(error: BaseException) -> tuple[list[str], int]:
    """Lines that report an error, and the exit code."""
    if isinstance(error, errors.SimulationStopped):
        how = f"; {errors.GOES_ON}" if error.reason == errors.INTERRUPTED else ""
        return [f"{error}; what was computed is in its folder{how}"], STOPPED
    if _interrupted(error):
        return [f"{errors.INTERRUPTED}; {errors.GOES_ON}"], errors.ENDED_FROM_OUTSIDE
    if isinstance(error, errors.EquilibriumError):
        return [str(error)], STOPPED
    if isinstance(error, BAD_INPUT_ERRORS):
        return str(error).splitlines() or [repr(error)], BAD_INPUT
    text = " ".join(str(error).split())
    of_system = isinstance(error, OSError)
    return [text if of_system else f"{type(error).__name__}: {text} (unexpected; --debug shows where)"], OTHER


COMMANDS, CASES = "exudyn_crawler.commands", "exudyn_crawler.cases"  # groups of what packages register


def registered(group: str) -> dict[str, EntryPoint]:
    """What installed packages register in a group, by name."""
    return {entry.name: entry for entry in entry_points(group=group)}


def study_case(name: str) -> "crawler.CaseFile":
    """Case that a study registers to start from; raises `ValueError` if there is no such study."""
    cases = registered(CASES)
    if name not in cases:
        raise ValueError(f"study must be of {sorted(cases)}, got {name!r}")
    return cases[name].load()()


class Commands(typer.core.TyperGroup):
    """Own commands and those that packages register, which are loaded when one of them is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands, those of this package first."""
        names = super().list_commands(ctx)
        return [*names, *(name for name in registered(COMMANDS) if name not in names)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Command of a name; None if there is none."""
        command = super().get_command(ctx, cmd_name)
        entry = registered(COMMANDS).get(cmd_name)
        return command if command is not None or entry is None else _command(entry)


def _command(entry: EntryPoint) -> Any:
    """Registered command; one whose package is broken fails when it is called, and alone."""
    try:
        return typer.main.get_command(_single(entry.load(), entry.name))
    except Exception as error:
        broken = error

    def fail() -> None:
        """Cannot be loaded."""
        raise broken

    any_words = {"ignore_unknown_options": True, "allow_extra_args": True}
    return typer.main.get_command(_single(fail, entry.name, any_words))


def _single(
    function: Callable[..., None], name: str | None = None, settings: dict[str, Any] | None = None
) -> typer.Typer:
    """Command line of one command."""
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command(name, rich_help_panel="Studies", context_settings=settings)(readable(function))
    return single


def run_script(reference: str) -> None:
    """Run a command, referred to as packages register it (``studies.commands:stress``), as a script."""
    call(_single(EntryPoint(reference, reference, COMMANDS).load()))


def call(commands: typer.Typer) -> None:
    """Call a command line; wrong words are reported in a line, a request to terminate ends it as Ctrl-C."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    for k, word in enumerate(sys.argv[1:]):
        # an empty path would be the folder that the command is called in
        if not word or re.fullmatch("--[a-z-]+=", word):
            got = word or f"{sys.argv[k]} ''"
            print(f"error: no value may be empty, got {got}; --help shows what is allowed", file=sys.stderr)
            sys.exit(BAD_INPUT)
    try:
        code = commands(standalone_mode=False) or 0
    except KeyboardInterrupt:
        code = errors.ENDED_FROM_OUTSIDE
    except typer.Abort:
        code = BAD_INPUT
    except Exception as error:
        # Typer's errors have no public class that all its versions share
        if not hasattr(error, "format_message"):
            raise
        if text := error.format_message():
            print(f"error: {' '.join(text.split())}; --help shows what is allowed", file=sys.stderr)
        code = BAD_INPUT
    # also what Typer makes of an interrupt while it reads the words
    if code == errors.ENDED_FROM_OUTSIDE:
        print(f"error: {errors.INTERRUPTED}; {errors.GOES_ON}", file=sys.stderr)
    sys.exit(code)
