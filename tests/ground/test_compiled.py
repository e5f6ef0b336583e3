"""Decorators of compiled functions: who may call what they make."""

import subprocess
import sys

import pytest

from exudyn_crawler.ground.compiled import inner, kernel
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


def test_a_kernel_calls_what_python_may_not_call():
    assert once_more(3.0) == 7.0
    with pytest.raises(TypeError, match="_twice is for compiled callers alone; Python calls a kernel"):
        _twice(3.0)


def test_a_process_that_calls_what_it_may_not_goes_on():
    done = subprocess.run([sys.executable, "-c", CALLED], capture_output=True, text=True, check=True)
    assert done.stdout == "write_angles is for compiled callers alone; Python calls a kernel\n"


def test_a_compiled_function_is_not_stale_by_a_change_of_files_that_it_does_not_consist_of():
    files = {path.name for path in compiling.sources_of(equations.residual)}
    assert {"equations.py", "bodies.py", "wheels.py", "overlap.py", "packed.py", "patches.py"} <= files
    assert not {"build.py", "compiled_system.py", "case.py"} & files
