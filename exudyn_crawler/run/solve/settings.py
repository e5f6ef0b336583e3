"""Exudyn's settings for a run."""

import math

from exudyn_crawler.case import Solver
from exudyn_crawler.model.engine import exu


def solver_settings(solver: Solver) -> "exu.SimulationSettings":
    """Exudyn's settings for a run; `set_times` gives it its times."""
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    # every factorization has the same pattern
    settings.linearSolver.reuseAnalyzedPattern = True
    time = settings.timeIntegration
    # a stage starts from the accelerations that the one before ended with
    time.generalizedAlpha.resetAccelerations = False
    time.adaptiveStepRecoverySteps = 1
    time.adaptiveStepRecoveryIterations = solver.maximum_iterations
    time.verboseMode = 0
    time.generalizedAlpha.spectralRadius = solver.spectral_radius
    newton = time.newton
    # one Jacobian a step, another where the iteration slows down
    newton.useModifiedNewton = True
    newton.modifiedNewtonJacUpdatePerStep = True
    newton.absoluteTolerance = solver.residual
    # the absolute tolerance alone decides: the first residual of a step is no measure
    newton.relativeTolerance = 1e-16
    newton.weightTolerancePerCoordinate = True
    newton.maxIterations = solver.maximum_iterations
    return settings


def set_times(
    settings: "exu.SimulationSettings", solver: Solver, start: float, end: float, quiet: bool = False
) -> None:
    """Put the times of a stage into Exudyn's settings; a quiet one takes longer steps."""
    time = settings.timeIntegration
    step = max(solver.step, solver.quiet_step) if quiet else solver.step
    time.startTime = start
    time.endTime = end
    time.numberOfSteps = max(1, math.ceil((end - start) / step - 1e-6))
    time.minimumStepSize = min(solver.minimum_step, end - start)
