"""Compile functions as parts of their callers: types and code are found once, machine code within a kernel.

numba optimizes a function with all its callees and makes machine code of it before the caller takes the same
code again. A function five calls deep would be optimized five times. numba has no public means for this;
`trial` tries those that are used here.
"""

from collections.abc import Callable
from typing import Any

from numba import _dynfunc, njit
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass
from numba.core.typed_passes import NativeLowering


class LinkedCode(JITCodeLibrary):
    """Code of a function with all its callees, neither optimized nor compiled to machine code."""

    def _optimize_final_module(self) -> None:
        """Leave the optimization to the kernel."""

    def _finalize_final_module(self) -> None:
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=False)
class _Offer(LoweringPass):
    """Pass that lets callers find code without an address: numba's tables know it by an empty entry."""

    _name = "offer"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        function = state.cr.fndesc
        module = function.lookup_module()
        entry = _dynfunc.make_function(module, function.qualname, "", 0, state.cr.env, (state.library,))
        state["cr"] = state.cr._replace(cfunc=entry)
        state.targetctx.insert_user_function(entry, function, [state.library])
        return False


class LinkedCompiler(CompilerBase):
    """Compiler of linked functions, for `numba.njit(pipeline_class=...)`."""

    def define_pipelines(self) -> list[PassManager]:
        """Return numba's passes without code generation."""
        state = self.state
        state.flags.no_compile = True
        state.library = LinkedCode(state.targetctx.codegen(), state.func_id.func_qualname)
        passes = DefaultPassBuilder.define_nopython_pipeline(state)
        passes._finalized = False
        passes.add_pass_after(_Offer, NativeLowering)
        passes.finalize()
        return [passes]


def linked(function: Callable, allocates: bool, merged: bool) -> Any:
    """Compile a function for compiled callers alone; the options are those of `compiled.inner`."""
    ways_in = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    options = {"error_model": "numpy", "_nrt": allocates, "forceinline": merged}
    return njit(pipeline_class=LinkedCompiler, **ways_in, **options)(function)
