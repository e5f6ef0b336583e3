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
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.model.equations import residual
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.track_system import TrackSystem
from fem.compiling import notify_compiling

EQUATIONS = (residual,)
"""Compiled functions of which every run needs one; each is made of many others."""


def track_system(case: Case) -> TrackSystem:
    """Build the multibody system of a case."""
    return compiled_system(case) if case.is_compiled else ExudynSystem(case)


@cache
def compile_equations(rolled: bool) -> None:
    """Compile residual and matrix, with or without treads, unless they are cached; once a process.

    What fails beside this process, such as a disk that stores nothing, is compiled when it is called.
    """
    begun: list[subprocess.Popen] = []
    with notify_compiling([residual], lambda: begun.append(_beside(rolled))):
        _compile(_any_system(rolled), "residual")
    for process in begun:
        process.wait()


def compile_matrix(rolled: bool) -> None:
    """Compile the matrix, its elimination and the contacts that a history keeps."""
    system = _any_system(rolled)
    _compile(system, "matrix")
    none = np.zeros(system.layout.coordinate_count)
    system.contact.results(none, none)


def _any_system(rolled: bool) -> CompiledSystem:
    """System of a case; sizes and numbers are all that others differ in."""
    return compiled_system(Case.rolled() if rolled else Case.translation())


def _compile(system: CompiledSystem, part: str) -> None:
    for function, arguments in system.calls()[part]:
        function.compile(tuple(typeof(one) for one in arguments))


def _beside(rolled: bool) -> subprocess.Popen:
    """Process that compiles the matrix; no fork, which threads do not survive, and no script run anew."""
    return subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import compile_matrix; compile_matrix({rolled})"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
