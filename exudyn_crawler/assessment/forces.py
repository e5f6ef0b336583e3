"""Forces on a machine with a slewing upper structure, and the point where their resultant meets the ground.

Axes: x ahead, y to the left, z up from the ground, normal to it. The origin is the middle of the rectangle
below both tracks. Slewing angles count from straight ahead to the left.
"""

from typing import NamedTuple

import numpy as np

Floats = np.ndarray
Numbers = float | np.ndarray

PARTS = ("lower", "upper", "payload", "digging", "wind", "slewing")
"""Forces in the order of `MachineForces`."""


class MachineWeights(NamedTuple):
    """Masses of a machine and their centres; the upper structure points straight ahead."""

    lower_mass: float
    """Mass of the parts that do not slew, tracks included, kg."""
    lower_com: tuple[float, float, float]
    """Centre of mass of these parts, m."""
    upper_mass: float
    """Mass of the parts that slew, without payload, kg."""
    upper_com: tuple[float, float, float]
    """Centre of mass of these parts: ahead of the swing axis, to its left, above the ground, m."""
    swing_axis: float = 0.0
    """X of the swing axis, m."""


class Work(NamedTuple):
    """Work of the upper structure."""

    payload: float = 0.0
    """Mass in the dipper or on the hook, kg."""
    reach: float = 0.0
    """Distance of the payload ahead of the swing axis, m."""
    height: float = 0.0
    """Height of the payload above the ground, m."""
    digging: tuple[float, float] = (0.0, 0.0)
    """Force of the bank on the dipper, N: away from the machine and up, at reach and height."""
    wind: float = 0.0
    """Wind force, N, towards `wind_towards`."""
    wind_height: float = 0.0
    """Height of the wind force above the ground, m."""
    wind_towards: float = 0.0
    """Direction of the wind force, rad from ahead to the left."""
    slew_rate: float = 0.0
    """Slewing rate of the upper structure, rad/s."""


class MachineForces(NamedTuple):
    """Forces in the order of `PARTS` at slewing angles, N, and their points, m: arrays (angles, 6, 3)."""

    force: Floats
    place: Floats


class Resultant(NamedTuple):
    """Resultant of forces on the ground: arrays (angles,)."""

    weight: Floats
    """Component into the ground, N."""
    ahead: Floats
    """X of the point where the resultant meets the ground, m."""
    aside: Floats
    """Y of this point, m."""
    push_ahead: Floats
    """Components along the ground, N."""
    push_left: Floats


def gravity_on_slope(gravity: float, slope: float, downhill: float) -> Floats:
    """Return the acceleration of gravity in the axes of a machine on a slope: array (3,), m/s2.

    Parameters
    ----------
    gravity : float
        m/s2.
    slope : float
        Inclination of the ground, rad.
    downhill : float
        Direction of the fall line, rad from ahead to the left; at 0 the machine faces downhill.
    """
    along = np.sin(slope)
    return gravity * np.array([along * np.cos(downhill), along * np.sin(downhill), -np.cos(slope)])


def forces_at(weights: MachineWeights, work: Work, slew: Floats, gravity: Floats) -> MachineForces:
    """Return the forces on a machine at slewing angles.

    Parameters
    ----------
    weights : MachineWeights
        Masses and places, kg and m.
    work : Work
        Payload, force of the bank, wind and slewing rate.
    slew : array (angles,)
        rad, from straight ahead to the left.
    gravity : array (3,)
        m/s2, see `gravity_on_slope`.

    Notes
    -----
    Slewing at a rate w adds the outward force m r w^2 at the COM of the upper structure and at the payload
    (d'Alembert). One force at their common height replaces both. Derived; no source.
    """
    slew = np.atleast_1d(np.asarray(slew, dtype=float))
    outward = np.stack((np.cos(slew), np.sin(slew), np.zeros_like(slew)), axis=-1)
    left = np.stack((-np.sin(slew), np.cos(slew), np.zeros_like(slew)), axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    axis = np.array([weights.swing_axis, 0.0, 0.0])
    ahead, aside, above = weights.upper_com
    upper = axis + ahead * outward + aside * left + above * up
    load = axis + work.reach * outward + work.height * up
    turning = weights.upper_mass * ahead + work.payload * work.reach
    heights = weights.upper_mass * ahead * above + work.payload * work.reach * work.height
    swung = axis + (heights / turning if turning else 0.0) * up
    blown = np.array([np.cos(work.wind_towards), np.sin(work.wind_towards), 0.0])
    rows = (
        (weights.lower_mass * gravity, np.array(weights.lower_com)),
        (weights.upper_mass * gravity, upper),
        (work.payload * gravity, load),
        (work.digging[0] * outward + work.digging[1] * up, load),
        (work.wind * blown, work.wind_height * up),
        (turning * work.slew_rate**2 * outward, swung),
    )
    shape = (len(slew), 3)
    force = np.stack([np.broadcast_to(row[0], shape) for row in rows], axis=1)
    place = np.stack([np.broadcast_to(row[1], shape) for row in rows], axis=1)
    return MachineForces(force, place)


def resultant(forces: MachineForces) -> Resultant:
    """Return the resultant of forces and the point where its line meets the ground.

    R is the sum of forces, M the sum of their moments about the origin. The line meets z = 0 at x = M_y / V
    and y = -M_x / V, V = -R_z (statics). Raise `ValueError` if no force presses on the ground.
    """
    whole = forces.force.sum(axis=1)
    moment = np.cross(forces.place, forces.force).sum(axis=1)
    weight = -whole[:, 2]
    if np.any(weight <= 0.0):
        raise ValueError(f"forces must press the machine on the ground, got {float(weight.min()):.4g} N")
    return Resultant(weight, moment[:, 1] / weight, -moment[:, 0] / weight, whole[:, 0], whole[:, 1])
