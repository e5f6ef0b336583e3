"""Newton's method for one step of a track."""

import numpy as np

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model import elimination, kinds
from exudyn_crawler.model.equations import matrix, residual
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.tables import read_system

CONTRACTION = 0.5
"""Residual over the last one above which the matrix is made anew."""
OLD_STEPS = 8
"""Iterations with one matrix."""
TANGENTS = 2
"""Matrices of one step with the tangent of the friction curve; later ones take the secant."""
CLOSER = 0.25
"""Share of the limit to which the matrix of the last step has to bring the residual: a new one leaves a
hundredth, and what an old one leaves adds up over steps."""


@inner(allocates=True)
def _norm(residual: FloatArray) -> float:
    """Root mean square."""
    return np.sqrt(np.sum(residual * residual) / residual.shape[0])


@kernel
def step(
    system: IntArray,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    limits: tuple[float, int, bool],
    scratch: tuple[FloatArray, FloatArray],
) -> tuple[bool, int, int, float]:
    """Solve the equations of a step from its prediction, in place.

    `system` is a block of `tables.System`. `state` (3, coordinates) are predicted coordinates, rates and
    accelerations; the latter two follow a change of the coordinates ``weights.velocity`` and
    ``weights.acceleration`` times. `multipliers` are those of the last step, `limits` the residual (N, root
    mean square) that ends the search, most iterations, and whether the search may begin with the factored
    matrix of the last step; `scratch` are the residual, left as it was last, and values of the fronts with
    that matrix. Gives whether it converged, iterations, matrices and the last residual, N.
    """
    n = state.shape[1]
    out, values = scratch
    tables = read_system(system).tables
    search = tables.search
    by_place, by_rate, by_acceleration, own_secant, level = weights
    # a literal among them would compile the equations once more
    none = Weights(0.0, 0.0, 0.0, own_secant, level)
    iterations = matrices = 0
    needed = derived = not limits[2]
    residual(system, state, multipliers, inputs, weights if derived else none, out)
    old = 0
    last = _norm(out)
    change = np.empty_like(out)
    while iterations < limits[1]:
        if needed:
            secant = matrices >= TANGENTS
            if secant or not derived:
                by = Weights(by_place, by_rate, by_acceleration, secant, level)
                residual(system, state, multipliers, inputs, by, out)
            matrix(system, weights, values)
            elimination.eliminate(tables.fronts, values)
            matrices = matrices + 1
            needed = False
            old = 0
        change[:] = out
        elimination.solve(tables.fronts, values, change)
        for k in range(n):
            state[0, k] -= change[k]
            state[1, k] -= by_rate * change[k]
            state[2, k] -= by_acceleration * change[k]
        for k in range(multipliers.shape[0]):
            multipliers[k] -= change[n + k]
        kinds.turn_multipliers(tables.joints, tables.bodies, tables.markers, change, multipliers)
        iterations = iterations + 1
        old = old + 1
        residual(system, state, multipliers, inputs, none, out)
        derived = False
        norm = _norm(out)
        limit = limits[0] if matrices > 0 else CLOSER * limits[0]
        if norm <= limit:
            return True, iterations, matrices, norm
        if not norm < 1e30:
            break
        needed = (old > 2 and norm > CONTRACTION * last) or old > OLD_STEPS
        if matrices < TANGENTS:
            left = max(search.least, search.slower * norm / last)
            needed = needed or left * norm > limit
            if search.ahead > 0 and (old > 1 or matrices == 0):
                needed = needed or norm * (norm / last) ** search.ahead > limit
        last = norm
    return False, iterations, matrices, last
