"""Compiled functions that are cached on disk and notice changes of the functions that they call.

numba caches compiled code beside the source and compiles again when that one file changes. Code inlined from
other files would stay as it was, so that a cached function is stamped with all sources that it may consist
of.
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
    """Decorator that compiles a function and caches the result until one of the sources changes.

    Parameters
    ----------
    sources : Path
        Files or folders in which the function and all that it calls are.
    options :
        As of `numba.njit`.
    """
    stamp = source_digest(*sources)

    def compiled(function: Callable) -> Any:
        # the C address of a function, which is not needed, would take a fifth of the time to compile
        dispatcher = njit(cache=True, no_cfunc_wrapper=True, **options)(function)
        # LLVM asks Python for cached code; if an interrupt comes just then, it calls what is not there
        dispatcher.compile = interrupts_wait()(dispatcher.compile)
        # numba has no public way to add sources; without these attributes its own stamp stays
        cache: Any = getattr(dispatcher, "_cache", None)
        file = getattr(cache, "_cache_file", None)
        if file is not None:
            file._source_stamp = (file._source_stamp, stamp)
            cache.save_overload = _forgiving(cache.save_overload)
        return dispatcher

    return compiled


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


def _forgiving(save: Callable[..., None]) -> Callable[..., None]:
    """Save compiled code, which only saves time: a full disk must not end the run that compiled it."""

    def saved(*values: Any) -> None:
        with suppress(OSError):
            save(*values)

    return saved
