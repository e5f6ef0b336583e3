"""Contact of spheres under rigid shoes with the top faces of terrain units: forces and derivatives.

The law is that of Exudyn's `GeneralContact`: a force linear in the depth, along the line from the nearest
point of the face to the sphere's centre, with linear damping, and Coulomb friction that rises linearly with
the slip up to its full value. Each face is a rectangle of two triangles; a sphere beside the face touches
its edge, and near the two corners on the diagonal the nearest points of both triangles.

Everything here is compiled and knows nothing of Exudyn.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from exudyn_crawler.ground.rotations import FloatArray, rate_matrix, rotation_matrix

COLUMNS = 20
"""Numbers kept of each touching sphere; see `COLUMN`."""

COLUMN: dict[str, Any] = {
    "shoe": 0,
    "unit": 1,
    "depth": 2,
    "approach": 3,
    "point": slice(4, 7),
    "normal": slice(7, 10),
    "size": 10,
    "slip": slice(11, 14),
    "drag": 14,
    "distance": 15,
    "edge": slice(16, 19),
    "kind": 19,
}
"""Columns of a touching sphere: shoe and unit (from 0), depth (m) and its rate (m/s), point on the face (m),
normal towards the sphere, normal force (N), slip of the shoe over the unit (m/s), friction over slip (N s/m),
distance of the centre from the point (m), direction of the edge it touches, and what it touches: 0 the face,
1 an edge, 2 a corner. Vectors are global."""


@njit(cache=True)
def _nearest_on_segment(x, y, ax, ay, bx, by):
    """Nearest point of a segment: (squared distance, x, y, whether it is inside the segment)."""
    dx, dy = bx - ax, by - ay
    s = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
    inner = 0.0 < s < 1.0
    s = min(1.0, max(0.0, s))
    px, py = ax + s * dx, ay + s * dy
    return (x - px) ** 2 + (y - py) ** 2, px, py, inner


@njit(cache=True)
def _nearest_on_triangle(x, y, corners, found):
    """Nearest edge point of a triangle (3, 2) to a point outside it: x, y, edge direction, kind."""
    best = 1e300
    for k in range(3):
        m = (k + 1) % 3
        ax, ay, bx, by = corners[k, 0], corners[k, 1], corners[m, 0], corners[m, 1]
        distance, px, py, inner = _nearest_on_segment(x, y, ax, ay, bx, by)
        if distance < best:
            best = distance
            length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            found[0], found[1] = px, py
            found[2], found[3] = (bx - ax) / length, (by - ay) / length
            found[4] = 1.0 if inner else 2.0


@njit(cache=True)
def _nearest_on_face(x, y, half_x, half_y, triangle, found):
    """Nearest points of the two triangles of a rectangle about the origin; gives their number."""
    if abs(x) <= half_x and abs(y) <= half_y:
        found[0, 0], found[0, 1], found[0, 4] = x, y, 0.0
        return 1
    # both triangles share the corners (-, -) and (+, +)
    triangle[0, 0], triangle[0, 1] = -half_x, -half_y
    triangle[1, 0], triangle[1, 1] = half_x, -half_y
    triangle[2, 0], triangle[2, 1] = half_x, half_y
    _nearest_on_triangle(x, y, triangle, found[0])
    triangle[1, 0], triangle[1, 1] = -half_x, half_y
    _nearest_on_triangle(x, y, triangle, found[1])
    apart = (found[0, 0] - found[1, 0]) ** 2 + (found[0, 1] - found[1, 1]) ** 2
    return 1 if apart < 1e-20 else 2


@njit(cache=True)
def sphere_contacts(
    shoes: FloatArray,
    shoe_rates: FloatArray,
    units: FloatArray,
    unit_rates: FloatArray,
    tilt_axis: int,
    grid: FloatArray,
    tops: FloatArray,
    places: FloatArray,
    law: FloatArray,
    table: FloatArray,
) -> int:
    """All spheres that touch a unit.

    Parameters
    ----------
    shoes, shoe_rates : array (shoes, 6)
        COM position (m) and angles about x, y, z (rad) of each shoe, and their rates.
    units, unit_rates : array (units, 4)
        Centre position (m) and tilt (rad) of each unit, and their rates. Units count along y first.
    tilt_axis : int
        0 where units roll about x, 1 where they pitch about y.
    grid : array (8,)
        Columns along x, rows along y, unit lengths in x and y, x and y of the grid's corner, and how far
        the faces are drawn back from the units' edges along x and y (m).
    tops : array (units,)
        Height of each unit's face above its centre, m.
    places : array (spheres, 3)
        Centres of the spheres in the shoe's frame, m.
    law : array (5,)
        Stiffness (N/m) and damping (N s/m) of one sphere, radius (m), coefficient of friction, slip speed
        of full friction (m/s).
    table : array (contacts, COLUMNS)
        Out: one row a touching sphere, columns as in `COLUMN`.

    Returns
    -------
    int
        Number of touching spheres.
    """
    stiffness, damping, radius, friction, slow = law[0], law[1], law[2], law[3], law[4]
    columns, rows = int(grid[0]), int(grid[1])
    half_x, half_y = 0.5 * grid[2] - grid[6], 0.5 * grid[3] - grid[7]
    R = np.empty((3, 3))
    G = np.empty((3, 3))
    U = np.empty((3, 3))
    angles = np.zeros(3)
    omega = np.empty(3)
    spin = np.zeros(3)
    center = np.empty(3)
    local = np.empty(3)
    v = np.empty(3)
    triangle = np.empty((3, 2))
    found = np.zeros((2, 5))
    count = 0
    for s in range(shoes.shape[0]):
        rotation_matrix(shoes[s, 3:6], R)
        rate_matrix(shoes[s, 3:6], G)
        for k in range(3):
            omega[k] = 0.0
            for m in range(3):
                omega[k] += G[k, m] * shoe_rates[s, 3 + m]
        for n in range(places.shape[0]):
            for k in range(3):
                center[k] = shoes[s, k]
                for m in range(3):
                    center[k] += R[k, m] * places[n, m]
            i0 = max(0, int(math.floor((center[0] - grid[4] - radius) / grid[2])))
            i1 = min(columns - 1, int(math.floor((center[0] - grid[4] + radius) / grid[2])))
            j0 = max(0, int(math.floor((center[1] - grid[5] - radius) / grid[3])))
            j1 = min(rows - 1, int(math.floor((center[1] - grid[5] + radius) / grid[3])))
            for i in range(i0, i1 + 1):
                for j in range(j0, j1 + 1):
                    u = i * rows + j
                    angles[tilt_axis] = units[u, 3]
                    spin[tilt_axis] = unit_rates[u, 3]
                    rotation_matrix(angles, U)
                    for k in range(3):
                        local[k] = 0.0
                        for m in range(3):
                            local[k] += U[m, k] * (center[m] - units[u, m])
                    above = local[2] - tops[u]
                    if above <= 0.0 or above >= radius:
                        continue
                    touched = _nearest_on_face(local[0], local[1], half_x, half_y, triangle, found)
                    for f in range(touched):
                        gx, gy = local[0] - found[f, 0], local[1] - found[f, 1]
                        distance = math.sqrt(gx * gx + gy * gy + above * above)
                        if distance >= radius or count >= table.shape[0]:
                            continue
                        row = table[count]
                        count += 1
                        row[0], row[1], row[2] = s, u, radius - distance
                        approach = 0.0
                        for k in range(3):
                            normal = (U[k, 0] * gx + U[k, 1] * gy + U[k, 2] * above) / distance
                            row[7 + k] = normal
                            row[4 + k] = center[k] - distance * normal
                            row[16 + k] = U[k, 0] * found[f, 2] + U[k, 1] * found[f, 3]
                        for k in range(3):
                            a, b = (k + 1) % 3, (k + 2) % 3
                            v[k] = (
                                shoe_rates[s, k]
                                + omega[a] * (row[4 + b] - shoes[s, b])
                                - omega[b] * (row[4 + a] - shoes[s, a])
                                - unit_rates[u, k]
                                - spin[a] * (row[4 + b] - units[u, b])
                                + spin[b] * (row[4 + a] - units[u, a])
                            )
                            approach -= v[k] * row[7 + k]
                        speed = 0.0
                        for k in range(3):
                            row[11 + k] = v[k] + approach * row[7 + k]
                            speed += row[11 + k] ** 2
                        size = stiffness * (radius - distance) + damping * approach
                        row[3], row[10], row[15] = approach, size, distance
                        row[14] = friction * size / max(math.sqrt(speed), slow)
                        row[19] = found[f, 4]
    return count


@njit(cache=True)
def sphere_forces(
    shoes: FloatArray,
    units: FloatArray,
    table: FloatArray,
    shoe_forces: FloatArray,
    unit_forces: FloatArray,
) -> None:
    """Sum the touching spheres' forces.

    Parameters
    ----------
    shoes, units : array (shoes, 6), array (units, 4)
        As for `sphere_contacts`.
    table : array (contacts, COLUMNS)
        Touching spheres.
    shoe_forces : array (shoes, 6)
        Out: generalized forces on the shoes' coordinates (N, N m).
    unit_forces : array (units, 6)
        Out: force (N) and moment about the centre (N m) on each unit, global.
    """
    G = np.empty((3, 3))
    force = np.empty(3)
    moment = np.empty(3)
    shoe_forces[:] = 0.0
    unit_forces[:] = 0.0
    for n in range(table.shape[0]):
        row = table[n]
        s, u = int(row[0]), int(row[1])
        for k in range(3):
            force[k] = row[10] * row[7 + k] - row[14] * row[11 + k]
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            moment[k] = (row[4 + a] - shoes[s, a]) * force[b] - (row[4 + b] - shoes[s, b]) * force[a]
            shoe_forces[s, k] += force[k]
            unit_forces[u, k] -= force[k]
            unit_forces[u, 3 + k] -= (row[4 + a] - units[u, a]) * force[b]
            unit_forces[u, 3 + k] += (row[4 + b] - units[u, b]) * force[a]
        rate_matrix(shoes[s, 3:6], G)
        for k in range(3):
            for m in range(3):
                shoe_forces[s, 3 + k] += G[m, k] * moment[m]


@njit(cache=True)
def _lever(shoe, unit, tilt_axis, place, G, out):
    """Motion of a place on the shoe less that on the unit, by the pair's coordinates: out (3, 8)."""
    out[:] = 0.0
    for k in range(3):
        out[k, k] = 1.0
        a, b = (k + 1) % 3, (k + 2) % 3
        for c in range(3):
            out[k, 3 + c] = G[a, c] * (place[b] - shoe[b]) - G[b, c] * (place[a] - shoe[a])
    out[2, 6] = -1.0
    a, b = (tilt_axis + 1) % 3, (tilt_axis + 2) % 3
    out[a, 7] = place[b] - unit[b]
    out[b, 7] = -(place[a] - unit[a])


@njit(cache=True)
def _turn_axes(shoe, point, force, factor, block):
    """Add what the generalized moments on a shoe change by as the axes of its angles turn."""
    ca, sa = math.cos(shoe[3]), math.sin(shoe[3])
    cb, sb = math.cos(shoe[4]), math.sin(shoe[4])
    x, y, z = point[0] - shoe[0], point[1] - shoe[1], point[2] - shoe[2]
    mx = factor * (y * force[2] - z * force[1])
    my = factor * (z * force[0] - x * force[2])
    mz = factor * (x * force[1] - y * force[0])
    block[4, 3] += -sa * my + ca * mz
    block[5, 3] += -ca * cb * my - sa * cb * mz
    block[5, 4] += cb * mx + sa * sb * my - ca * sb * mz


@njit(cache=True)
def sphere_derivatives(
    shoes: FloatArray,
    units: FloatArray,
    tilt_axis: int,
    law: FloatArray,
    table: FloatArray,
    position_factor: float,
    velocity_factor: float,
    secant: bool,
    pairs: FloatArray,
    blocks: FloatArray,
) -> int:
    """Derivatives of the forces, one block a pair of shoe and unit.

    Parameters
    ----------
    position_factor, velocity_factor : float
        A block is `position_factor` times the derivative by the pair's coordinates plus `velocity_factor`
        times the one by their rates.
    secant : bool
        Keep the ratio of friction to slip as it is instead of deriving it.
    pairs : array (contacts, 2)
        Out: indices of the shoe and the unit of each block.
    blocks : array (contacts, >= 8, >= 8)
        Out: derivatives of (generalized force on the shoe, force in z and tilting moment on the unit) by
        (the shoe's coordinates, heave and tilt of the unit).

    Other parameters as for `sphere_contacts` and `sphere_forces`.

    Returns
    -------
    int
        Number of pairs.

    Notes
    -----
    The change of the slip with the places is left out: it is far smaller than what it stands beside.
    """
    stiffness, damping, slow = law[0], law[1], law[4]
    G = np.empty((3, 3))
    by_place = np.empty((3, 3))
    by_speed = np.empty((3, 3))
    moved = np.empty((3, 8))
    lever = np.empty((3, 8))
    changed = np.empty((3, 8))
    on_shoe = np.empty((3, 8))
    on_unit = np.empty((3, 8))
    center = np.empty(3)
    force = np.empty(3)
    spin = np.zeros(3)
    spin[tilt_axis] = 1.0
    count = 0
    for n in range(table.shape[0]):
        row = table[n]
        s, u = int(row[0]), int(row[1])
        p = 0
        while p < count and not (pairs[p, 0] == s and pairs[p, 1] == u):
            p += 1
        if p == count:
            if count >= blocks.shape[0]:
                continue
            count += 1
            pairs[p, 0], pairs[p, 1] = s, u
            blocks[p] = 0.0
        normal, slip, edge = row[7:10], row[11:14], row[16:19]
        speed = math.sqrt(slip[0] ** 2 + slip[1] ** 2 + slip[2] ** 2)
        ratio = row[14] / row[10] if row[10] != 0.0 else 0.0
        for k in range(3):
            for m in range(3):
                one = 1.0 if k == m else 0.0
                push = (normal[k] - ratio * slip[k]) * normal[m]
                turn = 0.0
                if row[19] > 0.0:
                    turn = one - normal[k] * normal[m]
                    if row[19] == 1.0:
                        turn -= edge[k] * edge[m]
                across = one - normal[k] * normal[m]
                if speed > slow and not secant:
                    across -= slip[k] * slip[m] / speed**2
                by_place[k, m] = -stiffness * push + row[10] / row[15] * turn
                by_speed[k, m] = -damping * push - row[14] * across
        rate_matrix(shoes[s, 3:6], G)
        for k in range(3):
            center[k] = row[4 + k] + row[15] * normal[k]
        _lever(shoes[s], units[u], tilt_axis, center, G, moved)
        _lever(shoes[s], units[u], tilt_axis, row[4:7], G, lever)
        for k in range(3):
            for c in range(8):
                total = 0.0
                for m in range(3):
                    total += position_factor * by_place[k, m] * moved[m, c]
                    total += velocity_factor * by_speed[k, m] * lever[m, c]
                changed[k, c] = total
            # the normal turns with the unit
            a, b = (k + 1) % 3, (k + 2) % 3
            turned = spin[a] * normal[b] - spin[b] * normal[a]
            changed[k, 7] += position_factor * row[10] * turned
        for r in range(8):
            for c in range(8):
                for k in range(3):
                    blocks[p, r, c] += lever[k, r] * changed[k, c]
        for k in range(3):
            force[k] = row[10] * normal[k] - row[14] * slip[k]
        _turn_axes(shoes[s], row[4:7], force, position_factor, blocks[p])
        # what the forces do about the COM and the unit's centre as the point wanders
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            turned = spin[a] * normal[b] - spin[b] * normal[a]
            for c in range(8):
                back = 0.0
                for m in range(3):
                    one = 1.0 if k == m else 0.0
                    held = normal[k] * normal[m]
                    if row[19] > 0.0:
                        held = one - (edge[k] * edge[m] if row[19] == 1.0 else 0.0)
                    back += held * moved[m, c]
                if c == 7:
                    back += row[15] * turned
                own = moved[k, c] if c < 6 else 0.0
                on_shoe[k, c] = (own if c > 2 else 0.0) - back
                on_unit[k, c] = own - back - (1.0 if k == 2 and c == 6 else 0.0)
        for c in range(8):
            for k in range(3):
                a, b = (k + 1) % 3, (k + 2) % 3
                moment = position_factor * (on_shoe[a, c] * force[b] - on_shoe[b, c] * force[a])
                for r in range(3):
                    blocks[p, 3 + r, c] += G[k, r] * moment
            a, b = (tilt_axis + 1) % 3, (tilt_axis + 2) % 3
            moment = on_unit[a, c] * force[b] - on_unit[b, c] * force[a]
            blocks[p, 7, c] -= position_factor * moment
    return count
