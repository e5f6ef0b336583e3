"""Equilibrium of a system of Exudyn's items, by Exudyn's static solver and by damped motion."""

from contextlib import suppress

import numpy as np

from exudyn_crawler.case import Case, statics
from exudyn_crawler.case.parameters.contact import SphereContact
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground import sphere_contact
from exudyn_crawler.model.diagnostics import NewtonError, no_rest
from exudyn_crawler.model.exudyn import newton_settings
from fem.interrupts import interrupts_wait

RESIDUAL = 1e-3
"""Greatest residual of an equilibrium, root mean square, N: 1e-9 of a shoe's load."""
ITERATIONS = 50
"""Greatest number of iterations of Newton's method for an equilibrium."""

RELAXATION = 4.0
"""Duration of the damped motion on uneven ground, s."""
RELAXATION_STEP = 0.04
"""Step of the damped motion, s."""
RELAXATIONS = 4
"""Greatest number of repetitions of the damped motion."""
RELAXATION_RESIDUAL = 1.0
"""Residual that ends a step of the damped motion, root mean square, N."""
RELAXATION_ITERATIONS = 40
"""Greatest number of iterations of a step of the damped motion."""
POLISHING = 10
"""Greatest number of iterations of Newton's method after damped motion."""

SLOW = 1e-6
"""Greatest speed at rest, m/s and rad/s: forces of the dashpots are below 1e-4 m/s2 times a shoe's mass."""


def exudyn_rest(case: Case) -> np.ndarray:
    """Return the coordinates (`model.state`) at rest of a case of Exudyn's items; else `EquilibriumError`."""
    system = ExudynSystem(case, static=True)
    try:
        q = rest_from(system, system.first_guess()) if case.terrain.is_even else _on_uneven_ground(system)
    except EquilibriumError as error:
        if case.contact.model != "spheres" or not case.terrain.is_even:
            raise
        raise EquilibriumError(
            f"{error}. The spheres' radius of {case.part(SphereContact).radius} m may "
            f"be too small for a settled penetration of {statics.settled_penetration(case):.4g} m."
        ) from error
    contact = system.contact
    if isinstance(contact, sphere_contact.SphereGroundContact) and (sunken := contact.sunken(q)):
        raise EquilibriumError(
            f"no static equilibrium of case {case.name!r} was found: spheres of shoes {sunken} sink through "
            f"the ground; they need a contact.radius greater than {case.part(SphereContact).radius} m, or "
            "flatter ground"
        )
    return q


def rest_from(system: ExudynSystem, guess: np.ndarray, iterations: int = ITERATIONS) -> np.ndarray:
    """Return the rest of a system built for statics, by Newton's method; `EquilibriumError` without one."""
    system.set_initial(guess)
    settings = newton_settings(RESIDUAL, iterations)
    settings.staticSolver.useLoadFactor = False
    # loads are complete from the start, so that a shorter step would be the same
    settings.staticSolver.adaptiveStep = False
    try:
        # Exudyn would treat an interrupt within its calls as an error of its own
        with interrupts_wait():
            return system.rest(settings)
    except NewtonError as failed:
        raise no_rest(system, failed) from failed


def _on_uneven_ground(system: ExudynSystem) -> np.ndarray:
    """Return the rest on uneven ground, after the track has sunk onto it from above.

    Damped motion converges where Newton's method alone fails: Exudyn's derivatives omit the rotation of the
    links' forces with the shoes, and spheres come onto edges and leave them.
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
    """Integrate a damped motion; an interrupt ends it after the current step."""
    settings = newton_settings(RELAXATION_RESIDUAL, RELAXATION_ITERATIONS)
    time = settings.timeIntegration
    time.endTime = RELAXATION
    time.numberOfSteps = round(RELAXATION / RELAXATION_STEP)
    time.minimumStepSize = 0.1 * RELAXATION_STEP
    time.generalizedAlpha.spectralRadius = 0.0
    with interrupts_wait() as waiting:
        system.after_step(lambda _time: not waiting)
        system.solve(settings)
