"""Static equilibrium of track and terrain before t = 0: choice of the search for each kind of case."""

from contextlib import suppress

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.engine.rest import exudyn_rest, rest_from
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground import terrain
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.model.diagnostics import NewtonError, no_rest
from exudyn_crawler.run.solve.rest import CREEPS, creep, newton_rest

CREEPING = 6.0
"""Duration of creeping on ground other than level, even units, s; friction holds what still creeps then."""
CREEPING_RESIDUAL = 1.0
"""Residual that ends the iteration of a creeping step, root mean square, N."""

PORTIONS = 8
"""Number of steps of a rising relief if Newton's method finds no rest on the whole relief at once."""
OIL_SPEEDS = (0.02, 0.1, 0.5, 2.0)
"""Slip speeds, m/s, tried in this order, up to which friction on creeping shoes is proportional to slip. At
higher speeds shoes creep further and Newton's method fails less."""


def static_equilibrium(case: Case) -> np.ndarray:
    """Return the coordinates of track and terrain at rest under weights and loads of t = 0: (coordinates,).

    The layout is that of `model.state`: m and rad, from the places at t = 0 before settling. EquilibriumError
    if Newton's method finds no rest, or one with spheres below the ground; on uneven ground it names the
    least loaded shoe. EquilibriumError without a search if the ground cannot carry the shoes at any sinkage.
    """
    if (sinks := checks.bottomless(case)) is not None:
        raise EquilibriumError(f"no static equilibrium of case {case.name!r} is searched for: {sinks}")
    if case.terrain.model == "cells":
        return _compiled_rest(case)
    if not isinstance(terrain.terrain_coordinates(case), terrain.TerrainModes):
        return exudyn_rest(case)
    q = _compiled_rest(case)
    if case.is_compiled or case.flexible is None or case.gear.bodies:
        return q
    # Exudyn's joints rotate differently with the lugs of bent shoes, which would swing from the other rest
    return rest_from(ExudynSystem(case, static=True), q)


def _compiled_rest(case: Case) -> np.ndarray:
    """Return the rest of the compiled equations."""
    system = compiled_system(case)
    guess = system.first_guess()
    try:
        if case.gear.bodies:
            return _crept(case, guess)
        try:
            return newton_rest(system, guess)
        except NewtonError:
            if case.terrain.is_even or not system.sticks:
                raise
            # over stones and ledges shoes tilt far from any guess
            return crept(system, guess)
    except NewtonError as failed:
        is_free = not case.gear.bodies and not system.sticks
        if not is_free or (case.terrain.is_even and case.part(PairContact).normal == "face"):
            raise no_rest(system, failed) from failed
    if not case.terrain.is_even:
        return _on_rising_ground(case)
    # inclined normals push a long chain about at the seams: the search starts from its rest on faces alone
    return _rest_from(case, _compiled_rest(case.with_(contact=case.part(PairContact).with_(normal="face"))))


def crept(system: CompiledSystem, guess: np.ndarray) -> np.ndarray:
    """Return the coordinates after creeping under rollers or on uneven cells; else `NewtonError`.

    Without friction there may be no rest: the rollers fold the chain up, and only friction holds the shoes.
    So all bodies creep to their rest from a guess, without inertia and with a drag in proportion to their
    mass. Friction in proportion to the slip acts meanwhile.
    """
    ground = system.case.terrain
    level = ground.model == "units" and ground.is_even and ground.grade == ground.side_slope == 0.0
    time = CREEPS[system.case.gear.kind].on_level if level else CREEPING
    return creep(system, guess, time, CREEPING_RESIDUAL)


def _rest_from(case: Case, start: np.ndarray) -> np.ndarray:
    """Return the rest by Newton's method from coordinates near to it."""
    system = compiled_system(case)
    try:
        return newton_rest(system, start)
    except NewtonError as failed:
        raise no_rest(system, failed) from failed


def _on_rising_ground(case: Case) -> np.ndarray:
    """Return the rest on a relief that rises from even ground in steps, each from the rest before it."""
    rest = np.zeros(0)
    guess = np.zeros(0)
    for share in np.linspace(0.0, 1.0, PORTIONS + 1):
        raised = case.with_({"terrain.relief.scale": share * case.terrain.relief.scale})
        before = guess
        guess = compiled_system(raised).first_guess()
        rest = _rest_from(raised, rest + guess - before if rest.size else guess)
    return rest


def _crept(case: Case, guess: np.ndarray) -> np.ndarray:
    """Return the coordinates under rollers after creeping, at the least of `OIL_SPEEDS` that works."""
    if case.contact.model == "cells":
        return crept(compiled_system(case), guess)
    for speed in OIL_SPEEDS[:-1]:
        with suppress(NewtonError):
            return crept(compiled_system(_oiled(case, speed)), guess)
    return crept(compiled_system(_oiled(case, OIL_SPEEDS[-1])), guess)


def _oiled(case: Case, speed: float) -> Case:
    """Return a case with friction nearly in proportion to the slip up to a speed (m/s), constant above it."""
    contact = case.part(PairContact)
    oil = {"stiction_speed": speed, "friction_speed": 2.0 * speed}
    return case.with_(contact=contact.with_(dynamic_friction=contact.static_friction, **oil))
