"""A case in both formulations, at any state, and matrices that Exudyn assembles."""

from contextlib import contextmanager
from typing import NamedTuple

import exudyn as exu
import numpy as np

from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.ground.rows import NO_DERIVATIVES, Weights
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.equations import matrix
from exudyn_crawler.run.solve.equilibrium import static_equilibrium

FORCE_SCALE = 1e6
"""N, of multipliers: forces are linear in them."""


class Equations(NamedTuple):
    """Forces (n,), mass matrix (n, n), directions of constraints (n, rows) and their gaps (rows,)."""

    forces: np.ndarray
    mass: np.ndarray
    directions: np.ndarray
    gaps: np.ndarray


class Matrices(NamedTuple):
    """Mass and stiffness (coordinates, coordinates) and the constraints' Jacobian.

    `position` and `velocity` are derivatives of the equations (equations, coordinates) by coordinates and
    rates; `dummy` tells the equations that only say that a multiplier is zero.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    dummy: np.ndarray


def random_state(case, rest, seed):
    """Coordinates about a rest and rates, as large as they become in a run and larger."""
    rng, shoes = np.random.default_rng(seed), 6 * case.track.shoe_count
    q, q_t = rest.copy(), 0.1 * rng.normal(size=len(rest))
    q[:shoes] += np.tile([1e-2, 1e-2, 5e-3, 0.05, 0.05, 0.05], case.track.shoe_count) * rng.normal(size=shoes)
    q[shoes:] *= 1.0 + 0.1 * rng.normal(size=len(rest) - shoes)
    return q, q_t


def by_engine(case, q, q_t):
    """Equations of Exudyn's items, in the coordinates of a state.

    Exudyn's rates are ``P q'`` and its accelerations ``P q'' + P' q'``, the last of which accelerations of
    zero in a state have.
    """
    system = ExudynSystem(case.with_(formulation="engine"))
    still, convert = np.zeros_like(q), system._coordinates.of_state
    own, own_t, own_tt = convert(q, q_t, still)
    by_rates = np.column_stack([convert(q, e, still)[1] for e in np.eye(len(q))])
    with static_solver(system.mbs) as (solver, settings):
        size, rows = solver.GetODE2size(), solver.GetAEsize()

        def residual(multipliers):
            system.mbs.systemData.SetODE2Coordinates(own)
            system.mbs.systemData.SetODE2Coordinates_t(own_t)
            system.mbs.systemData.SetAECoordinates(multipliers)
            solver.ComputeNewtonResidual(system.mbs, settings)
            return np.array(solver.GetSystemResidual())

        base = residual(np.zeros(rows))
        # forces are linear in multipliers
        units = FORCE_SCALE * np.eye(rows)[system._rows]
        directions = np.column_stack([residual(e)[:size] - base[:size] for e in units]) / FORCE_SCALE
        solver.ComputeMassMatrix(system.mbs)
        mass = np.array(solver.GetSystemMassMatrix())[:size, :size]
    return Equations(
        by_rates.T @ (base[:size] - mass @ own_tt),
        by_rates.T @ mass @ by_rates,
        (by_rates.T @ directions)[:, : constraints(case)],
        base[size:][system._rows][: constraints(case)],
    )


def constraints(case):
    """Number of constraints that act: the last one, the turn, only where the case turns."""
    rows = sum(size for _, size in compiled_system(case).layout.multipliers)
    return rows if case.drive.turn_rate is not None else rows - 1


def sphere_wrenches(case, q):
    """Exudyn's contact forces on the shoes (shoes, 6) at rest at coordinates."""
    system = ExudynSystem(case, static=True)
    system.set_initial(q)
    with static_solver(system.mbs) as (solver, settings):
        solver.ComputeNewtonResidual(system.mbs, settings)
    return system.stored_contacts()


@contextmanager
def static_solver(mbs):
    """Exudyn's static solver, which assembles equations, and its settings."""
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.staticSolver.useLoadFactor = False
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense
    solver = exu.MainSolverStatic()
    solver.InitializeSolver(mbs, settings)
    try:
        yield solver, settings
    finally:
        solver.FinalizeSolver(mbs, settings)


def linearized(mbs):
    """Matrices at a system's initial state."""
    blocks = []
    with static_solver(mbs) as (solver, _):
        n = solver.GetODE2size()
        solver.ComputeMassMatrix(mbs)
        mass = np.array(solver.GetSystemMassMatrix())[:n, :n]
        for by_position, by_rate in ((1.0, 0.0), (0.0, 1.0)):
            solver.ComputeJacobianODE2RHS(mbs, -by_position, -by_rate, 0.0)
            solver.ComputeJacobianAE(mbs, by_position, by_rate, 0.0)
            blocks.append(np.array(solver.GetSystemJacobian()))
    at_position, at_rate = blocks
    dummy = np.any(at_position[n:, n:] != 0.0, axis=1)
    return Matrices(mass, at_position[:n, :n], at_position[n:, :n], at_rate[n:, :n], dummy)


def residual_of(system, q, q_t, q_tt=None, multipliers=None, weights=NO_DERIVATIVES):
    """Residual of the compiled equations, at zero accelerations and multipliers unless they are given."""
    state = np.stack((q, q_t, np.zeros_like(q) if q_tt is None else q_tt))
    return system.residual(state, system.inputs(0.0), multipliers, weights)


def gaps_of(system):
    """Gaps of all constraints at the state of the last residual."""
    return system.work.joints.gap.copy()


def compiled(case, q, q_t):
    """Compiled equations."""
    system = compiled_system(case)
    n = len(q)
    base = residual_of(system, q, q_t)[:n]
    gaps = gaps_of(system)
    mass = np.column_stack([residual_of(system, q, q_t, e)[:n] - base for e in np.eye(n)])
    # forces are linear in multipliers
    units = FORCE_SCALE * np.eye(len(gaps))
    pushed = [residual_of(system, q, q_t, None, e)[:n] - base for e in units]
    rows = slice(constraints(case))
    return Equations(-base, mass, (np.column_stack(pushed) / FORCE_SCALE)[:, rows], gaps[rows])


def compiled_matrix(system, q, q_t, weights, multipliers=None):
    """Dense derivative of the compiled residual as Newton's method has it, on all unknowns."""
    size = len(residual_of(system, q, q_t, multipliers=multipliers, weights=Weights(*weights)))
    fronts, values = system.tables.fronts, np.zeros_like(system.scratch[1])
    matrix(system.block, Weights(*weights), values)
    dense = np.zeros((size, size))
    for k in range(len(fronts.pivots)):
        rows = fronts.rows(k)
        dense[np.ix_(rows, rows)] += values[fronts.place[k] : fronts.place[k + 1]].reshape(len(rows), -1)
    return dense


def matrix_errors(system, q, q_t, by_acceleration=9e5):
    """Errors of Newton's matrix against central differences of the residual, of what is on the diagonal."""
    n, weights = len(q), (1.0, 900.0, by_acceleration, False, 1e-3)
    matrix = compiled_matrix(system, q, q_t, weights)[:n, :n]
    found = np.empty_like(matrix)
    for k, e in enumerate(1e-8 * np.eye(n)):
        above = residual_of(system, q + e, q_t + weights[1] * e, weights[2] * e)
        below = residual_of(system, q - e, q_t - weights[1] * e, -weights[2] * e)
        found[:, k] = (above - below)[:n] / 2e-8
    diagonal = np.abs(np.diag(found))
    return np.abs(matrix - found) / np.sqrt(np.outer(diagonal, diagonal))


def check_matrix_at_rest(case, last, most):
    """Hold Newton's matrix against the derivative of the residual at rest.

    The rows and columns of the `last` coordinates are exact up to `most`: what the matrix leaves out is small
    there.
    """
    q = static_equilibrium(case)
    off = matrix_errors(compiled_system(case), q, np.zeros(len(q)))
    assert off.max() < 0.02
    assert off[:, -last:].max() < most
    assert off[-last:].max() < most
