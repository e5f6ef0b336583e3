"""Static equilibrium of track and terrain before t = 0, by Newton's method with the whole derivative."""

from contextlib import suppress

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground import sphere_contact, terrain
from exudyn_crawler.model import engine, equations
from exudyn_crawler.model.compiled_system import MANY, CompiledSystem, compiled_system
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.track_system import NewtonError, TrackSystem
from fem.interrupts import interrupts_wait

STEPS = (1e-7, 1e3)
"""Half steps of central differences: of coordinates (m, rad, modal), far below the 0.1 mm of the contact's
damping law, and of multipliers (N, N m), on which the forces depend linearly."""

HELD = (1, 5)
"""Coordinates of the front shoe that are held beside its drive point: y and the angle about z. Friction needs
slip, so that nothing else holds a track at rest in the plane; on ground that sticks nothing is held."""

CREEPING, CREEPING_OTHERS = 30.0, 6.0
"""s, after which what still creeps is held by friction: on level, even units, and of closed chains and on all
else. The papers' machine then starts 2e-5 of its weight away from rest, after 6 s 4e-3 of it."""
CREEPING_LIMITS = (1.0, MANY)
"""Residual (N, root mean square) that ends a step's search, and most iterations."""

RESIDUAL, ITERATIONS = 1e-3, 50
"""Residual of a rest (N, root mean square: 1e-9 of a shoe's load), and most iterations."""

PORTIONS = 8
"""Steps in which a relief rises where Newton's method finds no rest on all of it at once."""
OIL_SPEEDS = (0.02, 0.1, 0.5, 2.0)
"""m/s, tried in this order: up to which friction holds creeping shoes in proportion to their slip. With more
oil shoes creep further and Newton's method fails less."""

RELAXATION, RELAXATION_STEP, RELAXATIONS = 4.0, 0.04, 4
"""s, s and number: duration, step and most repetitions of the damped motion on uneven ground."""
POLISHING = 10
"""Iterations in which Newton's method takes over from damped motion, or not at all."""

SLOW = 1e-6
"""m/s and rad/s, greatest speed at rest: its dashpots take less than 1e-4 m/s2 of a shoe's mass."""


def crept(system: CompiledSystem, guess: np.ndarray) -> np.ndarray:
    """Coordinates to which a track under rollers or on uneven cells creeps from a guess, or a `NewtonError`.

    Frictionless it may have no rest at all: the rollers fold the chain up, and only friction holds the shoes
    where they are. So all bodies creep to where they stay, without inertia and slowed in proportion to their
    mass, while friction in proportion to the slip holds what it would hold.
    """
    terrain, closed = system.case.terrain, system.case.is_closed
    level = terrain.model == "units" and terrain.is_even and terrain.grade == terrain.side_slope == 0.0
    time = CREEPING if level and not closed else CREEPING_OTHERS
    return system.creep(guess, time, CREEPING_LIMITS)


def rest(system: CompiledSystem, guess: np.ndarray) -> np.ndarray:
    """Coordinates at which a track with its front shoe held rests, near to a guess, or a `NewtonError`.

    Along x the shoe is held where the drive will pull: its force, which the drive takes over, bends the shoe,
    and from another place the run would start with a jolt.
    """
    n, front = len(guess), 6 * system.layout.shoes - 6
    held = [] if system.sticks else [front + k for k in HELD]
    start, holds = system.pulled_place(np.zeros(n)), 1 + len(held)

    def balance(x: np.ndarray) -> np.ndarray:
        q, multipliers, forces_held = x[:n], x[n:-holds], x[-holds:]
        residual, pulled = system.at_rest(q, multipliers)
        residual[:n] += forces_held[0] * pulled
        residual[held] += forces_held[1:]
        gaps = [system.pulled_place(q) - start, *q[held]]
        return np.concatenate((residual, equations.STIFFNESS * np.array(gaps)))

    def derivative(at: np.ndarray) -> np.ndarray:
        """Central differences, a column for each argument."""
        moved, columns = at.copy(), np.empty((len(at), len(at)))
        for k, step in enumerate(steps):
            moved[k] = at[k] + step
            above = balance(moved)
            moved[k] = at[k] - step
            columns[k] = (above - balance(moved)) / (2.0 * step)
            moved[k] = at[k]
        return columns.T

    x = np.concatenate((guess, np.zeros(system.pin_rows + holds)))
    steps = np.repeat(STEPS, [n, len(x) - n])
    for _ in range(ITERATIONS):
        residual = balance(x)
        if not np.isfinite(residual).all() or np.sqrt(np.mean(residual**2)) < RESIDUAL:
            break
        try:
            x = x - np.linalg.solve(derivative(x), residual)
        except np.linalg.LinAlgError as error:
            raise NewtonError(system.in_units(residual[:-holds]), singular=True) from error
    if not np.sqrt(np.mean(residual**2)) < RESIDUAL:
        raise NewtonError(system.in_units(residual[:-holds]), singular=False)
    return x[:n]


def static_equilibrium(case: Case) -> np.ndarray:
    """Coordinates of track and terrain at rest under their weights and the loads at t = 0: (coordinates,).

    Laid out as `model.state` says: m and rad, from the places at t = 0 before settling. EquilibriumError
    where Newton's method finds none, or one with spheres below the ground; on uneven ground it names the
    shoe that the ground carries least.
    """
    if case.terrain.model == "cells":
        return _compiled_rest(case)
    if isinstance(terrain.terrain_coordinates(case), terrain.TerrainModes):
        q = _compiled_rest(case)
        if case.is_compiled or case.flexible is None:
            return q
        # Exudyn's joints turn otherwise with the lugs of bent shoes: from the other rest these would swing
        return _rest(ExudynSystem(case, static=True), q)
    system = ExudynSystem(case, static=True)
    try:
        q = _rest(system, system.first_guess()) if case.terrain.is_even else _on_uneven_ground(system)
    except EquilibriumError as error:
        if case.contact.model != "spheres" or not case.terrain.is_even:
            raise
        raise EquilibriumError(
            f"{error}. The spheres' radius of {case.sphere_contact().radius} m may "
            f"be too small for a settled penetration of {case.settled_penetration:.4g} m."
        ) from error
    contact = system.contact
    if isinstance(contact, sphere_contact.SphereGroundContact) and (sunken := contact.sunken(q)):
        raise EquilibriumError(
            f"no static equilibrium of case {case.name!r} was found: spheres of shoes {sunken} sink through "
            f"the ground; they need a contact.radius greater than {case.sphere_contact().radius} m, or "
            "flatter ground"
        )
    return q


def _compiled_rest(case: Case) -> np.ndarray:
    system = compiled_system(case)
    guess = system.first_guess()
    try:
        if case.is_rolled or case.is_closed:
            return _crept(case, guess)
        try:
            return rest(system, guess)
        except NewtonError:
            if case.terrain.is_even or not system.sticks:
                raise
            # over stones and ledges shoes tilt far from any guess
            return crept(system, guess)
    except NewtonError as failed:
        is_free = case.running_gear is None and not system.sticks
        if not is_free or (case.terrain.is_even and case.pair_contact().normal == "face"):
            raise _no_rest(system, failed) from failed
    if not case.terrain.is_even:
        return _on_rising_ground(case)
    # normals that lean push a long chain about at the seams: it starts from its rest on faces alone
    return _rest_from(case, _compiled_rest(case.with_(contact=case.pair_contact().with_(normal="face"))))


def _rest_from(case: Case, start: np.ndarray) -> np.ndarray:
    """Rest by Newton's method from coordinates near to it."""
    system = compiled_system(case)
    try:
        return rest(system, start)
    except NewtonError as failed:
        raise _no_rest(system, failed) from failed


def _on_rising_ground(case: Case) -> np.ndarray:
    """Rest on a relief that rises from even ground in steps, each from the rest on the one before."""
    found = guess = np.zeros(0)
    for share in np.linspace(0.0, 1.0, PORTIONS + 1):
        raised = case.with_({"terrain.relief.scale": share * case.terrain.relief.scale})
        before, guess = guess, compiled_system(raised).first_guess()
        start = found + guess - before if found.size else guess
        found = _rest_from(raised, start)
    return found


def _crept(case: Case, guess: np.ndarray) -> np.ndarray:
    """Where a track under rollers creeps to, with as little oil as lets it."""
    if case.contact.model == "cells":
        return crept(compiled_system(case), guess)
    for speed in OIL_SPEEDS[:-1]:
        with suppress(NewtonError):
            return crept(compiled_system(_oiled(case, speed)), guess)
    return crept(compiled_system(_oiled(case, OIL_SPEEDS[-1])), guess)


def _oiled(case: Case, speed: float) -> Case:
    """Same case with friction nearly in proportion to the slip up to a speed (m/s), and even beyond."""
    contact = case.pair_contact()
    oil = {"stiction_speed": speed, "friction_speed": 2.0 * speed}
    return case.with_(contact=contact.with_(dynamic_friction=contact.static_friction, **oil))


def _no_rest(system: TrackSystem, failed: NewtonError) -> EquilibriumError:
    slides = "; the ground's shear may be too weak to hold the shoes: compare contact.law with the slope"
    even = system.sticks and system.case.terrain.is_even and failed.singular
    return EquilibriumError(
        f"no static equilibrium of case {system.case.name!r} was found: Newton's method failed, "
        f"{failed.fault(system.layout)}{slides if even else ''}"
    )


def _rest(system: ExudynSystem, guess: np.ndarray, iterations: int = ITERATIONS) -> np.ndarray:
    """Rest of a system built for statics, by Newton's method from a guess."""
    system.set_initial(guess)
    settings = newton_settings(RESIDUAL, iterations)
    settings.staticSolver.useLoadFactor = False
    # loads are whole from the start, so that a shorter step would be the same one
    settings.staticSolver.adaptiveStep = False
    try:
        # Exudyn takes an interrupt within its calls for an error of its own
        with interrupts_wait():
            return system.rest(settings)
    except NewtonError as failed:
        raise _no_rest(system, failed) from failed


def _on_uneven_ground(system: ExudynSystem) -> np.ndarray:
    """Rest on uneven ground, onto which the track sinks from above.

    Damped motion finds it where Newton's method alone goes astray: Exudyn's derivatives leave out how the
    links' forces turn with the shoes, and spheres come onto edges and leave them.
    """
    case, q = system.case, system.first_guess()
    for _ in range(RELAXATIONS):
        system.set_initial(q)
        try:
            _damped_motion(system)
        except NewtonError as failed:
            why = f"damped motion failed, {failed.fault(system.layout)}"
            break
        q, rates, _ = system.coordinates()
        speed = np.abs(rates).max()
        if speed < SLOW:
            return q
        with suppress(EquilibriumError):
            return _rest(system, q, POLISHING)
        why = f"it still moves at {speed:.2g} m/s after {RELAXATIONS * RELAXATION:g} s of damped motion"
    force = system.stored_contacts()[:, 2]
    raise EquilibriumError(
        f"no static equilibrium of case {case.name!r} was found on its uneven ground: {why}; the ground "
        f"carries shoe {force.argmin() + 1} least, with {force.min():.3g} N"
    )


def newton_settings(residual: float, iterations: int) -> "engine.exu.SimulationSettings":
    """Exudyn's settings for a rest or a motion, in silence; residual (N, root mean square) that is enough."""
    settings = engine.exu.SimulationSettings()
    settings.linearSolver.solverType = engine.exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    for solver in (settings.staticSolver, settings.timeIntegration):
        solver.verboseMode = 0
        solver.newton.absoluteTolerance = residual
        # the absolute tolerance alone decides: the first residual of a step is no measure
        solver.newton.relativeTolerance = 1e-16
        solver.newton.weightTolerancePerCoordinate = True
        solver.newton.maxIterations = iterations
    return settings


def _damped_motion(system: ExudynSystem) -> None:
    """One motion, which an interrupt ends after its step."""
    settings = newton_settings(1.0, 40)
    time = settings.timeIntegration
    time.endTime = RELAXATION
    time.numberOfSteps = round(RELAXATION / RELAXATION_STEP)
    time.minimumStepSize = 0.1 * RELAXATION_STEP
    time.generalizedAlpha.spectralRadius = 0.0
    with interrupts_wait() as waiting:
        system.after_step(lambda _time: not waiting)
        system.solve(settings)
