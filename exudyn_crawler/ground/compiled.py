"""Decorators of compiled functions; their names say who may call what they make.

A `kernel` Python may call, an `inner` function compiled callers alone, an `inlined` one is made part of each
of its callers. All divide by zero as IEEE says, in place of an exception, and take sums in their order: where
the compiler may choose, processes that compile apart from each other get other last digits.

Every literal integer among a call's arguments compiles a function once more, so that counts that are handed
on start as ``np.int64(0)``.
"""

from collections.abc import Callable
from functools import update_wrapper
from typing import Any

from numba import njit, types

from exudyn_crawler.ground.linking import LinkedCompiler
from fem.compiling import compiler

kernel = compiler(error_model="numpy")
"""Compiles a function that Python may call."""

inlined = compiler(error_model="numpy", inline="always")
"""Compiles a function within its callers alone: it gives a view, or one or two functions call it."""


class CompiledOnly:
    """Function for compiled callers, who find its dispatcher; to Python it is an error."""

    def __init__(self, dispatcher: Any) -> None:
        update_wrapper(self, dispatcher.py_func)
        self.py_func = dispatcher.py_func
        self.targetoptions = dispatcher.targetoptions
        self._dispatcher = dispatcher

    @property
    def _numba_type_(self) -> types.Dispatcher:
        return self._dispatcher._numba_type_

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Refuse a call: without what Python would need for it the process would end."""
        raise TypeError(f"{self.py_func.__name__} is for compiled callers alone; Python calls a kernel")


def inner(function: Callable | None = None, *, allocates: bool = False, merged: bool = False) -> Any:
    """Compile a function for compiled callers alone, as part of each kernel that calls it (`linking`).

    Without `allocates` there are no counts of references to arrays, which took a tenth of a step: such a
    function makes no array, gives none back, not even a view, and calls none that gives one back. One that is
    `merged` is made part of its callers, where handing over tables would take longer than what it does.
    """

    def compile_inner(function: Callable) -> CompiledOnly:
        ways_in = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        options = {"error_model": "numpy", "_nrt": allocates, "forceinline": merged}
        return CompiledOnly(njit(pipeline_class=LinkedCompiler, **ways_in, **options)(function))

    return compile_inner if function is None else compile_inner(function)
