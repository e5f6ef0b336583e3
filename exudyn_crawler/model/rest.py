"""Rest of a track under its weights and loads, by Newton's method with the whole derivative."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.model.compiled_system import (
    DRAG,
    FEW,
    FIRST_STEP,
    LEAST_STEP,
    LONGEST_STEP,
    MANY,
    CompiledSystem,
)
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.model.track_system import NewtonError

STEPS = (1e-7, 1e3)
"""Half steps of central differences: of coordinates (m, rad, modal), far below the 0.1 mm of the contact's
damping law, and of multipliers (N, N m), on which the forces depend linearly."""

HELD = (1, 5)
"""Coordinates of the front shoe that are held beside its drive point: y and the angle about z. Friction needs
slip, so that nothing else holds a track at rest in the plane; on ground that sticks nothing is held."""


CREEPING = 6.0
"""s, after which what still creeps is held by friction."""
CREEPING_LIMIT = 1.0
"""N, root mean square of the residual that ends a step's search."""


def crept(system: CompiledSystem, guess: NDArray) -> NDArray:
    """Coordinates that a track under rollers has crept to from a guess.

    Frictionless it may have no rest at all: the rollers fold the chain up, and only friction holds the shoes
    where they are. So all bodies creep to where they stay, without inertia and slowed in proportion to their
    mass, while friction in proportion to the slip holds what it would hold.

    Parameters
    ----------
    guess : array (coordinates,)
        To start from.

    Raises
    ------
    NewtonError
        If a step fails however short it is.
    """
    q, multipliers, step, time = guess, np.zeros(len(system.multipliers)), FIRST_STEP, 0.0
    while time < CREEPING:
        found = system.creep(q, multipliers, (step, DRAG), (CREEPING_LIMIT, MANY))
        if found is None:
            step *= 0.25
            if step < LEAST_STEP:
                raise system.failure()
            continue
        q, multipliers, iterations = found
        time += step
        if iterations < FEW:
            step = min(1.5 * step, LONGEST_STEP)
    return q


def rest(system: CompiledSystem, guess: NDArray, limit: float, iterations: int) -> NDArray:
    """Coordinates at which a track with its front shoe held rests.

    Along x the shoe is held where the drive will pull: its force, which the drive takes over, bends the shoe,
    and from another place the run would start with a jolt.

    Parameters
    ----------
    guess : array (coordinates,)
        To start from.
    limit : float
        N, root mean square of the residual that ends the search.
    iterations : int
        Most iterations.

    Raises
    ------
    NewtonError
        If there is no rest within them.
    """
    n, front = len(guess), 6 * system.layout.shoes - 6
    held = [] if system.sticks else [front + k for k in HELD]
    start, holds = system.pulled_place(np.zeros(n)), 1 + len(held)

    def balance(x: NDArray) -> NDArray:
        q, multipliers, forces_held = x[:n], x[n:-holds], x[-holds:]
        residual, pulled = system.at_rest(q, multipliers)
        residual[:n] += forces_held[0] * pulled
        residual[held] += forces_held[1:]
        gaps = [system.pulled_place(q) - start, *q[held]]
        return np.concatenate((residual, STIFFNESS * np.array(gaps)))

    x = np.concatenate((guess, np.zeros(system.pin_rows + holds)))
    steps = np.repeat(STEPS, [n, len(x) - n])
    for _ in range(iterations):
        residual = balance(x)
        if not np.isfinite(residual).all() or np.sqrt(np.mean(residual**2)) < limit:
            break
        try:
            x = x - np.linalg.solve(_derivative(balance, x, steps), residual)
        except np.linalg.LinAlgError as error:
            raise NewtonError(system.in_units(residual[:-holds]), singular=True) from error
    if not np.sqrt(np.mean(residual**2)) < limit:
        raise NewtonError(system.in_units(residual[:-holds]), singular=False)
    return x[:n]


def _derivative(function: Callable[[NDArray], NDArray], at: NDArray, steps: NDArray) -> NDArray:
    """Central differences of a function, a column for each of its arguments."""
    moved = at.copy()
    columns = np.empty((len(at), len(at)))
    for k, step in enumerate(steps):
        moved[k] = at[k] + step
        above = function(moved)
        moved[k] = at[k] - step
        columns[k] = (above - function(moved)) / (2.0 * step)
        moved[k] = at[k]
    return columns.T
