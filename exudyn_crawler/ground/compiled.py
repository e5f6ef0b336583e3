"""Decorators of compiled functions; each name says which callers are allowed.

Python may call a `kernel`; only compiled functions may call an `inner` function; an `inlined` function
becomes part of each of its callers. All divide by zero as IEEE 754 says, without an exception, and keep the
order of sums. If the compiler chose the order, processes that compile separately would differ in the last
digits.

Every literal integer among a call's arguments compiles a function once more. Counts that are passed on
therefore start as ``np.int64(0)``.
"""

from collections.abc import Callable
from functools import update_wrapper
from typing import Any

from numba import njit, types

from exudyn_crawler.ground.linking import LinkedCompiler
from fem.compiling import compiler

kernel = compiler(error_model="numpy")
"""Decorator of a function that Python may call."""

inlined = compiler(error_model="numpy", inline="always")
"""Decorator of a function that is compiled only within its callers: it returns a view or has one or two
callers."""


class CompiledOnly:
    """Function for compiled callers, which find its dispatcher; a call from Python is an error."""

    def __init__(self, dispatcher: Any) -> None:
        update_wrapper(self, dispatcher.py_func)
        self.py_func = dispatcher.py_func
        self.targetoptions = dispatcher.targetoptions
        self._dispatcher = dispatcher

    @property
    def _numba_type_(self) -> types.Dispatcher:
        return self._dispatcher._numba_type_

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Raise `TypeError`: without the wrapper for Python a call would end the process."""
        raise TypeError(f"{self.py_func.__name__} is for compiled callers alone; Python calls a kernel")


def inner(function: Callable | None = None, *, allocates: bool = False, merged: bool = False) -> Any:
    """Compile a function for compiled callers alone, as part of each kernel that calls it (`linking`).

    Without `allocates` numba does not count references to arrays, which took a tenth of a step. Such a
    function makes no array, returns none, not even a view, and calls no function that returns one. A `merged`
    function becomes part of its callers, because passing tables would take longer than the function itself.
    """

    def compile_inner(function: Callable) -> CompiledOnly:
        ways_in = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        options = {"error_model": "numpy", "_nrt": allocates, "forceinline": merged}
        return CompiledOnly(njit(pipeline_class=LinkedCompiler, **ways_in, **options)(function))

    return compile_inner if function is None else compile_inner(function)
