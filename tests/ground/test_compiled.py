"""Decorators of compiled functions: who may call what they make."""

import re
import subprocess
import sys

import numpy as np
import pytest
from numba import njit, types
from numba.core.errors import NumbaError

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.linking import LinkedCode
from exudyn_crawler.model import equations
from fem import compiling

CALLED = """
from exudyn_crawler.model.bodies import write_angles
try:
    write_angles(1, 2)
except TypeError as error:
    print(error)
"""


@inner
def _twice(x: float) -> float:
    return 2.0 * x


@kernel
def once_more(x: float) -> float:
    """Call a function that Python may not call."""
    return _twice(x) + 1.0


def long(x: float) -> float:
    """Take longer than what the compiler makes part of its callers by itself."""
    y = x
    for k in range(3):
        y += np.sin(k * x) + np.cos(k + x) * np.exp(-y) + np.tan(k - x) / np.log(2.0 + k)
        y += np.sinh(k * y) + np.cosh(k + y) * np.arctan(-y) + np.tanh(k - y) / np.sqrt(2.0 + k)
        y -= np.sin(k * y) + np.cos(k + y) * np.exp(-x) + np.tan(k - y) / np.log(3.0 + k)
        y -= np.sinh(k * x) + np.cosh(k + x) * np.arctan(-x) + np.tanh(k - x) / np.sqrt(3.0 + k)
    return y


def new_row(count: int) -> float:
    """Make an array."""
    row = np.zeros(count)
    for k in range(count):
        row[k] = k * row[k - 1]
    return row.sum()


def code_of(function, *arguments):
    """Code that the compiler makes of a function for types of arguments."""
    dispatcher = getattr(function, "dispatcher", function)
    dispatcher.compile(arguments)
    # code that comes from a cache cannot be looked at
    dispatcher.recompile()
    return dispatcher.inspect_llvm(dispatcher.signatures[-1])


def entries(code):
    """What there is in code for Python and for C to call."""
    return set(re.findall(r"^define .*@(?:\"?_ZN7)?(cpython|cfunc)", code, re.MULTILINE))


def test_a_kernel_calls_what_python_may_not_call():
    assert once_more(3.0) == 7.0
    with pytest.raises(TypeError, match="_twice is for compiled callers alone; Python calls a kernel"):
        _twice(3.0)


def test_a_process_that_calls_what_it_may_not_goes_on():
    done = subprocess.run([sys.executable, "-c", CALLED], capture_output=True, text=True, check=True)
    assert done.stdout == "write_angles is for compiled callers alone; Python calls a kernel\n"


def test_a_compiled_function_is_not_stale_by_a_change_of_files_that_it_does_not_consist_of():
    files = {path.name for path in compiling.sources_of(equations.residual)}
    assert {
        "equations.py",
        "bodies.py",
        "wheels.py",
        "overlap.py",
        "blocks.py",
        "rectangle_motion.py",
    } <= files
    assert not {"build.py", "compiled_system.py", "case.py"} & files


def test_there_is_no_way_into_what_python_may_not_call():
    """A later numba that leaves the way in takes 20 s more to compile."""
    assert entries(code_of(once_more, types.float64)) == {"cpython", "cfunc"}
    assert entries(code_of(_twice, types.float64)) == set()


def test_machine_code_is_made_of_kernels_alone():
    """A later numba that makes it of the others, too, takes a fifth longer to compile."""
    once_more(3.0)
    (linked,) = _twice.dispatcher.overloads.values()
    assert isinstance(linked.library, LinkedCode)
    engine = linked.library.codegen._engine
    assert not engine.is_symbol_defined(linked.fndesc.mangled_name)
    (kernel_code,) = once_more.overloads.values()
    assert engine.is_symbol_defined(kernel_code.fndesc.mangled_name)


def test_what_makes_no_arrays_counts_no_references():
    """A later numba that counts all the same takes longer for a step, and would let this function pass."""
    with pytest.raises(NumbaError):
        code_of(inner(new_row), types.intp)
    assert "NRT_" in code_of(inner(new_row, allocates=True), types.intp)


@pytest.mark.parametrize("merged", [True, False])
def test_what_is_merged_is_part_of_its_callers(merged):
    callee = inner(long, merged=merged)

    @njit
    def calls(x):
        return callee(x) + callee(2.0 * x) + callee(3.0 * x)

    code = code_of(calls, types.float64)
    assert bool(re.search("call .*long", code)) is not merged
