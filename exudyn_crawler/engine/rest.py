"""Rest of a system of Exudyn's items, by Exudyn's static solver and by damped motion."""

from contextlib import suppress

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground import sphere_contact
from exudyn_crawler.model.diagnostics import NewtonError, no_rest
from exudyn_crawler.model.exudyn import newton_settings
from fem.interrupts import interrupts_wait

RESIDUAL = 1e-3
"""N, root mean square, of a rest: 1e-9 of a shoe's load."""
ITERATIONS = 50
"""Most iterations of Newton's method for a rest."""

RELAXATION = 4.0
"""s, duration of the damped motion on uneven ground."""
RELAXATION_STEP = 0.04
"""s, step of this."""
RELAXATIONS = 4
"""Most repetitions of this."""
RELAXATION_RESIDUAL = 1.0
"""N, root mean square, that ends a step of this."""
RELAXATION_ITERATIONS = 40
"""Most iterations of a step of this."""
POLISHING = 10
"""Iterations in which Newton's method takes over from damped motion, or not at all."""

SLOW = 1e-6
"""m/s and rad/s, greatest speed at rest: its dashpots take less than 1e-4 m/s2 of a shoe's mass."""


def exudyn_rest(case: Case) -> np.ndarray:
    """Coordinates at rest of a case of Exudyn's items, or an `EquilibriumError`; see `model.state`."""
    system = ExudynSystem(case, static=True)
    try:
        q = rest_from(system, system.first_guess()) if case.terrain.is_even else _on_uneven_ground(system)
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


def rest_from(system: ExudynSystem, guess: np.ndarray, iterations: int = ITERATIONS) -> np.ndarray:
    """Rest of a system built for statics, by Newton's method from a guess, or an `EquilibriumError`."""
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
        raise no_rest(system, failed) from failed


def _on_uneven_ground(system: ExudynSystem) -> np.ndarray:
    """Rest on uneven ground, onto which the track sinks from above.

    Damped motion finds it where Newton's method alone goes astray: Exudyn's derivatives leave out how the
    links' forces turn with the shoes, and spheres come onto edges and leave them.
    """
    case = system.case
    q = system.first_guess()
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
            return rest_from(system, q, POLISHING)
        why = f"it still moves at {speed:.2g} m/s after {RELAXATIONS * RELAXATION:g} s of damped motion"
    force = system.stored_contacts()[:, 2]
    raise EquilibriumError(
        f"no static equilibrium of case {case.name!r} was found on its uneven ground: {why}; the ground "
        f"carries shoe {force.argmin() + 1} least, with {force.min():.3g} N"
    )


def _damped_motion(system: ExudynSystem) -> None:
    """Integrate a motion, which an interrupt ends after its step."""
    settings = newton_settings(RELAXATION_RESIDUAL, RELAXATION_ITERATIONS)
    time = settings.timeIntegration
    time.endTime = RELAXATION
    time.numberOfSteps = round(RELAXATION / RELAXATION_STEP)
    time.minimumStepSize = 0.1 * RELAXATION_STEP
    time.generalizedAlpha.spectralRadius = 0.0
    with interrupts_wait() as waiting:
        system.after_step(lambda _time: not waiting)
        system.solve(settings)
