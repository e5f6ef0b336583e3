"""Rest of a system of compiled equations: by Newton's method, by creeping, and by settling on cells."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.ground.rotations import moments_on_angles
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.diagnostics import NewtonError, in_units
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.model.forces.loads import static_friction
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.newton import Limits

RESIDUAL = 1e-3
"""Greatest residual of a rest, root mean square, N: 1e-9 of a shoe's load."""
ITERATIONS = 50
"""Greatest number of iterations of Newton's method for a rest."""

COORDINATE_STEP = 1e-7
"""Half step of central differences, m, rad and modal: far below the 0.1 mm of the contact's damping law."""
MULTIPLIER_STEP = 1e3
"""Half step of multipliers in central differences, N and N m; forces depend linearly on them."""

HELD = (1, 5)
"""Held coordinates of the front shoe beside its drive point: y and the angle about z. Friction needs slip, so
that nothing else holds a track at rest in the plane; on ground with sticking nothing is held."""


class Creep(NamedTuple):
    """Creeping of a track to its rest."""

    drag: float  # final force over momentum of every body, 1/s, so that shoes slip slowly
    first_drag: float  # initial drag, 1/s; it halves after a step of few iterations, or after `ENOUGH` steps
    first_step: float  # s
    on_level: float  # duration on level, even units, s; friction holds bodies that still creep then
    on_edges: float  # duration of the settling on uneven cells, s


# the papers' machine then has a residual of 2e-5 of its weight; after 6 s it would have 4e-3
_OPEN = Creep(drag=100.0, first_drag=100.0, first_step=5e-3, on_level=30.0, on_edges=4.0)
# the free runs of a closed chain swing slowly and do not allow slow shoes. A search from the assembled state
# needs a large drag at first: slow shoes hardly slip, and damping has no effect
_CLOSED = Creep(drag=8.0, first_drag=1e5, first_step=0.05, on_level=6.0, on_edges=4.0)
CREEPS = {
    "dragged": _OPEN._replace(on_edges=60.0),  # shoes tilt on edges
    "rolled": _OPEN,
    "closed": _CLOSED,
    "machine": _CLOSED,
}
"""Parameters of creeping by the kind of gear."""
MOST_DRAG = 1e9
"""Drag above which a failure of Newton's method makes the step shorter, 1/s."""

PATIENCE = 20
"""Number of failures of Newton's method met by more drag before one is met by a shorter step: a shoe that
just touches a wheel may gain and lose contact from iteration to iteration at any drag."""

ENOUGH = 10
"""Number of steps with one drag after which it falls for any number of iterations: a long chain that slips
back over its wheels takes as many in each step, and creeps far too slowly with its drag then."""

LONGEST_STEP = 0.2
"""Longest step of creeping, s."""
LEAST_STEP = 1e-7
"""Shortest step of creeping, s; creeping fails below it."""

EASY = 8
"""Number of iterations below which the next step of creeping is longer."""
FAIR = 12
"""Number of iterations below which the drag falls."""
MOST = 25
"""Greatest number of iterations of a step of creeping."""

STEADY_DRAGS = (8.0, 1.0, 0.1)
"""Drags of the search for steady creep, 1/s, in this order, as long as each settles in its `STEADY_STEPS`.
The last one takes 2e-5 of the weight at 2 mm/s, the first one 2e-3; a run starts without drag."""
STEADY_TIME = 1.0
"""Duration with each drag, s: speeds change by half within 0.2 s."""
STEADY_STEP = 5e-3
"""First step with each drag, s."""
STEADY_STEPS = (700, 250, 250)
"""Greatest number of steps with each drag. Newton's matrix omits rotations of shoes about a contact, so that
a dragged track takes 540 with the first one. A further drag that settles takes 12 to 200; where it needs
more, contacts come and go."""
STEADY_TRIAL = 50
"""Number of steps after which a drag is given up whose steps so far are too short on average."""
STEADY_RESIDUAL = 2e-3
"""Residual that ends the iteration of a step of the search for steady creep, root mean square, N."""

SETTLING = 4.0
"""Duration of creeping to rest on even cells, whose memory keeps the shoes' sinkage, s."""
SETTLING_RESIDUAL = 1e-2
"""Residual that ends the iteration of a settling step, root mean square, N."""


def newton_rest(system: CompiledSystem, guess: np.ndarray) -> np.ndarray:
    """Return the coordinates at rest with the front shoe held, near to a guess; else `NewtonError`.

    Along x the shoe is held at the point of the drive. The drive takes over the holding force, and this force
    bends the shoe: at another point the run would start with a jolt.
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
        """Return the derivatives by central differences, a column for each argument."""
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
    """Return the displacement along x of the drive's point, m, with that of its place in the shoe."""
    front = q[6 * system.layout.shoes - 6 : 6 * system.layout.shoes]
    modal = q[len(q) - system.point.rows.shape[1] :]
    return float(front[0] + system.point.arm(front[3:], modal)[0])


def at_rest(
    system: CompiledSystem, q: np.ndarray, multipliers: np.ndarray, undriven: Inputs
) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual at rest without the drive, and the drive's direction as generalized force.

    `multipliers` are those of the pins (pin_rows,), N and N m. The arrays are (coordinates + pin_rows,), see
    `equations.residual`, and (coordinates,).
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
    """Return the coordinates after creeping from `q` for a `duration` (s) without inertia, under first loads.

    A drag force in proportion to the momentum slows all bodies; time counts from the first step with least
    drag. `residual` (N, root mean square) ends the iteration of a step; `accepted` is called after every
    step. `NewtonError` if steps become too short.
    """
    least, drag, step, *_ = CREEPS[system.case.gear.kind]
    time = 0.0
    failures = 0
    steps = 0  # with this drag
    multipliers = np.zeros(system.tables.multipliers)
    # resistance of wheels acts on motion alone: creeping with it would last longer, to the same rest
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
    """Return the loads at t = 0 and a drive at zero speed."""
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
    """Return state and multipliers after a step (s) of creeping, and the iterations; None if it failed."""
    state = np.zeros((3, len(q)))
    state[0] = q
    after = multipliers.copy()
    weights = Weights(1.0, 1.0 / step, drag / step, False, step)
    converged, iterations = system.step(state, after, inputs, weights, Limits(residual, MOST, False))
    return (state if converged and np.isfinite(state).all() else None), after, iterations


def steady(system: CompiledSystem, q: np.ndarray) -> np.ndarray:
    """Return coordinates and rates (2, coordinates) of a track in steady creep by its friction, near to `q`.

    Friction that needs slip holds no track at rest. A track that it has to hold, as on a slope, creeps with
    the slip that balances its weight. A run that started there without rates would begin with a fall. If
    friction does not hold the track below the stiction speed, the result is `q` with zero rates.
    """
    system.switch_drive(system.case.drive.drives_after(0.0))
    start = np.stack((q, np.zeros_like(q)))
    motion = start
    multipliers = np.zeros(system.tables.multipliers)
    for drag, most_steps in zip(STEADY_DRAGS, STEADY_STEPS, strict=True):
        after = _steadied(system, motion, multipliers, drag, most_steps)
        if after is None:
            break
        motion, multipliers = after
    speeds = np.linalg.norm(motion[1, : 6 * system.layout.shoes].reshape(-1, 6)[:, :3], axis=1)
    return start if speeds.max() > system.case.part(PairContact).stiction_speed else motion


def _steadied(
    system: CompiledSystem, motion: np.ndarray, multipliers: np.ndarray, drag: float, most_steps: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return motion and multipliers `STEADY_TIME` later; None if steps are too many or too small."""
    time = 0.0
    step = STEADY_STEP
    inputs = _still(system)
    for count in range(most_steps):
        if count == STEADY_TRIAL and time < STEADY_TIME * count / most_steps:
            break
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
    """Return the rest near to that on fresh ground, `q`, after cells have stored the shoes' sinkage.

    Cells below two shoes store the deeper sinkage. Other ground leaves `q` as it is.
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
    # without a drive the ground alone holds the front shoe
    case = system.case
    system.switch_drive(case.drive.drives_after(0.0))
    duration = SETTLING if case.terrain.is_even else CREEPS[case.gear.kind].on_edges
    return creep(system, q, duration, SETTLING_RESIDUAL, cells.commit)
