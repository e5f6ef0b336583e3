"""Compile the equations before a run, in two processes.

The matrix does not call the residual, so that both are compiled at the same time; a step calls both and finds
them cached. This takes three quarters of the time.
"""

import os
import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
from numba import typeof

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model import elimination, equations, gear
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from fem.compiling import notify_compiling

Call = tuple[Any, tuple]
"""Compiled function and its arguments."""


@cache
def compile_equations() -> None:
    """Compile residual and matrix, unless they are cached; once for a process, and the same for all cases.

    If the second process fails, for example because a disk stores nothing, the matrix is compiled when it is
    called.
    """
    begun: list[subprocess.Popen] = []
    with notify_compiling([equations.residual], lambda: begun.append(_beside())):
        _compile("residual")
    for process in begun:
        process.wait()


def compile_matrix() -> None:
    """Compile the matrix, its elimination and the contacts of a history."""
    system = _compile("matrix")
    none = np.zeros((1, system.layout.coordinate_count))
    system.contact.results(none, none)


def calls_of(system: CompiledSystem) -> dict[str, list[Call]]:
    """Return compiled functions with a run's arguments for the system, by their part of the equations."""
    residual, values = system.scratch
    inputs = system.inputs(0.0)
    weights = Weights(0.0, 0.0, 1.0, False, 1.0)
    fronts = system.tables.fronts
    state = np.zeros((3, system.layout.coordinate_count))
    state[0] = system.first_guess()
    multipliers = np.zeros(system.tables.multipliers)
    forces = gear.GearForces.allocate(1, system.layout.shoes, 0, system.work)
    no_shoes = np.zeros(0, dtype=np.int64)
    return {
        "residual": [
            (equations.residual, (system.block, state, multipliers, inputs, weights, residual)),
            (
                gear.write_gear_forces,
                (system.block, state[:1].copy(), state[1:2].copy(), no_shoes, forces),
            ),
        ],
        "matrix": [
            (equations.matrix, (system.block, weights, values)),
            (elimination.eliminate, (fronts, values)),
            (elimination.solve, (fronts, values, residual)),
        ],
    }


def _compile(part: str) -> CompiledSystem:
    """Compile a part of the equations for a case, and return its system."""
    system = compiled_system(Case.translation())
    for function, arguments in calls_of(system)[part]:
        function.compile(tuple(typeof(argument) for argument in arguments))
    return system


def _beside() -> subprocess.Popen:
    """Start a process that compiles the matrix, and return it.

    No fork, because threads do not survive it, and no second run of the script.
    """
    return subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import compile_matrix; compile_matrix()"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
