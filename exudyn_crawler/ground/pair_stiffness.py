"""Contacts of shoes and units as rows of force elements, with their tangents, in one pass.

The motions of a contact are three displacements of the shoe's side against the unit's and the rotation about
the contact's normal.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import frames, laws, overlap, pair_geometry, pairs, rotations
from exudyn_crawler.ground.compiled import inlined, inner, kernel
from exudyn_crawler.ground.frames import Frame, Vector, along, basis, cross, dot, norm, turned_back
from exudyn_crawler.ground.overlap import CHANGE
from exudyn_crawler.ground.packed import FloatArray, Floats2, Floats3, IntArray
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.ground.rows import NO_DERIVATIVES, ForceRows, Weights
from fem.body.rectangle_motion import mean_rows

MOTIONS = 4
"""Number of motions of a contact: displacement of the shoe's side against the unit's along x, y, z (m), and
rotation about the normal (rad)."""

DEPTH_STEP, MOVE_STEP, RATE_STEP = 1e-8, 1e-7, 1e-7
"""Differences that give a law's slopes: of a depth (m), of a displacement (m), of a rate (m/s or rad/s)."""


class Pair(NamedTuple):
    """Shoe and a unit below it at a state."""

    shoe_number: int
    unit_number: int
    shoe: Frame
    unit: Frame
    attitude: Attitude  # of the shoe


class UnitContacts(NamedTuple):
    """Contacts of shoes with units of the terrain, in the order of the shoes; workspace."""

    rows: ForceRows  # force on the shoe (N, global), torque about the normal (N m)
    results: Floats2  # (contacts, RESULTS): columns as in `pairs.RESULT`
    modes: Floats3  # (contacts, 3, modes): mean displacement of flexible shoes' patches by their modes

    @classmethod
    def allocate(cls, contacts: int, modes: int) -> "UnitContacts":
        """Return a workspace for at most `contacts` contacts."""
        return cls(
            rows=ForceRows.allocate(contacts, MOTIONS, modes),
            results=np.zeros((contacts, pairs.RESULTS)),
            modes=np.zeros((contacts, 3, modes)),
        )


@inner
def _write_jacobian(
    contact: pairs.Contact,
    normal: Vector,
    pair: Pair,
    tilt_axis: int,
    jacobian: FloatArray,
    by_unit: FloatArray,
) -> None:
    """Write the Jacobian of a contact by the coordinates of the shoe and of the unit."""
    axes = pair.attitude.axes
    arm = along(contact.point, -1.0, pair.shoe.r)
    unit_arm = along(contact.point, -1.0, pair.unit.r)
    for c in range(3):
        by_angle = cross(axes[c], arm)
        for r in range(3):
            jacobian[r, c] = 1.0 if r == c else 0.0
            jacobian[r, 3 + c] = by_angle[r]
        jacobian[3, c], jacobian[3, 3 + c] = 0.0, dot(axes[c], normal)
        by_unit[c, 0] = -1.0 if c == 2 else 0.0
    by_tilt = cross(unit_arm, basis(tilt_axis))
    for r in range(3):
        by_unit[r, 1] = by_tilt[r]
    by_unit[3, 0] = 0.0
    by_unit[3, 1] = -normal[tilt_axis]


@inner
def _bend(
    bodies: pair_geometry.BodyStates, f: int, shoe: Frame, rows: FloatArray, jacobian: FloatArray
) -> pairs.Patch:
    """Write a contact's Jacobian by the modes of the flexible shoe in row f; return the patch's mean motion.

    `rows` (3, m) are mean displacements of the patch by the modes, in the shoe's axes.
    """
    moved = (0.0, 0.0, 0.0)
    moving = (0.0, 0.0, 0.0)
    for k in range(rows.shape[1]):
        row = (rows[0, k], rows[1, k], rows[2, k])
        moved = along(moved, bodies.modal[f, k], row)
        moving = along(moving, bodies.modal_rates[f, k], row)
    frames.write_turned_rows(shoe.R, rows, rows.shape[1], 1.0, jacobian)
    return pairs.Patch(moved, moving)


@inlined
def _wrench(contact: pairs.Contact, normal: Vector) -> tuple[float, float, float, float]:
    """Return the force (N) of a contact on its shoe and the torque about its normal (N m)."""
    force = along(contact.normal_force, 1.0, contact.friction_force)
    return force[0], force[1], force[2], dot(contact.friction_torque, normal)


@inner
def _write_stiffness(
    volume: pairs.Volume,
    contact: pairs.Contact,
    normal: Vector,
    pair: Pair,
    law: pairs.PairLaw,
    weights: Weights,
    out: FloatArray,
) -> None:
    """Write the weighted derivative of a contact's wrench (MOTIONS, MOTIONS).

    The outline of the overlap, the normal and the axes are held constant. Under an even displacement along
    the normal the depth at the centroid of the volume V changes by ``2 - depth A / V``.
    """
    spin = dot(along(pair.shoe.omega, -1.0, pair.unit.omega), normal)
    part = volume.part
    impact = law.impact
    coulomb = law.coulomb
    share = pairs.share_of(volume, law)
    depth = contact.penetration
    rate = contact.penetration_rate
    slip = contact.slip_velocity
    speed = norm(slip)
    force = laws.impact_force(impact, depth, rate)
    ratio = laws.friction_per_slip(coulomb, speed)
    by_depth = (laws.impact_force(impact, depth + DEPTH_STEP, rate) - force) / DEPTH_STEP
    by_rate = (laws.impact_force(impact, depth, rate + RATE_STEP) - force) / RATE_STEP
    force *= share
    along_normal = by_depth * (2.0 - part.depth * part.area / part.volume)
    change = -share * (weights.position * along_normal + weights.velocity * by_rate)
    falling = 0.0
    if not weights.secant and speed > RATE_STEP:
        falling = (laws.friction_per_slip(coulomb, speed + RATE_STEP) - ratio) / (RATE_STEP * speed)
    drag = weights.velocity * force * ratio
    steeper = weights.velocity * force * falling
    drawn = along(normal, -ratio, slip)
    for r in range(3):
        for c in range(3):
            across = (1.0 if r == c else 0.0) - normal[r] * normal[c]
            out[r, c] = change * drawn[r] * normal[c] - drag * across - steeper * slip[r] * slip[c]
    torque = laws.friction_torque(coulomb, spin, part.area, force * ratio * speed)
    turned_more = laws.friction_torque(coulomb, spin + RATE_STEP, part.area, force * ratio * speed)
    a_newton = laws.friction_torque(coulomb, spin, part.area, 1.0)
    for c in range(3):
        # the torque is proportional to friction, which grows with the normal force and with the slip
        friction = ratio * speed * change * normal[c]
        if speed > 0.0:
            friction += (drag + steeper * speed * speed) * slip[c] / speed
        out[3, c] = a_newton * friction
        out[c, 3] = 0.0
    out[3, 3] = weights.velocity * (turned_more - torque) / RATE_STEP


@inner(merged=True)
def _change(gradient: FloatArray, row: int, u: Vector) -> float:
    """Return the change of a quantity, a row of `GradientRows`, by a displacement u along the unit's axes."""
    return gradient[row, 0] * u[0] + gradient[row, 1] * u[1] + gradient[row, 2] * u[2]


@inner
def _moved(volume: pairs.Volume, gradient: FloatArray, u: Vector) -> pairs.Volume:
    """Return a clipped overlap after a small displacement u of the shoe along the unit's axes (m)."""
    part = volume.part
    grown = part.volume + _change(gradient, CHANGE.volume, u)
    farther = _change(gradient, CHANGE.reach, u)
    moved = overlap.Overlap(
        part.area + _change(gradient, CHANGE.area, u),
        (part.xi * part.volume + _change(gradient, CHANGE.moment, u)) / grown,
        (part.eta * part.volume + _change(gradient, CHANGE.moment + 1, u)) / grown,
        (part.depth * part.volume + _change(gradient, CHANGE.square, u)) / grown,
        part.low_xi,
        part.high_xi + _change(gradient, CHANGE.width, u),
        part.low_eta,
        part.high_eta + _change(gradient, CHANGE.width + 1, u),
        grown,
        part.side_x + _change(gradient, CHANGE.side, u),
        part.side_y + _change(gradient, CHANGE.side + 1, u),
        part.reach + farther,
        part.cut,
    )
    weight = volume.weight + volume.fading * farther
    return pairs.Volume(moved, weight, volume.footprint, volume.half, volume.fading, volume.finger)


@inner
def _write_leaning_stiffness(
    volume: pairs.Volume,
    gradient: FloatArray,
    contact: pairs.Contact,
    pair: Pair,
    patch: pairs.Patch,
    law: pairs.PairLaw,
    weights: Weights,
    out: FloatArray,
) -> None:
    """Write the derivative of a contact's wrench if its outline moves and its normal turns with the shoe.

    It consists of differences of the law along the exact `gradient` of the overlap. As for other contacts,
    the motion of the shoe's own outline with its rotation is left out.
    """
    shoe = pair.shoe
    unit = pair.unit
    normal = pairs.normal_of(volume.part, unit, law)
    ratio = pairs.FROM_CURVE
    if weights.secant:
        ratio = laws.friction_per_slip(law.coulomb, norm(contact.slip_velocity))
    start = _wrench(contact, normal)
    arm = along(contact.point, -1.0, shoe.r)
    out.fill(0.0)
    for c in range(MOTIONS):
        for by_rate in range(2):
            weight, h = (weights.velocity, RATE_STEP) if by_rate else (weights.position, MOVE_STEP)
            if weight == 0.0 or (c == 3 and not by_rate):
                continue
            changed = volume
            moved = shoe
            if c == 3:
                v = along(shoe.v, -h, cross(normal, arm))
                moved = Frame(shoe.r, shoe.R, v, along(shoe.omega, h, normal))
            elif by_rate:
                moved = Frame(shoe.r, shoe.R, along(shoe.v, h, basis(c)), shoe.omega)
            else:
                axis = turned_back(unit.R, basis(c))
                part = volume.part
                if axis[0] * part.side_x + axis[1] * part.side_y + axis[2] * part.area > 0.0:
                    h = -h  # a small volume grows
                moved = Frame(along(shoe.r, h, basis(c)), shoe.R, shoe.v, shoe.omega)
                changed = _moved(volume, gradient, along((0.0, 0.0, 0.0), h, axis))
            pushed = _wrench(pairs.pair_contact(changed, moved, unit, patch, law, ratio), normal)
            for r in range(MOTIONS):
                out[r, c] += weight * (pushed[r] - start[r]) / h


@inner
def _write_gradient(volume: pairs.Volume, pair: Pair, work: FloatArray, gradient: FloatArray) -> None:
    """Write the gradient of the overlap whose polygon is in `work`.

    A finger keeps the gradient of the whole underside's reach, which sets the fingers' weight.
    """
    reach = (gradient[CHANGE.reach, 0], gradient[CHANGE.reach, 1], gradient[CHANGE.reach, 2])
    down = turned_back(pair.unit.R, frames.upward(pair.shoe.R))
    part = volume.part
    half = volume.half
    along_xi = down[0] / down[2]
    along_eta = down[1] / down[2]
    polygon = work[1 if part.cut > 0 else 0]
    corners = part.cut if part.cut > 0 else 4
    overlap.write_gradient(polygon, corners, part, half[0], half[1], along_xi, along_eta, gradient)
    if volume.finger != pairs.WHOLE:
        for k in range(3):
            gradient[CHANGE.reach, k] = reach[k]


@kernel
def touching_pairs(
    bodies: pair_geometry.BodyStates,
    geometry: pair_geometry.ContactGeometry,
    weights: Weights,
    contacts: UnitContacts,
    work: FloatArray,
) -> int:
    """Write the wrenches, tangents and Jacobians of all contacts; return the number of contacts.

    They come in the order of the shoes, units and fingers. Without weights of position and velocity the
    tangents are not written. `work` is scratch memory; see `overlap_workspace`.
    """
    grid = geometry.outline.grid
    gradient = np.zeros((overlap.GRADIENT, 3))
    count = np.int64(0)
    for s in range(bodies.shoes.shape[0]):
        attitude = rotations.attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
        shoe = rotations.shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], attitude)
        if shoe.R[2][2] < frames.FACING:
            continue
        cells = pair_geometry.cells_below(shoe, geometry.outline)
        for k in range(cells.columns * cells.rows):
            u = cells.first + (k // cells.rows) * grid.rows + k % cells.rows
            unit = rotations.unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis)
            pair = Pair(s, u, shoe, unit, attitude)
            count = _write_pair(pair, bodies, geometry, weights, contacts, work, gradient, count)
    return int(count)


@inner(merged=True)
def _write_pair(
    pair: Pair,
    bodies: pair_geometry.BodyStates,
    geometry: pair_geometry.ContactGeometry,
    weights: Weights,
    contacts: UnitContacts,
    work: FloatArray,
    gradient: FloatArray,
    row: int,
) -> int:
    """Write the contacts of a shoe with a unit from a row on; return the row behind them.

    One contact is that of the whole underside; if its fingers take over, each of them has a contact.
    `gradient` (GRADIENT, 3) is scratch memory.
    """
    outline = geometry.outline
    half = (0.5 * outline.grid.length, 0.5 * outline.grid.width, 0.5 * outline.grid.height)
    part = pairs.pair_overlap(pair.shoe, pair.unit, outline.footprint, half, work)
    if part.area <= 0.0:
        return row
    whole = volume = pair_geometry.whole_volume(part, half, outline)
    sides = geometry.fingers
    for finger in range(1 if whole.weight == 1.0 else 1 + sides.shape[0]):
        if finger > 0:
            length = outline.finger_length
            volume = pair_geometry.finger_volume(finger, sides, whole, pair.shoe, pair.unit, length, work)
        if volume.weight * volume.part.area <= 0.0 or row >= contacts.rows.unit.shape[0]:
            continue
        _write_contact(volume, pair, bodies, geometry, weights, contacts, work, gradient, row)
        row += 1
    return row


@inner(merged=True)
def _write_contact(
    volume: pairs.Volume,
    pair: Pair,
    bodies: pair_geometry.BodyStates,
    geometry: pair_geometry.ContactGeometry,
    weights: Weights,
    contacts: UnitContacts,
    work: FloatArray,
    gradient: FloatArray,
    row: int,
) -> None:
    """Write a contact: its results, its row of forces and, with weights, the tangent of that row."""
    law = geometry.law
    flexible = geometry.flexible
    rows = contacts.rows
    jacobian = rows.jacobian[row, 0]
    rectangle = pairs.NO_PATCH
    patch = pairs.RIGID
    f = flexible.row[pair.shoe_number]
    if f >= 0:
        modes = contacts.modes[row]
        rectangle = pair_geometry.patch_rectangle(volume.part, pair.shoe, pair.unit, volume.half[2])
        mean_rows(flexible.corner, flexible.cell, flexible.integral, rectangle, modes)
        patch = _bend(bodies, f, pair.shoe, modes, jacobian)
    contact = pairs.pair_contact(volume, pair.shoe, pair.unit, patch, law, pairs.FROM_CURVE)
    normal = pairs.normal_of(volume.part, pair.unit, law)
    results = contacts.results[row]
    pairs.keep(contact, pair.shoe_number, pair.unit_number, volume.finger, rectangle, results)
    rows.bodies[row, 0] = pair.shoe_number
    rows.unit[row] = pair.unit_number
    wrench = rows.wrench[row]
    wrench[0], wrench[1], wrench[2], wrench[3] = _wrench(contact, normal)
    tilt_axis = geometry.outline.grid.tilt_axis
    _write_jacobian(contact, normal, pair, tilt_axis, jacobian, rows.unit_jacobian[row])
    tangent = rows.tangent[row]
    if weights.position == 0.0 and weights.velocity == 0.0:
        return
    if volume.fading != 0.0 or pairs.leans(volume.part, law):
        _write_gradient(volume, pair, work, gradient)
        _write_leaning_stiffness(volume, gradient, contact, pair, patch, law, weights, tangent)
    else:
        _write_stiffness(volume, contact, normal, pair, law, weights, tangent)


@kernel
def touching_over_time(
    bodies: pair_geometry.BodyStates,
    geometry: pair_geometry.ContactGeometry,
    contacts: UnitContacts,
    work: FloatArray,
    results: Floats3,
    counts: IntArray,
) -> None:
    """Write the results of all contacts (times, contacts, RESULTS) and their numbers (times,).

    The first dimension of the arrays of `bodies` is time.
    """
    for t in range(counts.shape[0]):
        places = pair_geometry.BodyStates(
            bodies.shoes[t],
            bodies.shoe_rates[t],
            bodies.units[t],
            bodies.unit_rates[t],
            bodies.modal[t],
            bodies.modal_rates[t],
        )
        count = touching_pairs(places, geometry, NO_DERIVATIVES, contacts, work)
        results[t, :count] = contacts.results[:count]
        counts[t] = count
