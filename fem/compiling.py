"""Compiled functions that are cached on disk and notice changes of the functions that they call.

numba caches compiled code beside the source and compiles again when that one file changes. Code inlined from
other files would stay as it was, so that a cached function is stamped with all sources that it may consist
of.
"""

import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numba
from numba import njit
from numba.core.event import Event, Listener, install_listener

from fem.interrupts import interrupts_wait
from fem.sources import source_digest


def compiler(*sources: Path, **options: Any) -> Callable[[Callable], Any]:
    """Decorator that compiles a function and caches the result until one of the sources changes.

    Parameters
    ----------
    sources : Path
        Files or folders in which the function and all that it calls are.
    options :
        As of `numba.njit`.
    """
    stamp = source_digest(*sources)
    # the C address of a function, which few need, would take a fifth of the time to compile; a function that
    # says nothing about counts of references would take what its first caller says
    options = {"no_cfunc_wrapper": True, "_nrt": True} | options

    def compiled(function: Callable) -> Any:
        dispatcher = njit(cache=True, **options)(function)
        # numba has no public way to add sources
        cached: Any = getattr(dispatcher, "_cache", None)
        file: Any = getattr(cached, "_cache_file", None)
        kind: type = type(file)
        if _compares_stamps(kind):
            _add_stamp(file, stamp)
            cached.save_overload = _forgiving(cached.save_overload, cached.flush)
        else:
            dispatcher = njit(**options)(function)
        # LLVM asks Python for cached code; if an interrupt comes just then, it calls what is not there
        dispatcher.compile = interrupts_wait()(dispatcher.compile)
        return dispatcher

    return compiled


def _add_stamp(file: Any, stamp: str) -> None:
    """Let a file of numba's cache be valid for some sources only.

    The version is compared before anything else of the file is read, which may name types that are gone.
    """
    file._version = f"{file._version} {stamp}"


@cache
def _compares_stamps(kind: type) -> bool:
    """Whether a class of numba's, of the files of its cache, notices a change of what `_add_stamp` adds.

    Warns
    -----
    RuntimeWarning
        If it does not: code that was compiled from other sources would be taken for that of these.
    """
    try:
        with TemporaryDirectory() as folder:
            before, after = (kind(folder, "trial", 0.0) for _ in range(2))
            _add_stamp(before, "before")
            _add_stamp(after, "after")
            before.save("key", "code")
            works = before.load("key") == "code" and after.load("key") is None
    except OSError:
        works = True  # a full disk says nothing about numba
    except Exception:
        works = False
    if not works:
        warnings.warn(
            f"numba {numba.__version__} no longer stamps its cache as expected: every process compiles all "
            f"functions again, which takes minutes",
            RuntimeWarning,
            stacklevel=3,
        )
    return works


@contextmanager
def notify_compiling(functions: Collection[Any], notify: Callable[[], None]) -> Iterator[None]:
    """Call `notify` once if one of some compiled functions has to be compiled within the context."""
    with install_listener("numba:compile", _Once(functions, notify)):
        yield


class _Once(Listener):
    def __init__(self, functions: Collection[Any], notify: Callable[[], None]) -> None:
        self._left, self._notify = list(functions), notify

    def on_start(self, event: Event) -> None:
        if any(event.data["dispatcher"] is one for one in self._left):
            self._left = []
            self._notify()

    def on_end(self, event: Event) -> None:
        """Nothing happens at the end."""


def _forgiving(save: Callable[..., None], forget: Callable[[], None]) -> Callable[..., None]:
    """Save compiled code, which only saves time: a full disk must not end the run that compiled it."""

    def saved(*values: Any) -> None:
        try:
            save(*values)
        except OSError:
            # numba writes the index first, whose name for the code may be that of a file of earlier sources
            with suppress(OSError):
                forget()

    return saved
