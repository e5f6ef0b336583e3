"""Compiled functions that are kept on disk and notice when a function that they call was changed.

numba keeps compiled code beside the source and compiles anew when that one file changes. Code that it has
inlined from other files would stay as it was, so a kept function is stamped with all sources that it may be
made of.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.event import Event, Listener, install_listener

from fem.interrupts import interrupts_wait
from fem.sources import source_digest


def compiler(*sources: Path, **options: Any) -> Callable[[Callable], Any]:
    """Decorator that compiles a function and keeps the result until one of the sources changes.

    Parameters
    ----------
    sources : Path
        Files or folders in which the function and all that it calls are.
    options :
        As of `numba.njit`.
    """
    stamp = source_digest(*sources)

    def compiled(function: Callable) -> Any:
        # nobody takes the C address of a function, which would be a fifth of the time to compile
        dispatcher = njit(cache=True, no_cfunc_wrapper=True, **options)(function)
        # LLVM asks Python for kept code; where an interrupt comes just then, it calls what is not there
        dispatcher.compile = interrupts_wait()(dispatcher.compile)
        # numba has no public way to say what a function is made of; without the attributes it keeps its own
        cache: Any = getattr(dispatcher, "_cache", None)
        kept = getattr(cache, "_cache_file", None)
        if kept is not None:
            kept._source_stamp = (kept._source_stamp, stamp)
            cache.save_overload = _forgiving(cache.save_overload)
        return dispatcher

    return compiled


@contextmanager
def told_of_compiling(functions: Collection[Any], tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once when one of some compiled functions has to be compiled meanwhile."""
    with install_listener("numba:compile", _Once(functions, tell)):
        yield


class _Once(Listener):
    def __init__(self, functions: Collection[Any], tell: Callable[[], None]) -> None:
        self._left, self._tell = list(functions), tell

    def on_start(self, event: Event) -> None:
        if any(event.data["dispatcher"] is one for one in self._left):
            self._left = []
            self._tell()

    def on_end(self, event: Event) -> None:
        """Nothing is told of the end."""


def _forgiving(save: Callable[..., None]) -> Callable[..., None]:
    """Keeping compiled code only saves time: a full disk must not end the run that compiled it."""

    def saved(*values: Any) -> None:
        with suppress(OSError):
            save(*values)

    return saved
