"""The multibody system of a case, in the formulation that the case asks for, compiled in two processes.

The matrix does not call the residual, so that both are compiled at the same time; a step, which calls
both, finds them cached. That takes three quarters of the time.
"""

import os
import subprocess
import sys
from functools import cache

import numpy as np
from numba import typeof

from exudyn_crawler.case import Case
from exudyn_crawler.model import compiled_system, equations
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.track_system import TrackSystem
from fem.compiling import notify_compiling


def track_system(case: Case) -> TrackSystem:
    """Build the multibody system of a case."""
    return compiled_system.compiled_system(case) if case.is_compiled else ExudynSystem(case)


@cache
def compile_equations() -> None:
    """Compile residual and matrix, unless they are cached; once a process, and the same for all cases.

    What fails beside this process, such as a disk that stores nothing, is compiled when it is called.
    """
    begun: list[subprocess.Popen] = []
    with notify_compiling([equations.residual], lambda: begun.append(_beside())):
        _compile("residual")
    for process in begun:
        process.wait()


def compile_matrix() -> None:
    """Compile the matrix, its elimination and the contacts that a history keeps."""
    system = _compile("matrix")
    none = np.zeros(system.layout.coordinate_count)
    system.contact.results(none, none)


def _compile(part: str) -> compiled_system.CompiledSystem:
    """System of a case, with a part of its equations compiled."""
    system = compiled_system.compiled_system(Case.translation())
    for function, arguments in system.calls()[part]:
        function.compile(tuple(typeof(one) for one in arguments))
    return system


def _beside() -> subprocess.Popen:
    """Process that compiles the matrix; no fork, which threads do not survive, and no script run anew."""
    return subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import compile_matrix; compile_matrix()"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
