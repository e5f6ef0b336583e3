"""Contact of shoes with terrain units: forces of every overlapping pair and their derivatives.

One contact per pair of a shoe and a unit that overlap. It acts at the centroid of the overlap volume,
along the normal of the unit's top face with the IMPACT law, across it with Coulomb friction and about
it with the friction torque; the unit receives the opposite of all that the shoe receives. Where the shoe is
flexible, the mean displacement of the patch of its underside over the unit adds to its rigid motion.

Everything here is compiled and knows nothing of Exudyn: arrays of coordinates in, generalized forces
and their derivatives out.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from exudyn_crawler.ground.laws import (
    equal_area_radius,
    friction_per_slip,
    friction_torque,
    impact_force,
    step,
)
from exudyn_crawler.ground.overlap import overlap
from exudyn_crawler.ground.rotations import FloatArray, rate_matrix, rotation_matrix
from fem.patches import mean_rows

PAIR_COORDINATES = 11
"""Coordinates that one pair's forces depend on: six of the shoe, heave and tilt of the unit, and three of
the displacement of a flexible shoe's patch in its own axes."""

RESULTS = 20
"""Numbers kept of each contact; see `RESULT`."""

RESULT: dict[str, Any] = {
    "shoe": 0,
    "unit": 1,
    "penetration": 2,
    "penetration_rate": 3,
    "area": 4,
    "point": slice(5, 8),
    "normal_force": slice(8, 11),
    "friction_force": slice(11, 14),
    "slip_velocity": slice(14, 17),
    "friction_torque": slice(17, 20),
}
"""Columns of a contact's results. Vectors are global; forces and torque act on the shoe; the slip
velocity is the shoe's relative to the unit."""

POSITION_STEP = 1e-7
"""Difference step (m, rad) for derivatives: far below the 0.1 mm of the damping law."""
VELOCITY_STEP = 1e-6
"""Difference step (m/s, rad/s): far below the 10 mm/s of the friction law."""


@njit(cache=True)
def _geometry(shoe, unit, tilt_axis, footprint, half, corners, work, R):
    """Overlap of one pair with the shoe taken as rigid; writes the shoe's rotation matrix into `R`.

    Returns (area, width, depth, px, py, pz, nx, ny, nz, bounds): point and normal global, bounds of the
    overlap in the unit's frame.
    """
    rotation_matrix(shoe[3:6], R)
    ct, st = math.cos(unit[3]), math.sin(unit[3])
    for k in range(4):
        bx = footprint[0] if k == 0 or k == 3 else footprint[1]
        by = footprint[2] if k < 2 else footprint[3]
        bz = footprint[4]
        x = shoe[0] + R[0, 0] * bx + R[0, 1] * by + R[0, 2] * bz - unit[0]
        y = shoe[1] + R[1, 0] * bx + R[1, 1] * by + R[1, 2] * bz - unit[1]
        z = shoe[2] + R[2, 0] * bx + R[2, 1] * by + R[2, 2] * bz - unit[2]
        if tilt_axis == 1:  # pitch about y
            corners[k, 0] = ct * x - st * z
            corners[k, 1] = y
            corners[k, 2] = half[2] - (st * x + ct * z)
        else:  # roll about x
            corners[k, 0] = x
            corners[k, 1] = ct * y + st * z
            corners[k, 2] = half[2] - (ct * z - st * y)
    area, xi, eta, depth, bounds = overlap(corners, half[0], half[1], work)
    width = min(bounds[1] - bounds[0], bounds[3] - bounds[2])
    zeta = half[2] - 0.5 * depth
    if tilt_axis == 1:
        px = unit[0] + ct * xi + st * zeta
        py = unit[1] + eta
        pz = unit[2] - st * xi + ct * zeta
        nx, ny, nz = st, 0.0, ct
    else:
        px = unit[0] + xi
        py = unit[1] + ct * eta - st * zeta
        pz = unit[2] + st * eta + ct * zeta
        nx, ny, nz = 0.0, -st, ct
    return area, width, depth, px, py, pz, nx, ny, nz, bounds


@njit(cache=True)
def _forces(
    geometry, R, shoe, shoe_rate, patch, unit, unit_rate, tilt_axis, law, drag_ratio, G, generalized, result
):
    """Law of one pair at a known overlap.

    `patch` holds displacement and velocity of the underside's patch in the shoe's axes (6). Writes the
    generalized forces on the shoe (6), the wrench on the unit about its centre (force 3, moment 3) and the
    force on the patch in the shoe's axes (3) into `generalized` (15), and the contact's results into
    `result`. A `drag_ratio` (s/m, friction over normal force and slip speed) that is not negative takes
    the place of the friction curve's.
    """
    area, width, depth, px, py, pz, nx, ny, nz, _ = geometry
    rate_matrix(shoe[3:6], G)
    wx = G[0, 0] * shoe_rate[3] + G[0, 1] * shoe_rate[4] + G[0, 2] * shoe_rate[5]
    wy = G[1, 0] * shoe_rate[3] + G[1, 1] * shoe_rate[4] + G[1, 2] * shoe_rate[5]
    wz = G[2, 0] * shoe_rate[3] + G[2, 1] * shoe_rate[4] + G[2, 2] * shoe_rate[5]
    ax, ay, az = px - shoe[0], py - shoe[1], pz - shoe[2]
    bx, by, bz = px - unit[0], py - unit[1], pz - unit[2]
    ux = unit_rate[3] if tilt_axis == 0 else 0.0
    uy = unit_rate[3] if tilt_axis == 1 else 0.0
    vx = shoe_rate[0] + wy * az - wz * ay - (unit_rate[0] + uy * bz)
    vy = shoe_rate[1] + wz * ax - wx * az - (unit_rate[1] - ux * bz)
    vz = shoe_rate[2] + wx * ay - wy * ax - (unit_rate[2] + ux * by - uy * bx)
    dx = R[0, 0] * patch[0] + R[0, 1] * patch[1] + R[0, 2] * patch[2]
    dy = R[1, 0] * patch[0] + R[1, 1] * patch[1] + R[1, 2] * patch[2]
    dz = R[2, 0] * patch[0] + R[2, 1] * patch[1] + R[2, 2] * patch[2]
    vx += R[0, 0] * patch[3] + R[0, 1] * patch[4] + R[0, 2] * patch[5]
    vy += R[1, 0] * patch[3] + R[1, 1] * patch[4] + R[1, 2] * patch[5]
    vz += R[2, 0] * patch[3] + R[2, 1] * patch[4] + R[2, 2] * patch[5]
    depth -= nx * dx + ny * dy + nz * dz
    vn = vx * nx + vy * ny + vz * nz
    tx, ty, tz = vx - vn * nx, vy - vn * ny, vz - vn * nz
    slip = math.sqrt(tx * tx + ty * ty + tz * tz)
    spin = (wx - ux) * nx + (wy - uy) * ny + wz * nz

    normal = impact_force(depth, -vn, law[0], law[1], law[2], law[3])
    # share of the law that this pair has, by the width or by the area of its overlap
    normal *= step(width, 0.0, 0.0, law[8], 1.0) if law[9] == 0.0 else area / law[9]
    if drag_ratio < 0.0:
        drag_ratio = friction_per_slip(slip, law[4], law[5], law[6], law[7])
    drag = drag_ratio * normal
    torque = friction_torque(spin, equal_area_radius(area), drag * slip, law[6])

    fx, fy, fz = normal * nx - drag * tx, normal * ny - drag * ty, normal * nz - drag * tz
    mx = ay * fz - az * fy + torque * nx
    my = az * fx - ax * fz + torque * ny
    mz = ax * fy - ay * fx + torque * nz
    generalized[0] = fx
    generalized[1] = fy
    generalized[2] = fz
    for k in range(3):
        generalized[3 + k] = G[0, k] * mx + G[1, k] * my + G[2, k] * mz
        generalized[12 + k] = R[0, k] * fx + R[1, k] * fy + R[2, k] * fz
    generalized[6] = -fx
    generalized[7] = -fy
    generalized[8] = -fz
    generalized[9] = -(by * fz - bz * fy + torque * nx)
    generalized[10] = -(bz * fx - bx * fz + torque * ny)
    generalized[11] = -(bx * fy - by * fx + torque * nz)

    result[2] = depth
    result[3] = -vn
    result[4] = area
    result[5] = px
    result[6] = py
    result[7] = pz
    result[8] = normal * nx
    result[9] = normal * ny
    result[10] = normal * nz
    result[11] = -drag * tx
    result[12] = -drag * ty
    result[13] = -drag * tz
    result[14] = tx
    result[15] = ty
    result[16] = tz
    result[17] = torque * nx
    result[18] = torque * ny
    result[19] = torque * nz


@njit(cache=True)
def _unit_range(shoe, footprint, R, grid):
    """Columns and rows of the units that may lie under a shoe (inclusive bounds)."""
    rotation_matrix(shoe[3:6], R)
    reach_x = abs(R[0, 0]) * max(abs(footprint[0]), abs(footprint[1])) + abs(R[0, 1]) * max(
        abs(footprint[2]), abs(footprint[3])
    )
    reach_y = abs(R[1, 0]) * max(abs(footprint[0]), abs(footprint[1])) + abs(R[1, 1]) * max(
        abs(footprint[2]), abs(footprint[3])
    )
    # pitch and tilt move the underside's corners by their height times the angle
    reach_x += abs(R[0, 2] * footprint[4]) + 0.02 * grid[2]
    reach_y += abs(R[1, 2] * footprint[4]) + 0.02 * grid[2]
    columns, rows = int(grid[0]), int(grid[1])
    x, y = shoe[0] - grid[5], shoe[1] - grid[6]
    i0 = max(0, int(math.floor((x - reach_x) / grid[2])))
    i1 = min(columns - 1, int(math.floor((x + reach_x) / grid[2])))
    j0 = max(0, int(math.floor((y - reach_y) / grid[3])))
    j1 = min(rows - 1, int(math.floor((y + reach_y) / grid[3])))
    return i0, i1, j0, j1


@njit(cache=True)
def _patch_motion(geometry, R, shoe, unit, tilt_axis, flexible, modal, modal_rate, rows, patch):
    """Write mean rows of a flexible shoe's patch, and its displacement and velocity in the shoe's axes.

    The patch is the rectangle in the shoe's axes about the overlap's bounds.
    """
    corner, cell, integral, _ = flexible
    low_xi, high_xi, low_eta, high_eta = geometry[9]
    half_xi, half_eta = 0.5 * (high_xi - low_xi), 0.5 * (high_eta - low_eta)
    x = unit[0] + 0.5 * (low_xi + high_xi) - shoe[0]
    y = unit[1] + 0.5 * (low_eta + high_eta) - shoe[1]
    z = geometry[5] - shoe[2]
    cx = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
    cy = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
    hx = abs(R[0, 0]) * half_xi + abs(R[1, 0]) * half_eta
    hy = abs(R[0, 1]) * half_xi + abs(R[1, 1]) * half_eta
    mean_rows(corner, cell, integral, cx - hx, cx + hx, cy - hy, cy + hy, rows)
    for c in range(3):
        displacement = 0.0
        velocity = 0.0
        for k in range(rows.shape[1]):
            displacement += rows[c, k] * modal[k]
            velocity += rows[c, k] * modal_rate[k]
        patch[c] = displacement
        patch[3 + c] = velocity


@njit(cache=True)
def contact_forces(
    shoes: FloatArray,
    shoe_rates: FloatArray,
    units: FloatArray,
    unit_rates: FloatArray,
    modal: FloatArray,
    modal_rates: FloatArray,
    flexible: tuple,
    tilt_axis: int,
    grid: FloatArray,
    footprint: FloatArray,
    law: FloatArray,
    shoe_forces: FloatArray,
    unit_forces: FloatArray,
    modal_forces: FloatArray,
    results: FloatArray,
    work: FloatArray,
) -> int:
    """Forces of all contacts between the shoes and the terrain units.

    Parameters
    ----------
    shoes, shoe_rates : array (shoes, 6)
        COM position (m) and angles about x, y, z (rad) of each shoe, and their rates.
    units, unit_rates : array (units, 4)
        Centre position (m) and tilt (rad) of each unit, and their rates. Units count along y
        first.
    modal, modal_rates : array (flexible shoes, modes)
        Modal coordinates of the flexible shoes, and their rates.
    flexible : tuple
        Corner, cell and integral of the flexible undersides (`underside.Underside`) and, for every shoe,
        its row in `modal`, or -1 where it is rigid.
    tilt_axis : int
        0 where units roll about x, 1 where they pitch about y.
    grid : array (7,)
        Columns along x, rows along y, unit lengths in x, y, z (m), x and y of the grid's corner (m).
    footprint : array (5,)
        Underside in the shoe's frame: least x, greatest x, least y, greatest y, z (m).
    law : array (10,)
        Contact law as of `PairContact.as_array`.
    shoe_forces : array (shoes, 6)
        Out: generalized forces on the shoes' coordinates (N, N m).
    unit_forces : array (units, 6)
        Out: force (N) and moment about the centre (N m) on each unit, global.
    modal_forces : array (flexible shoes, modes)
        Out: modal forces.
    results : array (contacts, RESULTS)
        Out: one row a contact, columns as in `RESULT`.
    work : array (2, 12, 3)
        Scratch memory.

    Returns
    -------
    int
        Number of contacts; more than `results` has rows where some did not fit in.
    """
    corners = np.empty((4, 3))
    R = np.empty((3, 3))
    G = np.empty((3, 3))
    half = 0.5 * grid[2:5]
    generalized = np.empty(15)
    spare = np.empty(RESULTS)
    rigid = np.zeros(6)
    patch = np.zeros(6)
    mean = np.zeros((3, modal.shape[1]))
    shoe_forces[:] = 0.0
    unit_forces[:] = 0.0
    modal_forces[:] = 0.0
    rows = int(grid[1])
    count = 0
    for s in range(shoes.shape[0]):
        f = flexible[3][s]
        i0, i1, j0, j1 = _unit_range(shoes[s], footprint, R, grid)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                u = i * rows + j
                geometry = _geometry(shoes[s], units[u], tilt_axis, footprint, half, corners, work, R)
                if geometry[0] <= 0.0:
                    continue
                if f >= 0:
                    _patch_motion(
                        geometry,
                        R,
                        shoes[s],
                        units[u],
                        tilt_axis,
                        flexible,
                        modal[f],
                        modal_rates[f],
                        mean,
                        patch,
                    )
                row = results[count] if count < results.shape[0] else spare
                _forces(
                    geometry,
                    R,
                    shoes[s],
                    shoe_rates[s],
                    patch if f >= 0 else rigid,
                    units[u],
                    unit_rates[u],
                    tilt_axis,
                    law,
                    -1.0,
                    G,
                    generalized,
                    row,
                )
                row[0] = s
                row[1] = u
                count += 1
                for k in range(6):
                    shoe_forces[s, k] += generalized[k]
                    unit_forces[u, k] += generalized[6 + k]
                if f >= 0:
                    for c in range(3):
                        for k in range(mean.shape[1]):
                            modal_forces[f, k] += mean[c, k] * generalized[12 + c]
    return count


@njit(cache=True)
def _difference(moved, base, factor, tilt_moment, block, column):
    """Add weighted force differences to a column of a pair's block."""
    for k in range(6):
        block[k, column] += factor * (moved[k] - base[k])
    block[6, column] += factor * (moved[8] - base[8])
    block[7, column] += factor * (moved[tilt_moment] - base[tilt_moment])
    for k in range(3):
        block[8 + k, column] += factor * (moved[12 + k] - base[12 + k])


@njit(cache=True)
def contact_derivatives(
    shoes: FloatArray,
    shoe_rates: FloatArray,
    units: FloatArray,
    unit_rates: FloatArray,
    modal: FloatArray,
    modal_rates: FloatArray,
    flexible: tuple,
    tilt_axis: int,
    grid: FloatArray,
    footprint: FloatArray,
    law: FloatArray,
    position_factor: float,
    velocity_factor: float,
    secant: bool,
    pairs: FloatArray,
    blocks: FloatArray,
    patch_rows: FloatArray,
    work: FloatArray,
) -> int:
    """Derivatives of the contact forces, one block a pair.

    Parameters
    ----------
    position_factor, velocity_factor : float
        A block is `position_factor` times the derivative with respect to the pair's coordinates
        plus `velocity_factor` times the one with respect to their rates.
    secant : bool
        Keep the ratio of friction to slip as it is instead of deriving it. Newton's method can cycle
        between the steep rise of the friction curve and its fall beyond; with the secant it converges
        more slowly, but does.
    pairs : array (contacts, 2)
        Out: indices of the shoe and the unit of each block.
    blocks : array (contacts, 11, 11)
        Out: derivatives of (generalized force on the shoe, force in z and tilting moment on the
        unit, force on the patch in the shoe's axes) by (the shoe's coordinates, heave and tilt of the
        unit, displacement of the patch in the shoe's axes). The patch's are zero for rigid shoes.
    patch_rows : array (contacts, 3, modes)
        Out: mean displacement rows of flexible shoes' patches.

    Other parameters as for `contact_forces`.

    Returns
    -------
    int
        Number of contacts.

    Notes
    -----
    One-sided differences: exact derivatives of the clipping would take as many lines as the
    clipping, and the error of 1e-6 relative costs Newton's method nothing.
    """
    corners = np.empty((4, 3))
    R = np.empty((3, 3))
    G = np.empty((3, 3))
    half = 0.5 * grid[2:5]
    base = np.empty(15)
    moved = np.empty(15)
    spare = np.empty(RESULTS)
    shoe = np.empty(6)
    shoe_rate = np.empty(6)
    unit = np.empty(4)
    unit_rate = np.empty(4)
    patch = np.empty(6)
    rows = int(grid[1])
    tilt_moment = 9 if tilt_axis == 0 else 10
    count = 0
    for s in range(shoes.shape[0]):
        f = flexible[3][s]
        i0, i1, j0, j1 = _unit_range(shoes[s], footprint, R, grid)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                u = i * rows + j
                geometry = _geometry(shoes[s], units[u], tilt_axis, footprint, half, corners, work, R)
                if geometry[0] <= 0.0 or count >= blocks.shape[0]:
                    continue
                shoe[:] = shoes[s]
                shoe_rate[:] = shoe_rates[s]
                unit[:] = units[u]
                unit_rate[:] = unit_rates[u]
                patch[:] = 0.0
                if f >= 0:
                    _patch_motion(
                        geometry,
                        R,
                        shoe,
                        unit,
                        tilt_axis,
                        flexible,
                        modal[f],
                        modal_rates[f],
                        patch_rows[count],
                        patch,
                    )
                _forces(
                    geometry, R, shoe, shoe_rate, patch, unit, unit_rate, tilt_axis, law, -1.0, G, base, spare
                )
                drag_ratio = -1.0
                if secant:
                    slip = math.sqrt(spare[14] ** 2 + spare[15] ** 2 + spare[16] ** 2)
                    drag_ratio = friction_per_slip(slip, law[4], law[5], law[6], law[7])
                block = blocks[count]
                block[:] = 0.0
                pairs[count, 0] = s
                pairs[count, 1] = u
                for c in range(8):
                    vector, vector_rate = (shoe, shoe_rate) if c < 6 else (unit, unit_rate)
                    index = c if c < 6 else c - 4
                    old = vector[index]
                    vector[index] = old + POSITION_STEP
                    moved_geometry = _geometry(shoe, unit, tilt_axis, footprint, half, corners, work, R)
                    if moved_geometry[0] > 0.0:
                        _forces(
                            moved_geometry,
                            R,
                            shoe,
                            shoe_rate,
                            patch,
                            unit,
                            unit_rate,
                            tilt_axis,
                            law,
                            drag_ratio,
                            G,
                            moved,
                            spare,
                        )
                    else:
                        moved[:] = 0.0
                    vector[index] = old
                    _difference(moved, base, position_factor / POSITION_STEP, tilt_moment, block, c)
                rotation_matrix(shoe[3:6], R)
                for c in range(8):
                    vector_rate = shoe_rate if c < 6 else unit_rate
                    index = c if c < 6 else c - 4
                    old = vector_rate[index]
                    vector_rate[index] = old + VELOCITY_STEP
                    _forces(
                        geometry,
                        R,
                        shoe,
                        shoe_rate,
                        patch,
                        unit,
                        unit_rate,
                        tilt_axis,
                        law,
                        drag_ratio,
                        G,
                        moved,
                        spare,
                    )
                    vector_rate[index] = old
                    _difference(moved, base, velocity_factor / VELOCITY_STEP, tilt_moment, block, c)
                if f >= 0:
                    for c in range(6):
                        size = POSITION_STEP if c < 3 else VELOCITY_STEP
                        factor = position_factor if c < 3 else velocity_factor
                        old = patch[c]
                        patch[c] = old + size
                        _forces(
                            geometry,
                            R,
                            shoe,
                            shoe_rate,
                            patch,
                            unit,
                            unit_rate,
                            tilt_axis,
                            law,
                            drag_ratio,
                            G,
                            moved,
                            spare,
                        )
                        patch[c] = old
                        _difference(moved, base, factor / size, tilt_moment, block, 8 + c % 3)
                count += 1
    return count
