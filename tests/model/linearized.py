"""Matrices that Exudyn assembles at a system's initial state, for tests that count and compare."""

from dataclasses import dataclass

import exudyn as exu
import numpy as np


@dataclass
class Matrices:
    """Mass, stiffness and damping (coordinates, coordinates) and the constraints' Jacobian.

    `position` and `velocity` are derivatives of the equations (equations, coordinates) by coordinates and
    rates; `dummy` tells the equations that only say that a multiplier is zero.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    dummy: np.ndarray


def linearized(mbs: "exu.MainSystem") -> Matrices:
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense
    solver = exu.MainSolverStatic()
    solver.InitializeSolver(mbs, settings)
    n = solver.GetODE2size()
    solver.ComputeMassMatrix(mbs)
    mass = np.array(solver.GetSystemMassMatrix())[:n, :n]
    blocks = []
    for by_position, by_rate in ((1.0, 0.0), (0.0, 1.0)):
        solver.ComputeJacobianODE2RHS(
            mbs, scalarFactor_ODE2=-by_position, scalarFactor_ODE2_t=-by_rate, scalarFactor_ODE1=0
        )
        solver.ComputeJacobianAE(
            mbs,
            scalarFactor_ODE2=by_position,
            scalarFactor_ODE2_t=by_rate,
            scalarFactor_ODE1=0.0,
            velocityLevel=False,
        )
        blocks.append(np.array(solver.GetSystemJacobian()))
    solver.FinalizeSolver(mbs, settings)
    at_position, at_rate = blocks
    return Matrices(
        mass=mass,
        stiffness=at_position[:n, :n],
        damping=at_rate[:n, :n],
        position=at_position[n:, :n],
        velocity=at_rate[n:, :n],
        dummy=np.any(at_position[n:, n:] != 0.0, axis=1),
    )
