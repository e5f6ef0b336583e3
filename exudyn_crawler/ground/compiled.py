"""Decorators of compiled functions; their names say who may call what they make.

A `kernel` Python may call, an `inner` function compiled callers alone, an `inlined` one is made part of each
of its callers. All divide by zero as IEEE says, in place of an exception, and take sums in their order: where
the compiler may choose, processes that compile apart from each other get other last digits.

Every literal integer among a call's arguments compiles a function once more, so that counts that are handed
on start as ``np.int64(0)``.
"""

import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit

from fem import sources
from fem.compiling import compiler

GROUND = Path(__file__).parent
HOUSE = GROUND.parent
SOURCES = (GROUND, sources.FEM / "compiling.py", sources.FEM / "patches.py")
"""Compiled functions of this room and what they call are here; the rest of `fem` does not make them stale."""


def kernel(function: Callable) -> Any:
    """Compile a function that Python may call."""
    return _compiler(_room(function))(function)


def inner(
    function: Callable | None = None,
    *,
    allocates: bool = False,
    merged: bool = False,
    cached: bool = True,
) -> Any:
    """Compile a function for compiled callers alone.

    What Python would need to call it, and numba takes long to make, is left out, and calling it from Python
    ends the process. Without `allocates` there are no counts of references to arrays, which took a tenth of a
    step: such a function makes no array, gives none back, not even a view, and calls none that gives one
    back. One that is `merged` is made part of its callers, where handing over tables would take longer than
    what it does. One that meets a soil law is not `cached`: it would outlive a change of the law, whose file
    may be anywhere. As part of its entry alone, the compiler also knows how far apart the numbers of points
    are, and takes several points at once.
    """

    def compile_inner(function: Callable) -> Any:
        options = {} if allocates else {"_nrt": False}
        if merged:
            options["forceinline"] = True
        if not cached:
            return njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(
                function
            )
        return _compiler(_room(function), no_cpython_wrapper=True, **options)(function)

    return compile_inner if function is None else compile_inner(function)


def inlined(function: Callable) -> Any:
    """Compile a function within its callers alone: it gives a view, or one or two functions call it."""
    return _compiler(_room(function), inline="always")(function)


def _room(function: Callable) -> Path:
    """Folder of the sources of a function's room."""
    path = Path(inspect.getfile(function))
    if HOUSE not in path.parents:
        return path.parent
    return HOUSE / path.relative_to(HOUSE).parts[0]


@cache
def _compiler(room: Path, **options: Any) -> Callable[[Callable], Any]:
    return compiler(*{*SOURCES, room}, error_model="numpy", **options)
