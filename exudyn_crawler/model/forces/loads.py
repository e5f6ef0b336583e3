"""Loads on bodies: forces and moments at markers, and time histories of loads and speeds of a case."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case, StepProfile, statics
from exudyn_crawler.ground import laws
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, Ints1
from exudyn_crawler.model.bodies import Bodies, add_body, attitude_of, read_body
from exudyn_crawler.model.markers import NOTHING, Markers, direction, end_of


class Profiles(NamedTuple):
    """Quantities over time, joined by cubic STEPs: times (q, k), last ones repeated, and values (q, k)."""

    times: FloatArray
    values: FloatArray


def profiles_of(profiles: Sequence[StepProfile]) -> Profiles:
    """Return profiles as arrays."""
    width = max(len(profile.times) for profile in profiles)
    times, values = np.zeros((2, len(profiles), width))
    for row, profile in enumerate(profiles):
        missing = width - len(profile.times)
        times[row] = [*profile.times, *[profile.times[-1]] * missing]
        values[row] = [*profile.values, *[profile.values[-1]] * missing]
    return Profiles(times, values)


@kernel
def values_at(profiles: Profiles, time: float, out: FloatArray) -> None:
    """Write the values (q,) of profiles at a time, s."""
    for row in range(out.shape[0]):
        times = profiles.times[row]
        values = profiles.values[row]
        k = np.searchsorted(times, time)
        if k == 0 or k == times.shape[0]:
            out[row] = values[min(k, times.shape[0] - 1)]
        else:
            out[row] = laws.step(time, times[k - 1], values[k - 1], times[k], values[k])


class Loads(NamedTuple):
    """Markers of loads; k of them."""

    marker: Ints1  # (k,): where they act
    # (k,): marker whose position and modes are what those of the load's place change by per metre that it
    # shifts to the left; -1 for a load that does not shift
    beside: Ints1


def static_friction(case: Case, masses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the friction that holds each shoe on a slope at rest.

    The friction laws need slip and have none at rest. The friction acts at the underside, at half of the
    settled depth in the ground. Forces (N) and moments about the COM (N m) are arrays (shoes, 3); `masses`
    are those of the shoes (kg).
    """
    along_ground = case.terrain.down * np.array([1.0, 1.0, 0.0])
    loads = case.gear.first_loads(case)
    height = 0.5 * statics.settled_penetration(case) - case.shoe.com_height
    force = -(loads + masses * case.gravity)[:, None] * along_ground
    return force, np.cross([*case.shoe.underside_center, height], force)


@inner(allocates=True)
def add_loads(
    bodies: Bodies,
    markers: Markers,
    loads: Loads,
    wrenches: FloatArray,
    shift: float,
    state: FloatArray,
    residual: FloatArray,
) -> None:
    """Subtract loads from the residual.

    `wrenches` (k, 6) are forces (N) and moments (N m), global; those that shift act `shift` (m) to the left.
    """
    row = np.empty((2, 6 + markers.displacement.shape[2]))
    for k in range(loads.marker.shape[0]):
        place = loads.marker[k]
        beside = loads.beside[k]
        if not wrenches[k].any():
            continue
        b = markers.body[place]
        read_body(bodies, b, state[0], row[0])
        attitude = attitude_of(bodies, b)
        force = (wrenches[k, 0], wrenches[k, 1], wrenches[k, 2])
        moment = (wrenches[k, 3], wrenches[k, 4], wrenches[k, 5])
        direction(
            markers, place, end_of(markers, place, attitude, row[0]), attitude, force, moment, 1.0, row[1]
        )
        add_body(bodies, b, row[1], -1.0, residual)
        if beside >= 0 and shift != 0.0:
            end = end_of(markers, beside, attitude, row[0])
            direction(markers, beside, end, attitude, force, NOTHING, 1.0, row[1])
            for c in range(3):
                row[1, c] = 0.0
            add_body(bodies, b, row[1], -shift, residual)
