"""Contacts of all pairs of shoe and unit as rows of force elements, with their tangents, in one pass.

The motions of a contact are three displacements of the shoe's side against the unit's and the rotation about
the contact's normal.
"""

from typing import NamedTuple

import numpy as np

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
from exudyn_crawler.ground.pair_track import Bodies, Track, named, patch_rectangle, patch_rows
from exudyn_crawler.ground.pairs import (
    FROM_CURVE,
    RESULTS,
    RIGID,
    Contact,
    Patch,
    keep,
    keep_patch,
    pair_contact,
    share_of,
)
from exudyn_crawler.ground.rotations import Attitude, FloatArray
from exudyn_crawler.ground.rows import ForceRows, Weights

MOTIONS = 4
"""Displacement of the shoe's side of a contact against the unit's along x, y, z (m) and rotation about the
normal (rad)."""

DEPTH_STEP, RATE_STEP = 1e-8, 1e-7
"""m, and m/s or rad/s: of the differences that give a law's slopes."""


class UnitContacts(NamedTuple):
    """Contacts of shoes with units of the terrain, in the order of the shoes; workspace.

    Attributes
    ----------
    rows : tuple
        `ForceRows` as a plain tuple: force on the shoe (N, global) and torque about the normal (N m).
    results : array (contacts, RESULTS)
        Columns as in `pairs.RESULT`.
    modes : array (contacts, 3, modes)
        Mean displacement of the patches of flexible shoes by their modes.
    """

    rows: tuple
    results: FloatArray
    modes: FloatArray

    @classmethod
    def allocate(cls, contacts: int, modes: int) -> "UnitContacts":
        """Workspace for so many contacts."""
        return cls(
            tuple(ForceRows.allocate(contacts, MOTIONS, modes)),
            np.zeros((contacts, RESULTS)),
            np.zeros((contacts, 3, modes)),
        )


@within
def _write_jacobian(
    contact: Contact, shoe: Frame, unit: Frame, at: Attitude, tilt_axis: int, rows: ForceRows, p: int
) -> None:
    """Write how shoe and unit move contact p."""
    normal = upward(unit.R)
    arm, unit_arm = along(contact.point, -1.0, shoe.r), along(contact.point, -1.0, unit.r)
    jacobian, by_unit = rows.jacobian[p, 0], rows.unit_jacobian[p]
    for c in range(3):
        by_angle = cross(at.axes[c], arm)
        for r in range(3):
            jacobian[r, c] = 1.0 if r == c else 0.0
            jacobian[r, 3 + c] = by_angle[r]
        jacobian[3, c], jacobian[3, 3 + c] = 0.0, dot(at.axes[c], normal)
        by_unit[c, 0] = -1.0 if c == 2 else 0.0
    by_tilt = cross(unit_arm, basis(tilt_axis))
    for r in range(3):
        by_unit[r, 1] = by_tilt[r]
    by_unit[3, 0], by_unit[3, 1] = 0.0, -normal[tilt_axis]


@within
def _write_modal_jacobian(shoe: Frame, modes: FloatArray, jacobian: FloatArray) -> None:
    """Write how modes, whose displacements in the shoe's axes are given (3, m), move a contact."""
    for k in range(modes.shape[1]):
        move = turned(shoe.R, (modes[0, k], modes[1, k], modes[2, k]))
        for r in range(3):
            jacobian[r, 6 + k] = move[r]


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
    """Wrenches of all contacts, their tangents and how the coordinates move them.

    Parameters
    ----------
    places, model, factors, out : tuple
        `Bodies`, `Track`, `Weights` and `UnitContacts` as plain tuples; without weights of position and
        velocity the tangents are left as they are.
    work : array (2, VERTICES, 3)
        Scratch memory as of `overlap_workspace`.

    Returns
    -------
    int
        Number of contacts, in the order of the shoes.
    """
    bodies, track = named(places, model)
    weights, contacts = Weights(*factors), UnitContacts(*out)
    rows = ForceRows(*contacts.rows)
    derive = weights.position != 0.0 or weights.velocity != 0.0
    top, axis = 0.5 * track.grid.height, track.grid.tilt_axis
    greatest, count = rows.unit.shape[0], 0
    for s in range(bodies.shoes.shape[0]):
        shoe = standing(bodies, track, s)
        for k in range(shoe.cells.columns * shoe.cells.rows):
            u, unit, part = below(bodies, track, shoe, k, work)
            if part.area > 0.0 and count < greatest:
                rows.bodies[count, 0], rows.unit[count] = s, u
                patch = RIGID
                if shoe.row >= 0:
                    modes, result = contacts.modes[count], contacts.results[count]
                    rectangle = patch_rectangle(part, shoe.frame, unit, track)
                    keep_patch(rectangle, result)
                    patch_rows(rectangle, track, modes)
                    patch = _patch(bodies, shoe.row, modes)
                    _write_modal_jacobian(shoe.frame, modes, rows.jacobian[count, 0])
                else:
                    keep_patch((0.0, 0.0, 0.0, 0.0), contacts.results[count])
                contact = pair_contact(part, shoe.frame, unit, patch, top, track.law, FROM_CURVE)
                keep(contact, s, u, contacts.results[count])
                _write_wrench(contact, upward(unit.R), rows.wrench[count])
                _write_jacobian(contact, shoe.frame, unit, shoe.at, axis, rows, count)
                if derive:
                    turning = (upward(unit.R), _spin(shoe.frame, unit))
                    _write_stiffness(part, contact, turning, track, weights, rows.tangent[count])
                count += 1
    return count
