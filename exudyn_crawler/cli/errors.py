"""How a command tells of what went wrong."""

import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

from exudyn_crawler.errors import (
    ENDED_FROM_OUTSIDE,
    GOES_ON,
    INTERRUPTED,
    EquilibriumError,
    SimulationStopped,
)

OTHER = 1
BAD_INPUT = 2
STOPPED = 3

BAD_INPUT_ERRORS = (
    ValueError,
    FileNotFoundError,
    FileExistsError,
    NotADirectoryError,
    IsADirectoryError,
    PermissionError,
    BlockingIOError,
)


@contextmanager
def readable_errors(debug: bool = False) -> Iterator[None]:
    """Turn errors and warnings into readable lines, and errors into an exit code.

    Exits with 2 for bad input, 3 for a run that stopped early, 130 for an interrupt outside of a run and
    1 for all else, such as a full disk.

    Parameters
    ----------
    debug : bool
        Show the traceback first.
    """
    try:
        with _readable_warnings():
            yield
    except BrokenPipeError as error:
        # who reads has had enough, as head does; what Python still writes at its end must not fail again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(OTHER) from error
    except (Exception, KeyboardInterrupt) as error:
        if debug:
            import traceback

            traceback.print_exc()
        lines, code = _told(error)
        for line in lines:
            print(f"error: {line}", file=sys.stderr)
        raise SystemExit(code) from error


@contextmanager
def _readable_warnings() -> Iterator[None]:
    """Show each warning as a line of its own, without the place in the code."""

    def show(message: Warning | str, *_where: Any, **_how: Any) -> None:
        print(f"warning: {' '.join(str(message).split())}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def readable(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command's errors in a line each, with its option `debug` for the traceback."""

    @wraps(function)
    def told(*args: Any, **options: Any) -> None:
        with readable_errors(options.get("debug", False)):
            function(*args, **options)

    return told


def _interrupted(error: BaseException | None) -> bool:
    """Whether an interrupt led to an error, of which a library may have made another one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _told(error: BaseException) -> tuple[list[str], int]:
    """Lines that tell of an error, and the exit code."""
    if isinstance(error, SimulationStopped):
        how = f"; {GOES_ON}" if error.reason == INTERRUPTED else ""
        return [f"{error}; what there is was kept{how}"], STOPPED
    if _interrupted(error):
        return [f"{INTERRUPTED}; {GOES_ON}"], ENDED_FROM_OUTSIDE
    if isinstance(error, EquilibriumError):
        return [str(error)], STOPPED
    if isinstance(error, BAD_INPUT_ERRORS):
        return str(error).splitlines() or [repr(error)], BAD_INPUT
    if isinstance(error, OSError):
        return [" ".join(str(error).split())], OTHER
    told = " ".join(str(error).split())
    return [f"{type(error).__name__}: {told} (unexpected; --debug shows where)"], OTHER
