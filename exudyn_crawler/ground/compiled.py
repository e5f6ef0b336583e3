"""Decorators of compiled functions; each name says which callers are allowed.

Python may call a `kernel`; only compiled functions may call an `inner` function; an `inlined` function
becomes part of each of its callers. All divide by zero as IEEE 754 says, without an exception, and keep the
order of sums. If the compiler chose the order, processes that compile separately would differ in the last
digits.

Every literal integer among a call's arguments compiles a function once more. Counts that are passed on
therefore start as ``np.int64(0)``.
"""

import warnings
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from typing import Any

import numba
from numba import njit, typeof, types
from numba.extending import typeof_impl

from fem.compiling import compiler

kernel = compiler(error_model="numpy")
"""Decorator of a function that Python may call."""

inlined = compiler(error_model="numpy", inline="always")
"""Decorator of a function that is compiled only within its callers: it returns a view or has one or two
callers."""


@cache
def internals_work() -> bool:
    """Return True if numba's internals do what `linking` and `blocks` need.

    Without them functions are compiled by plain `numba.njit`, with the same results.

    Warns
    -----
    RuntimeWarning
        If they do not, once in a process.
    """
    try:
        from exudyn_crawler.ground import trial

        work = trial.passes()
    except Exception:  # a later numba may lack a name, or fail in any other way
        work = False
    if not work:
        warnings.warn(
            f"numba {numba.__version__} has other internals than expected: results stay the same, but the "
            f"first run compiles minutes longer, and all runs are slower; a numba in the range of this "
            f"package's requirements avoids this",
            RuntimeWarning,
            stacklevel=2,
        )
    return work


class CompiledOnly:
    """Function for compiled callers, which find its dispatcher; a call from Python is an error."""

    def __init__(self, function: Callable, allocates: bool, merged: bool) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._options = {"allocates": allocates, "merged": merged}

    @cached_property
    def dispatcher(self) -> Any:
        """Dispatcher of numba; made when a caller is compiled or loaded, since the trial of it takes time."""
        if not internals_work():
            return njit(error_model="numpy")(self.py_func)
        from exudyn_crawler.ground.linking import linked

        return linked(self.py_func, **self._options)

    @property
    def targetoptions(self) -> dict[str, Any]:
        """Options of the compiler."""
        return self.dispatcher.targetoptions

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Raise `TypeError`: without the wrapper for Python a call would end the process."""
        raise TypeError(f"{self.py_func.__name__} is for compiled callers alone; Python calls a kernel")


@typeof_impl.register(CompiledOnly)
def _type_of(function: CompiledOnly, _context: Any) -> types.Type:
    return typeof(function.dispatcher)


def inner(function: Callable | None = None, *, allocates: bool = False, merged: bool = False) -> Any:
    """Compile a function for compiled callers alone, as part of each kernel that calls it (`linking`).

    Without `allocates` numba does not count references to arrays, which took a tenth of a step. Such a
    function makes no array, returns none, not even a view, and calls no function that returns one. A `merged`
    function becomes part of its callers, because passing tables would take longer than the function itself.
    """

    def compile_inner(function: Callable) -> CompiledOnly:
        return CompiledOnly(function, allocates, merged)

    return compile_inner if function is None else compile_inner(function)
