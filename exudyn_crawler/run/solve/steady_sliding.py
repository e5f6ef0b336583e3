"""Steady sliding of a track: all shoes move along x at one speed and nothing accelerates."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.state import pin_name
from exudyn_crawler.model.system import System, build
from exudyn_crawler.run.solve.equilibrium import static_equilibrium


@dataclass(frozen=True)
class SteadySliding:
    """Equilibrium of a track whose shoes all slide along x at one speed; n coordinates.

    Attributes
    ----------
    case : Case
        What slides.
    speed : float
        m/s.
    q, q_t : array (n,)
        Coordinates as of `model.system` and their rates.
    multipliers : array
        Lagrange multipliers of links and drive as Exudyn's static solver takes them; those of a run have the
        opposite sign.
    tension : array (links,)
        Force of each link along x on its rear shoe, N.
    normal_force : array (shoes,)
        Vertical force of the ground on each shoe, N.
    """

    case: Case
    speed: float
    q: NDArray
    q_t: NDArray
    multipliers: NDArray
    tension: NDArray
    normal_force: NDArray


RESIDUAL = 1e-3
"""N, greatest force out of balance that ends Newton's method: 1e-9 of a shoe's load."""
GAP = 1e-10
"""m and rad, greatest gap of the links at the end of Newton's method."""
ITERATIONS = 15
LONG_STEP = 1.0
"""m and rad, correction beyond which Newton's method is off its way."""
LEAST_PORTION = 0.01
"""Of friction and travel, put on at a time."""
POSITION_STEP, RATE_STEP = 1e-6, 1e-6
"""m and rad, and per second: half steps of central differences, far below the 0.1 mm of the damping law and
the 10 mm/s of the friction law."""
FORCE_SCALE = 1e6
"""N, multiplier that the links' directions are taken with: their forces are linear in it."""


class Equations:
    """Forces of a built system at any state, as Exudyn's static solver assembles them."""

    def __init__(self, system: System, solver: Any, settings: "exu.SimulationSettings") -> None:
        self._system, self._solver, self._settings = system, solver, settings
        self.size, self.rows = solver.GetODE2size(), solver.GetAEsize()

    def residual(self, q: NDArray, q_t: NDArray, multipliers: NDArray) -> NDArray:
        """Forces with those of the links (n,), then the gaps of the links and the drive."""
        mbs = self._system.mbs
        mbs.systemData.SetODE2Coordinates(q.tolist())
        mbs.systemData.SetODE2Coordinates_t(q_t.tolist())
        mbs.systemData.SetAECoordinates(multipliers.tolist())
        self._solver.ComputeNewtonResidual(mbs, self._settings)
        return np.array(self._solver.GetSystemResidual())

    def mass(self) -> NDArray:
        """Mass matrix (n, n) at the last state."""
        self._solver.ComputeMassMatrix(self._system.mbs)
        return np.array(self._solver.GetSystemMassMatrix())[: self.size, : self.size]

    def by_coordinates(self, q: NDArray, q_t: NDArray, multipliers: NDArray) -> NDArray:
        """Derivative of the residual by the coordinates at fixed multipliers, (n + rows, n).

        It has what Exudyn's Jacobian leaves out: how forces of links and loads turn with the shoes.
        """
        return _derivative(lambda q: self.residual(q, q_t, multipliers), q, POSITION_STEP)

    def by_rates(self, q: NDArray, q_t: NDArray, multipliers: NDArray) -> NDArray:
        """Derivative of the residual by the rates, (n + rows, n)."""
        return _derivative(lambda q_t: self.residual(q, q_t, multipliers), q_t, RATE_STEP)

    def directions(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized forces (n, rows) of unit multipliers; zero for equations that constrain nothing."""
        none = np.zeros(self.rows)
        base = self.residual(q, q_t, none)[: self.size]
        pushed = [self.residual(q, q_t, e)[: self.size] - base for e in FORCE_SCALE * np.eye(self.rows)]
        return np.column_stack(pushed) / FORCE_SCALE


def _derivative(function: Callable[[NDArray], NDArray], at: NDArray, step: float) -> NDArray:
    """Central differences of a function, a column for each of its arguments."""
    changes = step * np.eye(len(at))
    return np.column_stack([(function(at + e) - function(at - e)) / (2.0 * step) for e in changes])


@contextmanager
def equations_of(case: Case) -> Iterator[tuple[System, Equations]]:
    """System of a case and its equations, at rest at t = 0."""
    system = build(case)
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.staticSolver.useLoadFactor = False
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense
    # Exudyn's stub gives a solver's methods without self
    solver: Any = exu.MainSolverStatic()
    solver.InitializeSolver(system.mbs, settings)
    try:
        yield system, Equations(system, solver, settings)
    finally:
        solver.FinalizeSolver(system.mbs, settings)


def steady_sliding(case: Case, speed: float, travel: float = 0.0) -> SteadySliding:
    """Find the state in which all shoes slide along x at one speed and nothing accelerates.

    Friction has its steady value, and the chain's tension grows shoe by shoe to the front. The loads are
    those at t = 0.

    Parameters
    ----------
    case : Case
        With contact model "pair" and no turn.
    speed : float
        m/s, positive.
    travel : float
        m by which the front shoe has gone along x: which units the shoes stand on.

    Raises
    ------
    ValueError
        If the speed is not positive, or the case turns or has another contact model.
    EquilibriumError
        If Newton's method finds no steady sliding.
    """
    check_sliding(case, speed)
    q = static_equilibrium(case)
    with equations_of(case) as (system, equations):
        return find_sliding(system, equations, q, speed, travel)


def check_sliding(case: Case, speed: float) -> None:
    """Refuse what has no steady sliding; see `steady_sliding`."""
    if not (np.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed must be positive and finite, got {speed!r} m/s")
    case.pair_contact()
    if case.undercarriage is not None:
        raise ValueError("undercarriage must be None: shoes that a side frame rolls over do not slide")
    if case.terrain.side_slope != 0.0:
        raise ValueError(
            "terrain.side_slope must be 0: a track that slides along x slips down a side slope, too"
        )
    if case.terrain.profile is not None:
        raise ValueError("terrain.profile must be None: a track has no steady state over hills")
    if case.drive.turn_rate is not None:
        raise ValueError("drive.turn_rate must be None: a track that turns has no steady state")


def find_sliding(
    system: System, equations: Equations, start: NDArray, speed: float, travel: float
) -> SteadySliding:
    """Steady sliding from rest at t = 0, in as few portions of friction and travel as can be."""
    shoes = 6 * system.case.track.shoe_count
    q, q_t, multipliers = start.copy(), np.zeros(equations.size), np.zeros(equations.rows)
    q_t[:shoes:6] = speed
    done, portion = 0.0, 1.0
    while done < 1.0:
        goal = min(1.0, done + portion)
        guess = q.copy()
        guess[:shoes:6] += goal * travel - q[shoes - 6]
        found = _newton(system, equations, (guess, q_t), goal, goal * travel)
        if found is not None:
            q, multipliers = found
            done, portion = goal, 2.0 * portion
        elif portion < LEAST_PORTION:
            raise EquilibriumError(
                f"no steady sliding of case {system.case.name!r} at {speed:g} m/s was found: Newton's method "
                f"fails where friction and travel have {100 * done:.3g} % of their values"
            )
        else:
            portion *= 0.5
    return _read(system, q, q_t, multipliers, speed)


def _newton(
    system: System, equations: Equations, start: tuple[NDArray, ...], portion: float, travel: float
) -> tuple[NDArray, NDArray] | None:
    """Coordinates and multipliers in balance under a portion of what the speed adds; None without success."""
    n, driven = equations.size, 6 * system.case.track.shoe_count - 6
    q, q_t = start
    drive = n + system.layout.first_multiplier("drive")

    def balance(q: NDArray, multipliers: NDArray) -> NDArray:
        moving, resting = (equations.residual(q, rates, multipliers) for rates in (q_t, 0.0 * q_t))
        both = portion * moving + (1.0 - portion) * resting
        # the drive prescribes a speed, which any place has
        both[drive] = q[driven] - travel
        return both

    # without its tension a track that is pulled beside its middle would be far too ready to turn
    directions = equations.directions(q, q_t)
    multipliers = -scipy.linalg.lstsq(directions, balance(q, np.zeros(equations.rows))[:n])[0]
    for _ in range(ITERATIONS):
        residual = balance(q, multipliers)
        directions = equations.directions(q, q_t)
        held = np.any(directions != 0.0, axis=0)
        gap = residual[n:][held]
        if np.abs(residual[:n]).max() < RESIDUAL and np.abs(gap).max() < GAP:
            return q, multipliers
        by_q = _derivative(partial(balance, multipliers=multipliers), q, POSITION_STEP)
        none = np.zeros((len(gap), len(gap)))
        matrix = np.block(
            [[by_q[:n], FORCE_SCALE * directions[:, held]], [FORCE_SCALE * by_q[n:][held], none]]
        )
        right = -np.concatenate((residual[:n], FORCE_SCALE * gap))
        # nothing holds the track across its path: the shortest step leaves it where it is
        step = scipy.linalg.lstsq(matrix, right, cond=1e-13)[0]
        if not np.abs(step[:n]).max() < LONG_STEP:
            return None
        q = q + step[:n]
        multipliers = multipliers.copy()
        multipliers[held] += FORCE_SCALE * step[n:]
    return None


def _read(system: System, q: NDArray, q_t: NDArray, multipliers: NDArray, speed: float) -> SteadySliding:
    shoes = system.case.track.shoe_count
    forces = system.contact.forces(q, q_t)[: 6 * shoes].reshape(-1, 6)
    layout = system.layout
    tension = np.zeros(shoes - 1)
    for link in range(1, shoes):
        for name in filter(layout.has, (pin_name(side, link) for side in SIDES)):
            tension[link - 1] -= multipliers[layout.first_multiplier(name)]
    return SteadySliding(system.case, speed, q, q_t, multipliers, tension, forces[:, 2])
