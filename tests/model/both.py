"""A case in both formulations, at any state."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.compiled_system import AT_REST, compiled_system
from exudyn_crawler.model.equations import matrix
from exudyn_crawler.model.tables import Workspace
from exudyn_crawler.run.solve.steady_sliding import equations_of

HELD = [0, 1, 2, 3, 5]
"""Rows of the engine's joint at a pin that constrain."""


class Equations(NamedTuple):
    """Forces (n,), mass matrix (n, n), directions of constraints (n, rows) and their gaps (rows,)."""

    forces: np.ndarray
    mass: np.ndarray
    directions: np.ndarray
    gaps: np.ndarray


def random_state(case, rest, seed):
    """Coordinates about a rest and rates, as large as they become in a run and larger."""
    rng, shoes = np.random.default_rng(seed), 6 * case.track.shoe_count
    q, q_t = rest.copy(), 0.1 * rng.normal(size=len(rest))
    q[:shoes] += np.tile([1e-2, 1e-2, 5e-3, 0.05, 0.05, 0.05], case.track.shoe_count) * rng.normal(size=shoes)
    q[shoes:] *= 1.0 + 0.1 * rng.normal(size=len(rest) - shoes)
    return q, q_t


def by_engine(case, q, q_t):
    """Equations of Exudyn's items."""
    with equations_of(case.with_(formulation="engine")) as (system, equations):
        none = np.zeros(equations.rows)
        residual = equations.residual(q, q_t, none)
        directions = equations.directions(q, q_t)
        n, pins = equations.size, 6 * sum("pin" in name for name, _ in system.layout.multipliers)
        rows = [6 * p + k for p in range(pins // 6) for k in HELD] + list(range(pins, equations.rows))
        return Equations(residual[:n], equations.mass(), directions[:, rows], residual[n:][rows])


def residual_of(system, q, q_t, q_tt=None, multipliers=None, weights=AT_REST):
    """Residual of the compiled equations, at zero accelerations and multipliers unless they are given."""
    state = np.stack((q, q_t, np.zeros_like(q) if q_tt is None else q_tt))
    return system.residual(state, system._inputs(0.0), multipliers, weights)


def gaps_of(system):
    """Gaps of all constraints at the state of the last residual."""
    return Workspace(*system._workspace).gap.copy()


def compiled(case, q, q_t):
    """Compiled equations."""
    system = compiled_system(case)
    n = len(q)
    base = residual_of(system, q, q_t)[:n]
    gaps = gaps_of(system)
    mass = np.column_stack([residual_of(system, q, q_t, e)[:n] - base for e in np.eye(n)])
    # forces are linear in multipliers
    units = 1e6 * np.eye(len(gaps))
    directions = np.column_stack([residual_of(system, q, q_t, None, e)[:n] - base for e in units]) / 1e6
    rows = slice(None) if case.drive.turn_rate is not None else slice(-1)
    return Equations(-base, mass, directions[:, rows], gaps[rows])


def compiled_matrix(system, q, q_t, weights):
    """Dense derivative of the compiled residual as Newton's method has it, on all unknowns."""
    size = len(residual_of(system, q, q_t, weights=Weights(*weights)))
    fronts, values = system.tables.fronts, np.zeros_like(system._scratch[1])
    state = np.stack((q, q_t, np.zeros_like(q)))
    matrix(system._plain, state, tuple(system._inputs(0.0)), weights, system._workspace, values)
    dense = np.zeros((size, size))
    for k in range(len(fronts.own)):
        rows = fronts.rows(k)
        n = len(rows)
        dense[np.ix_(rows, rows)] += values[fronts.place[k] : fronts.place[k + 1]].reshape(n, n)
    return dense
