"""Static equilibrium of track and terrain before t = 0."""

import exudyn as exu
import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.assembly import ConstrainedCoordinates
from exudyn_crawler.engine import System, build
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.parameters import Case

RESIDUAL = 1e-3
"""N, root mean square of the residual that ends the iteration: 1e-9 of a shoe's load."""


def static_equilibrium(case: Case) -> NDArray:
    """Coordinates of track and terrain at rest under their weights and the loads at t = 0.

    Returns
    -------
    array (coordinates,)
        As in `engine`: m and rad, from the places at t = 0 before settling.

    Raises
    ------
    EquilibriumError
        Where Newton's method finds none.
    """
    system = build(case, static=True)
    q = _first_guess(system)
    system.set_initial(q)
    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.staticSolver.useLoadFactor = False
    settings.staticSolver.verboseMode = 0
    newton = settings.staticSolver.newton
    newton.absoluteTolerance = RESIDUAL
    newton.relativeTolerance = 1e-16
    newton.weightTolerancePerCoordinate = True
    newton.maxIterations = 50
    try:
        system.mbs.SolveStatic(settings)
    except exu.SolverError as error:
        raise EquilibriumError(f"no static equilibrium of case {case.name!r} was found: {error}") from error
    return np.asarray(system.mbs.systemData.GetODE2Coordinates())


def _first_guess(system: System) -> NDArray:
    """Every unit sunk by its own weight and every shoe by its load into the ground there.

    Close enough for Newton's method, which does the rest.
    """
    case = system.case
    q = np.zeros(system.contact.size)
    shoes = q[: 6 * case.track.shoe_count].reshape(-1, 6)
    loads = case.loads.loads(0.0)[0] + case.shoe.mass * case.gravity
    law = case.contact
    penetration = (np.maximum(loads, 0.0) / law.stiffness) ** (1.0 / law.exponent)
    sag = case.terrain.unit_mass * case.gravity / case.terrain.heave_stiffness
    shoes[:, 2] = -sag - penetration
    terrain = q[shoes.size : shoes.size + system.contact.coordinates.size]
    if isinstance(system.contact.coordinates, ConstrainedCoordinates):
        terrain.reshape(-1, 6)[:, 2] = -sag
    else:
        # heave of all units by the same amount is a combination of the modes
        heave = system.contact.coordinates.modes.heave  # type: ignore[attr-defined]
        tilt = system.contact.coordinates.modes.tilt  # type: ignore[attr-defined]
        shapes = np.vstack((heave, tilt))
        wanted = np.concatenate((np.full(len(heave), -sag), np.zeros(len(tilt))))
        terrain[:] = np.linalg.lstsq(shapes, wanted, rcond=None)[0]
    return q
