"""The multibody system of a case, in the formulation that the case asks for, compiled in two processes.

The matrix does not call the residual, so that both are compiled at the same time; a step, which calls
both, finds them cached. That takes three quarters of the time.
"""

import os
import subprocess
import sys
from collections.abc import Callable
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


KINDS: dict[str, Callable[[], Case]] = {
    "dragged": Case.translation,
    "rolled": Case.rolled,
    "closed": Case.closed,
}
"""Cases whose equations are compiled apart: sizes and numbers are all that others differ in."""


def kind_of(case: Case) -> str:
    """Which of `KINDS` a case is of."""
    if case.is_closed:
        return "closed"
    return "rolled" if case.is_rolled else "dragged"


@cache
def compile_equations(kind: str) -> None:
    """Compile residual and matrix of a kind of cases, unless they are cached; once a process.

    What fails beside this process, such as a disk that stores nothing, is compiled when it is called.
    """
    begun: list[subprocess.Popen] = []
    with notify_compiling([equations.residual], lambda: begun.append(_beside(kind))):
        _compile(kind, "residual")
    for process in begun:
        process.wait()


def compile_matrix(kind: str) -> None:
    """Compile the matrix, its elimination and the contacts that a history keeps."""
    system = _compile(kind, "matrix")
    none = np.zeros(system.layout.coordinate_count)
    system.contact.results(none, none)


def _compile(kind: str, part: str) -> compiled_system.CompiledSystem:
    """System of a case of a kind, with a part of its equations compiled."""
    system = compiled_system.compiled_system(KINDS[kind]())
    for function, arguments in system.calls()[part]:
        function.compile(tuple(typeof(one) for one in arguments))
    return system


def _beside(kind: str) -> subprocess.Popen:
    """Process that compiles the matrix; no fork, which threads do not survive, and no script run anew."""
    return subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import compile_matrix; compile_matrix({kind!r})"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
