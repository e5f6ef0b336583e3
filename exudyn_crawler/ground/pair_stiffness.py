"""Forces of all pairs of shoe and unit together with their derivatives, in one pass.

A pair sees its two bodies through four numbers, the motion of the shoe's side of the contact against the
unit's: three displacements and the rotation about the contact's normal. Force and torque are conjugate to
them, so that one matrix, `TouchingPairs.motion`, makes generalized forces of these and generalized
derivatives of theirs.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import (
    Frame,
    Vector,
    along,
    basis,
    compiled,
    cross,
    dot,
    norm,
    turned,
    upward,
    within,
)
from exudyn_crawler.ground.laws import drag_ratio, normal_force, spin_torque
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pair_overlaps import below, standing
from exudyn_crawler.ground.pair_track import Bodies, Track, named, patch_rows
from exudyn_crawler.ground.pairs import FROM_CURVE, RIGID, Contact, Patch, pair_contact, share_of
from exudyn_crawler.ground.rotations import Attitude, FloatArray
from exudyn_crawler.ground.triplets import Weights

MOTIONS = 4
"""Displacement of the shoe's side of a contact against the unit's along x, y, z (m) and rotation about the
normal (rad)."""

COORDINATES = 11
"""Six of the shoe, heave and tilt of the unit, displacement of a flexible shoe's patch in its own axes."""

DEPTH_STEP, RATE_STEP = 1e-8, 1e-7
"""m, and m/s or rad/s: of the differences that give a law's slopes."""


class TouchingPairs(NamedTuple):
    """Pairs that touch.

    Attributes
    ----------
    pairs : array (contacts, 2)
        Shoe and unit.
    wrench : array (contacts, MOTIONS)
        Force on the shoe (N, global) and torque about the normal (N m).
    stiffness : array (contacts, MOTIONS, MOTIONS)
        Weighted derivative of the wrench by the motions and their rates.
    motion : array (contacts, MOTIONS, COORDINATES)
        The motions by the coordinates.
    rows : array (contacts, 3, modes)
        Mean displacement rows of flexible shoes' patches.
    """

    pairs: NDArray[np.int64]
    wrench: FloatArray
    stiffness: FloatArray
    motion: FloatArray
    rows: FloatArray

    @classmethod
    def room(cls, contacts: int, modes: int) -> "TouchingPairs":
        """Memory for so many contacts."""
        return cls(
            np.zeros((contacts, 2), dtype=np.int64),
            np.zeros((contacts, MOTIONS)),
            np.zeros((contacts, MOTIONS, MOTIONS)),
            np.zeros((contacts, MOTIONS, COORDINATES)),
            np.zeros((contacts, 3, modes)),
        )


@within
def _write_motion(
    contact: Contact, shoe: Frame, unit: Frame, at: Attitude, tilt_axis: int, motion: FloatArray
) -> None:
    """Write the motions of a contact by its coordinates (MOTIONS, COORDINATES)."""
    normal = upward(unit.R)
    arm, unit_arm = along(contact.point, -1.0, shoe.r), along(contact.point, -1.0, unit.r)
    motion.fill(0.0)
    for c in range(3):
        motion[c, c] = 1.0
        by_angle = cross(at.axes[c], arm)
        local = turned(shoe.R, basis(c))
        for r in range(3):
            motion[r, 3 + c] = by_angle[r]
            motion[r, 8 + c] = local[r]
        motion[3, 3 + c] = dot(at.axes[c], normal)
    motion[2, 6] = -1.0
    by_tilt = cross(unit_arm, basis(tilt_axis))
    for r in range(3):
        motion[r, 7] = by_tilt[r]
    motion[3, 7] = -normal[tilt_axis]


@within
def _spin(shoe: Frame, unit: Frame) -> float:
    """Rate of turning of a shoe against a unit about the unit's normal, rad/s."""
    return dot(along(shoe.omega, -1.0, unit.omega), upward(unit.R))


@within
def _write_stiffness(
    part: Overlap,
    contact: Contact,
    turning: tuple[Vector, float],
    track: Track,
    weights: Weights,
    out: FloatArray,
) -> None:
    """Write the weighted derivative of a contact's wrench (MOTIONS, MOTIONS).

    `turning` are the contact's normal and the rate of turning about it, rad/s.
    The outline of the overlap and the directions of normal and axes stay as they are. Under an even
    displacement along the normal the depth at the centroid of the volume V changes by ``2 - depth A / V``.
    """
    normal, spin = turning
    law = track.law.law
    share = share_of(part, track.law)
    depth, rate = contact.penetration, contact.penetration_rate
    slip = contact.slip_velocity
    speed = norm(slip)
    force, ratio = normal_force(law, depth, rate), drag_ratio(law, speed)
    by_depth = (normal_force(law, depth + DEPTH_STEP, rate) - force) / DEPTH_STEP
    by_rate = (normal_force(law, depth, rate + RATE_STEP) - force) / RATE_STEP
    force *= share
    along_normal = by_depth * (2.0 - part.depth * part.area / part.volume)
    change = -share * (weights.position * along_normal + weights.velocity * by_rate)
    falling = 0.0
    if not weights.secant and speed > RATE_STEP:
        falling = (drag_ratio(law, speed + RATE_STEP) - ratio) / (RATE_STEP * speed)
    drag, steeper = weights.velocity * force * ratio, weights.velocity * force * falling
    drawn = along(normal, -ratio, slip)
    for r in range(3):
        for c in range(3):
            across = (1.0 if r == c else 0.0) - normal[r] * normal[c]
            out[r, c] = change * drawn[r] * normal[c] - drag * across - steeper * slip[r] * slip[c]
    torque = spin_torque(law, spin, part.area, force * ratio * speed)
    turned_more = spin_torque(law, spin + RATE_STEP, part.area, force * ratio * speed)
    a_newton = spin_torque(law, spin, part.area, 1.0)
    for c in range(3):
        # the torque is proportional to friction, which grows with the normal force and with the slip
        friction = ratio * speed * change * normal[c]
        if speed > 0.0:
            friction += (drag + steeper * speed * speed) * slip[c] / speed
        out[3, c] = a_newton * friction
        out[c, 3] = 0.0
    out[3, 3] = weights.velocity * (turned_more - torque) / RATE_STEP


@within
def _write_wrench(contact: Contact, normal: Vector, wrench: FloatArray) -> None:
    """Write force and torque of a contact on its shoe (MOTIONS,)."""
    force = along(contact.normal_force, 1.0, contact.friction_force)
    for c in range(3):
        wrench[c] = force[c]
    wrench[3] = dot(contact.friction_torque, normal)


@within
def _patch(bodies: Bodies, f: int, rows: FloatArray) -> Patch:
    """Mean motion of the patch that has these rows (3, modes) on the flexible shoe in row f."""
    moved, moving = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(rows.shape[1]):
        row = (rows[0, k], rows[1, k], rows[2, k])
        moved, moving = along(moved, bodies.modal[f, k], row), along(moving, bodies.modal_rates[f, k], row)
    return Patch(moved, moving)


@compiled
def touching_pairs(places: tuple, model: tuple, factors: tuple, out: tuple, work: FloatArray) -> int:
    """Wrenches of all contacts, their derivatives and how the coordinates move them.

    Parameters
    ----------
    places, model, factors, out : tuple
        `Bodies`, `Track`, `Weights` and `TouchingPairs` as plain tuples; without weights, both zero, the
        derivatives are left as they are.
    work : array (2, VERTICES, 3)
        Scratch memory as of `overlap_workspace`.

    Returns
    -------
    int
        Number of contacts, in the order of the shoes.
    """
    bodies, track = named(places, model)
    weights, found = Weights(*factors), TouchingPairs(*out)
    derive = weights.position != 0.0 or weights.velocity != 0.0
    room, count = found.pairs.shape[0], 0
    for s in range(bodies.shoes.shape[0]):
        shoe = standing(bodies, track, s)
        for k in range(shoe.cells.columns * shoe.cells.rows):
            u, unit, part = below(bodies, track, shoe, k, work)
            if part.area > 0.0 and count < room:
                found.pairs[count, 0], found.pairs[count, 1] = s, u
                patch = RIGID
                if shoe.row >= 0:
                    patch_rows(part, shoe.frame, unit, track, found.rows[count])
                    patch = _patch(bodies, shoe.row, found.rows[count])
                top = 0.5 * track.grid.height
                contact = pair_contact(part, shoe.frame, unit, patch, top, track.law, FROM_CURVE)
                _write_wrench(contact, upward(unit.R), found.wrench[count])
                axis = track.grid.tilt_axis
                _write_motion(contact, shoe.frame, unit, shoe.at, axis, found.motion[count])
                if derive:
                    turning = (upward(unit.R), _spin(shoe.frame, unit))
                    _write_stiffness(part, contact, turning, track, weights, found.stiffness[count])
                count += 1
    return count
