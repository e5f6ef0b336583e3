"""A case in both formulations, at any state."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.model.compiled.equations import evaluate
from exudyn_crawler.model.compiled.matrix import assemble
from exudyn_crawler.model.compiled.records import Memory
from exudyn_crawler.model.compiled.system import HELD, compiled_system
from exudyn_crawler.run.solve.steady_sliding import equations_of


class Equations(NamedTuple):
    """Forces (n,), mass matrix (n, n), directions of constraints (n, rows), what these are off (rows,)."""

    forces: np.ndarray
    mass: np.ndarray
    directions: np.ndarray
    off: np.ndarray


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


def evaluated(system, q, q_t, q_tt=None, multipliers=None, weights=(0.0, 0.0, 0.0, False, 1.0)):
    """Residual of the compiled equations, at zero accelerations and multipliers unless they are given."""
    state = np.zeros((3, len(q)))
    state[0], state[1] = q, q_t
    if q_tt is not None:
        state[2] = q_tt
    own = np.zeros(system.pin_rows + 2) if multipliers is None else multipliers
    residual = np.empty(len(q) + len(own))
    count = evaluate(system._model, state, own, system._inputs(0.0), weights, system._memory, residual)
    return residual, count


def compiled(case, q, q_t):
    """Compiled equations."""
    system = compiled_system(case)
    n = len(q)
    base = evaluated(system, q, q_t)[0][:n]
    off = Memory(*system._memory).off.copy()
    mass = np.column_stack([evaluated(system, q, q_t, e)[0][:n] - base for e in np.eye(n)])
    # forces are linear in multipliers
    units = 1e6 * np.eye(system.pin_rows + 2)
    directions = np.column_stack([evaluated(system, q, q_t, None, e)[0][:n] - base for e in units]) / 1e6
    rows = slice(None) if case.drive.turn_rate is not None else slice(-1)
    return Equations(-base, mass, directions[:, rows], off[rows])


def compiled_matrix(system, q, q_t, weights):
    """Dense derivative of the compiled residual as Newton's method has it, on all unknowns."""
    residual, count = evaluated(system, q, q_t, weights=weights)
    fronts, values = system._model[9], np.zeros_like(system._scratch[1])
    state = np.zeros((3, len(q)))
    state[0], state[1] = q, q_t
    assemble(system._model, state, system._inputs(0.0), weights, count, system._memory, values)
    dense = np.zeros((len(residual), len(residual)))
    unknowns, first, own, place, _, _ = fronts
    for k in range(len(own)):
        rows = unknowns[first[k] : first[k + 1]]
        n = len(rows)
        dense[np.ix_(rows, rows)] += values[place[k] : place[k + 1]].reshape(n, n)
    return dense
