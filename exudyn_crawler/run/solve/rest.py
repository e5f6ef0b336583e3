"""Rest of a system of compiled equations: by Newton's method, by creeping, and settled on cells."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.rotations import moments_on_angles
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.diagnostics import NewtonError, in_units
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.model.forces.loads import static_friction
from exudyn_crawler.model.inputs import Inputs

RESIDUAL = 1e-3
"""N, root mean square, of a rest: 1e-9 of a shoe's load."""
ITERATIONS = 50
"""Most iterations of Newton's method for a rest."""

COORDINATE_STEP = 1e-7
"""m, rad and modal: half step of central differences, far below the 0.1 mm of the contact's damping law."""
MULTIPLIER_STEP = 1e3
"""N and N m: the same of multipliers, on which the forces depend linearly."""

HELD = (1, 5)
"""Coordinates of the front shoe that are held beside its drive point: y and the angle about z. Friction needs
slip, so that nothing else holds a track at rest in the plane; on ground that sticks nothing is held."""


class Creep(NamedTuple):
    """Creeping of a track to its rest."""

    drag: float  # 1/s, force over momentum that slows every body in the end, so that shoes slip slowly
    first_drag: float  # 1/s, to start with; it falls by half with every step that is found with some ease,
    # and after some that are not
    first_step: float  # s
    on_level: float  # s of it on level, even units, after which what still creeps is held by friction
    on_edges: float  # s in which shoes settle on uneven cells


# the papers' machine then starts 2e-5 of its weight away from rest, after 6 s 4e-3 of it
_OPEN = Creep(drag=100.0, first_drag=100.0, first_step=5e-3, on_level=30.0, on_edges=4.0)
# runs of a closed chain swing slowly and stand no still shoes. From where it was assembled no rest is found
# but with a great drag at first: slow shoes hardly slip, and no damping is felt
_CLOSED = Creep(drag=8.0, first_drag=1e5, first_step=0.05, on_level=6.0, on_edges=4.0)
CREEPS = {
    "dragged": _OPEN._replace(on_edges=60.0),  # its shoes tilt on edges
    "rolled": _OPEN,
    "closed": _CLOSED,
    "machine": _CLOSED,
}
"""Creeping by the kind of gear."""
MOST_DRAG = 1e9
"""1/s, beyond which steps become shorter where Newton's method fails."""

PATIENCE = 20
"""Failures of Newton's method that more drag answers before a shorter step does: a shoe that just touches a
wheel may come and go from one iteration to the next whatever the drag."""

ENOUGH = 10
"""Steps with one drag after which it falls however many iterations they took: a long chain that slips back
over its wheels takes as many in each, and creeps far too slowly with the drag that it has by then."""

LONGEST_STEP = 0.2
"""s, of creeping."""
LEAST_STEP = 1e-7
"""s, below which creeping fails."""

EASY = 8
"""Iterations below which the next step of creeping is longer."""
FAIR = 12
"""Iterations below which drag falls."""
MOST = 25
"""Most iterations of a step of creeping."""

STEADY_DRAGS = (8.0, 1.0, 0.1)
"""1/s, one after the other, with which what creeps comes to its steady speed, as far as each is found with
some ease. The last one takes 2e-5 of the weight at 2 mm/s, the first one 2e-3; a run starts without."""
STEADY_TIME = 1.0
"""s of each of these: speeds change by half within 0.2 s."""
STEADY_STEP = 5e-3
"""s, the first one of each."""
STEADY_STEPS = 700
"""Most steps of each of these. Newton's matrix leaves out how shoes turn about a single contact."""
STEADY_RESIDUAL = 2e-3
"""N, root mean square, that ends a step's search."""

SETTLING = 4.0
"""s in which shoes creep to their rest on even cells, which remember them."""
SETTLING_RESIDUAL = 1e-2
"""N, root mean square, that ends a step's search in settling."""


def newton_rest(system: CompiledSystem, guess: np.ndarray) -> np.ndarray:
    """Coordinates at which a track with its front shoe held rests, near to a guess, or a `NewtonError`.

    Along x the shoe is held where the drive will pull: its force, which the drive takes over, bends the shoe,
    and from another place the run would start with a jolt.
    """
    count = len(guess)
    front = 6 * system.layout.shoes - 6
    held = [] if system.sticks else [front + k for k in HELD]
    start = pulled_place(system, np.zeros(count))
    holds = 1 + len(held)
    undriven = system.inputs(0.0)._replace(active=np.zeros(2))

    def balance(x: np.ndarray) -> np.ndarray:
        q, multipliers, forces_held = np.split(x, [count, len(x) - holds])
        residual, pulled = at_rest(system, q, multipliers, undriven)
        residual[:count] += forces_held[0] * pulled
        residual[held] += forces_held[1:]
        gaps = [pulled_place(system, q) - start, *q[held]]
        return np.concatenate((residual, STIFFNESS * np.array(gaps)))

    def derivative(x: np.ndarray) -> np.ndarray:
        """Central differences, a column for each argument."""
        moved = x.copy()
        columns = np.empty((len(x), len(x)))
        for k, step in enumerate(steps):
            moved[k] = x[k] + step
            above = balance(moved)
            moved[k] = x[k] - step
            columns[k] = (above - balance(moved)) / (2.0 * step)
            moved[k] = x[k]
        return columns.T

    x = np.concatenate((guess, np.zeros(system.pin_rows + holds)))
    steps = np.repeat([COORDINATE_STEP, MULTIPLIER_STEP], [count, len(x) - count])
    for _ in range(ITERATIONS):
        residual = balance(x)
        if not np.isfinite(residual).all() or np.sqrt(np.mean(residual**2)) < RESIDUAL:
            break
        try:
            x = x - np.linalg.solve(derivative(x), residual)
        except np.linalg.LinAlgError as error:
            raise NewtonError(in_units(system.layout, residual[:-holds]), singular=True) from error
    if not np.sqrt(np.mean(residual**2)) < RESIDUAL:
        raise NewtonError(in_units(system.layout, residual[:-holds]), singular=False)
    return x[:count]


def pulled_place(system: CompiledSystem, q: np.ndarray) -> float:
    """Displacement along x of the point that the drive moves, m, with that of its place in the shoe."""
    front = q[6 * system.layout.shoes - 6 : 6 * system.layout.shoes]
    modal = q[len(q) - system.point.rows.shape[1] :]
    return float(front[0] + system.point.arm(front[3:], modal)[0])


def at_rest(
    system: CompiledSystem, q: np.ndarray, multipliers: np.ndarray, undriven: Inputs
) -> tuple[np.ndarray, np.ndarray]:
    """Residual at rest under loads without the drive, and the drive's direction, as generalized force.

    Of coordinates and the pins' multipliers (pin_rows,), N and N m. Gives arrays (coordinates + pin_rows,),
    see `equations.residual`, and (coordinates,).
    """
    state = np.zeros((3, len(q)))
    state[0] = q
    system.cover(state)
    out = system.residual(state, undriven, np.concatenate((multipliers, np.zeros(2))))
    case = system.case
    count = 6 * system.layout.shoes
    if case.terrain.down[2] > -1.0 and not system.sticks:
        shoes = out[:count].reshape(-1, 6)
        angles = q[:count].reshape(-1, 6)[:, 3:]
        force, moment = static_friction(case, system.tables.bodies.mass[: len(shoes)])
        shoes[:, :3] -= force
        shoes[:, 3:] -= moments_on_angles(angles, moment)
    along = system.work.joints.jacobian[system.tables.joints.drive.first, 0]
    direction = np.zeros(len(q))
    direction[count - 6 : count] = along[:6]
    modes = system.point.rows.shape[1]
    if modes:
        direction[-modes:] = along[6:]
    return out[:-2], direction


def creep(
    system: CompiledSystem,
    q: np.ndarray,
    duration: float,
    residual: float,
    accepted: Callable[[], None] = lambda: None,
) -> np.ndarray:
    """Coordinates to which all bodies creep from `q` in a time (s), without inertia, under first loads.

    A force in proportion to the momentum slows them; the time counts from where that drag is least.
    `residual` (N, root mean square) ends a step's search, `accepted` is called after every step. A
    `NewtonError` if steps become too short.
    """
    least, drag, step, *_ = CREEPS[system.case.gear.kind]
    time = 0.0
    failures = 0
    steps = 0  # with this drag
    multipliers = np.zeros(system.tables.multipliers)
    # wheels resist motion alone: against them creeping would last longer, to the same rest
    inputs = _still(system)._replace(resists=0.0)
    while time < duration:
        state, after, iterations = _creeping_step(system, q, multipliers, inputs, drag, step, residual)
        if state is not None:
            accepted()
            q = state[0]
            multipliers = after
            steps += 1
            if drag > least and (iterations < FAIR or steps == ENOUGH):
                drag = max(least, 0.5 * drag)
                steps = 0
            elif drag == least:
                time += step
                step = min(1.5 * step, LONGEST_STEP) if iterations < EASY else step
            continue
        failures += 1
        steps = 0
        if least < drag < MOST_DRAG and failures % PATIENCE:
            drag *= 4.0
        else:
            step *= 0.25
            if step < LEAST_STEP:
                raise system.failure()
    return q


def _still(system: CompiledSystem) -> Inputs:
    """Loads at t = 0 and a drive that stands still."""
    inputs = system.inputs(0.0)
    return inputs._replace(speeds=np.zeros(2), motors=np.zeros_like(inputs.motors))


def _creeping_step(
    system: CompiledSystem,
    q: np.ndarray,
    multipliers: np.ndarray,
    inputs: Inputs,
    drag: float,
    step: float,
    residual: float,
) -> tuple[np.ndarray | None, np.ndarray, int]:
    """State and multipliers a step (s) of creeping later, and iterations; no state where it failed."""
    state = np.zeros((3, len(q)))
    state[0] = q
    after = multipliers.copy()
    weights = Weights(1.0, 1.0 / step, drag / step, False, step)
    converged, iterations = system.step(state, after, inputs, weights, (residual, MOST, False))
    return (state if converged and np.isfinite(state).all() else None), after, iterations


def steady(system: CompiledSystem, q: np.ndarray) -> np.ndarray:
    """Coordinates and rates (2, coordinates) of a track that creeps steadily by its friction, near to `q`.

    Friction that needs slip holds no track still: where it has to hold one, as on a slope, the track creeps
    with what balances its weight. A run that started with no rates there would begin with a fall. Where
    friction does not hold it below the stiction speed, `q` and no rates are given back.
    """
    system.switch_drive(system.case.drive.drives_after(0.0))
    start = np.stack((q, np.zeros_like(q)))
    motion = start
    multipliers = np.zeros(system.tables.multipliers)
    for drag in STEADY_DRAGS:
        after = _steadied(system, motion, multipliers, drag)
        if after is None:
            break
        motion, multipliers = after
    speeds = np.linalg.norm(motion[1, : 6 * system.layout.shoes].reshape(-1, 6)[:, :3], axis=1)
    return start if speeds.max() > system.case.pair_contact().stiction_speed else motion


def _steadied(
    system: CompiledSystem, motion: np.ndarray, multipliers: np.ndarray, drag: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Motion and multipliers `STEADY_TIME` later; None where steps are too many or too small."""
    time = 0.0
    step = STEADY_STEP
    inputs = _still(system)
    for _ in range(STEADY_STEPS):
        state, after, iterations = _creeping_step(
            system, motion[0], multipliers, inputs, drag, step, STEADY_RESIDUAL
        )
        if state is None:
            step *= 0.25
            if step < LEAST_STEP:
                break
            continue
        motion = state[:2]
        multipliers = after
        time += step
        if time >= STEADY_TIME:
            return motion, multipliers
        step = 1.5 * step if iterations < EASY else step
    return None


def settle(system: CompiledSystem, q: np.ndarray) -> np.ndarray:
    """Rest near to one `q` on fresh ground, after cells have remembered that shoes were put down there.

    Cells that two shoes share remember the deeper one; other ground leaves `q` as it is.
    """
    cells = system.cells
    if cells is None:
        return q
    system.put_down()
    state = np.zeros((3, len(q)))
    state[0] = q
    system.cover(state)
    system.residual(state, system.inputs(0.0))
    cells.commit()
    # what holds the front shoe without a drive is the ground alone
    case = system.case
    system.switch_drive(case.drive.drives_after(0.0))
    duration = SETTLING if case.terrain.is_even else CREEPS[case.gear.kind].on_edges
    return creep(system, q, duration, SETTLING_RESIDUAL, cells.commit)
