"""Steady sliding of a track, and the linear equations of motion about it.

All shoes move along x at one speed and nothing accelerates. The ground's units stay the same: a mode lasts
for a second, while a shoe moves by a tenth of its length.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_limits

from exudyn_crawler import Case, History
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.engine.formulation import track_system
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.model.state import pin_name
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.simulation import set_times, solver_settings
from exudyn_crawler.run.solve.stages import Recorder

RESIDUAL = 1e-3  # N, greatest residual force at the end of Newton's method: 1e-9 of a shoe's load
GAP = 1e-10  # m and rad, greatest gap of the links at the end of Newton's method
ITERATIONS = 15
LONG_STEP = 1.0
"""Correction above which Newton's method diverges, m and rad."""
LEAST_PORTION = 0.01  # least increment of friction and travel, fraction of both
POSITION_STEP, RATE_STEP = 1e-6, 1e-6
"""Half steps of central differences, m and rad, and these per second: far below the 0.1 mm of the damping law
and the 10 mm/s of the friction law."""
FORCE_SCALE = 1e6  # N, multiplier for the links' directions: forces are linear in it
STILL = 1e-9  # ratio of imaginary part to greatest eigenvalue below which a mode does not swing


@dataclass(frozen=True)
class SteadySliding:
    """Equilibrium of a track with all shoes sliding along x at one speed."""

    system: CompiledSystem
    speed: float  # m/s
    q: np.ndarray  # (n,): coordinates in the order of the system's layout
    q_t: np.ndarray  # (n,): their rates
    multipliers: np.ndarray  # multipliers of links and drive
    tension: np.ndarray  # (links,): force of each link along x on its rear shoe, N
    normal_force: np.ndarray  # (shoes,): vertical force of the ground on each shoe, N


class Balance:
    """Forces of a system without acceleration, at any state."""

    def __init__(self, system: CompiledSystem) -> None:
        self._system = system
        self.size, self.rows = system.layout.coordinate_count, len(system.multipliers)

    def __call__(self, q: np.ndarray, q_t: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """Return the residual forces (n,), then the gaps of links and drive."""
        inputs = self._system.inputs(0.0)
        out = self._system.residual(np.stack((q, q_t, np.zeros_like(q))), inputs, multipliers)
        out[self.size :] /= STIFFNESS
        return out

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Return the mass matrix (n, n)."""
        still = np.zeros_like(q)
        none = np.zeros(self.rows)
        inputs = self._system.inputs(0.0)
        base = self(q, still, none)
        columns = [
            self._system.residual(np.stack((q, still, e)), inputs, none) - base for e in np.eye(self.size)
        ]
        return np.column_stack(columns)[: self.size]

    def directions(self, q: np.ndarray) -> np.ndarray:
        """Return generalized forces (n, rows) of unit multipliers; zero for unconstrained equations."""
        still = np.zeros_like(q)
        base = self(q, still, np.zeros(self.rows))[: self.size]
        pushed = [self(q, still, e)[: self.size] - base for e in FORCE_SCALE * np.eye(self.rows)]
        return np.column_stack(pushed) / FORCE_SCALE


def derivative(function: Callable[[np.ndarray], np.ndarray], values: np.ndarray, step: float) -> np.ndarray:
    """Return the central differences of a function, a column for each of its values."""
    changes = step * np.eye(len(values))
    return np.column_stack([(function(values + e) - function(values - e)) / (2.0 * step) for e in changes])


def check_sliding(case: Case, speed: float) -> None:
    """Raise `ValueError` for a case or a speed without steady sliding."""
    if not (np.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed must be positive and finite, got {speed!r} m/s")
    case.part(PairContact)
    if case.gear.shoes_stand:
        raise ValueError(
            f"gear.kind must not be {case.gear.kind!r}: shoes that a side frame rolls over do not slide"
        )
    if case.terrain.side_slope != 0.0:
        raise ValueError("terrain.side_slope must be 0: a track that slides slips down a side slope, too")
    if not case.part(Terrain).is_even:
        raise ValueError("terrain.relief must be level: a track has no steady state over hills")
    if case.drive.turn_rate is not None:
        raise ValueError("drive.turn_rate must be none: a track that turns has no steady state")
    if case.part(Terrain).tilt == "roll":
        raise ValueError(
            "terrain.tilt must be 'pitch': units that roll push a track sideways if it is not on their middle"
        )


def steady_sliding(case: Case, speed: float, travel: float = 0.0) -> SteadySliding:
    """Find the state with all shoes sliding along x at one speed without acceleration.

    Friction has its steady value, and the chain's tension grows shoe by shoe to the front. The loads are
    those at t = 0. Friction and travel are applied in as few increments as possible. `speed` is in m/s.
    `travel` (m) is the way of the front shoe along x; it decides which units bear the shoes. Raises
    `ValueError` as in `check_sliding`, and `EquilibriumError` if Newton's method finds no state.
    """
    check_sliding(case, speed)
    case = case.with_(terrain_formulation="reduced", formulation=None)
    system = compiled_system(case)
    q = static_equilibrium(case)
    balance = Balance(system)
    shoes = 6 * case.track.shoe_count
    q_t = np.zeros_like(q)
    multipliers = np.zeros(balance.rows)
    q_t[:shoes:6] = speed
    done = 0.0
    portion = 1.0
    while done < 1.0:
        goal = min(1.0, done + portion)
        guess = q.copy()
        guess[:shoes:6] += goal * travel - q[shoes - 6]
        solution = _newton(system, balance, (guess, q_t), goal, goal * travel)
        if solution is not None:
            q, multipliers = solution
            done = goal
            portion = 2.0 * portion
        elif portion < LEAST_PORTION:
            raise EquilibriumError(
                f"no steady sliding of case {case.name!r} at {speed:g} m/s was found: Newton's method "
                f"fails where friction and travel have {100 * done:.3g} % of their values"
            )
        else:
            portion *= 0.5
    return _state(system, q, q_t, multipliers, speed)


def _newton(
    system: CompiledSystem,
    forces: Balance,
    start: tuple[np.ndarray, np.ndarray],
    portion: float,
    travel: float,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Find coordinates and multipliers in balance at a portion of friction and travel; None if it fails."""
    n = forces.size
    driven = 6 * system.case.track.shoe_count - 6
    q, q_t = start
    drive = n + system.layout.first_multiplier("drive")

    def balance(q: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        moving, resting = (forces(q, rates, multipliers) for rates in (q_t, 0.0 * q_t))
        residuals = portion * moving + (1.0 - portion) * resting
        # the drive prescribes a speed, at any position
        residuals[drive] = q[driven] - travel
        return residuals

    # without its tension a track that is pulled beside its middle would turn far too easily
    multipliers = -scipy.linalg.lstsq(forces.directions(q), balance(q, np.zeros(forces.rows))[:n])[0]
    for _ in range(ITERATIONS):
        residual = balance(q, multipliers)
        directions = forces.directions(q)
        held = np.any(directions != 0.0, axis=0)
        gap = residual[n:][held]
        if np.abs(residual[:n]).max() < RESIDUAL and np.abs(gap).max() < GAP:
            return q, multipliers
        by_q = derivative(partial(balance, multipliers=multipliers), q, POSITION_STEP)
        none = np.zeros((len(gap), len(gap)))
        matrix = np.block(
            [[by_q[:n], FORCE_SCALE * directions[:, held]], [FORCE_SCALE * by_q[n:][held], none]]
        )
        right = -np.concatenate((residual[:n], FORCE_SCALE * gap))
        # nothing holds the track across its path: the shortest step does not move it sideways
        step = scipy.linalg.lstsq(matrix, right, cond=1e-13)[0]
        if not np.abs(step[:n]).max() < LONG_STEP:
            return None
        q = q + step[:n]
        multipliers = multipliers.copy()
        multipliers[held] += FORCE_SCALE * step[n:]
    return None


def _state(
    system: CompiledSystem, q: np.ndarray, q_t: np.ndarray, multipliers: np.ndarray, speed: float
) -> SteadySliding:
    shoes = system.case.track.shoe_count
    layout = system.layout
    forces = cast(PairGroundContact, system.contact).forces(q, q_t)[: 6 * shoes].reshape(-1, 6)
    tension = np.zeros(shoes - 1)
    for link in range(1, shoes):
        for name in filter(layout.has, (pin_name(side, link) for side in SIDES)):
            tension[link - 1] += multipliers[layout.first_multiplier(name)]
    return SteadySliding(system, speed, q, q_t, multipliers, tension, forces[:, 2])


@dataclass(frozen=True)
class LinearTrack:
    """Equations ``mass y'' + damping y' + stiffness y = 0`` of the motion ``basis @ y`` about equilibrium.

    `mass`, `damping`, `stiffness` are (f, f), `basis` is (n, f): links and drive leave f of n coordinates
    free. Without friction all three matrices are symmetric.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    basis: np.ndarray


def linearized(state: SteadySliding) -> LinearTrack:
    """Linearise the equations of motion about steady sliding, without the constrained motions.

    Derivatives are central differences of the residual. They include the rotation of link forces and loads
    with the shoes, which Newton's matrix of a run leaves out.
    """
    forces = Balance(state.system)
    n = len(state.q)
    directions = forces.directions(state.q)
    basis = scipy.linalg.null_space(directions[:, np.any(directions != 0.0, axis=0)].T)
    by_place = derivative(lambda q: forces(q, state.q_t, state.multipliers), state.q, POSITION_STEP)
    by_rate = derivative(lambda q_t: forces(state.q, q_t, state.multipliers), state.q_t, RATE_STEP)
    matrices = (forces.mass(state.q), by_rate[:n], by_place[:n])
    mass, damping, stiffness = (basis.T @ matrix @ basis for matrix in matrices)
    return LinearTrack(mass, damping, stiffness, basis)


def eigenmodes(linear: LinearTrack) -> tuple[np.ndarray, np.ndarray]:
    """Return complex eigenvalues (modes,), 1/s, in order of falling growth rate, and shapes (n, modes).

    A pair has the eigenvalue above the real axis. The complex shapes are in all coordinates and not scaled.
    """
    f = len(linear.mass)
    below = np.linalg.solve(linear.mass, np.hstack((-linear.stiffness, -linear.damping)))
    values, vectors = np.linalg.eig(np.vstack((np.eye(f, 2 * f, f), below)))
    upper = np.flatnonzero(values.imag >= -STILL * np.abs(values).max())
    order = upper[np.argsort(-values.real[upper], kind="stable")]
    return values[order], linear.basis @ vectors[:f, order]


@threadpool_limits.wrap(limits=1, user_api="blas")
def integrated_from(case: Case, state: np.ndarray, duration: float) -> History:
    """Return the history of a case for a duration (s) from a state's row; its multipliers do not matter.

    Raises `NewtonError` if a step fails at its least size.
    """

    def store(time: float) -> bool:
        recorder.store(time)
        return True

    system = track_system(case)
    start = float(state[0])
    recorder = Recorder(system, start + duration)
    recorder.go_on(start)
    system.set_state(state)
    system.switch_drive(case.drive.drives_after(start))
    settings = solver_settings(case.solver)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    set_times(settings, case.solver, start, start + duration)
    system.after_step(store)
    system.solve(settings)
    return system_history(system, recorder.taken())
