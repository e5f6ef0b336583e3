"""Bodies: inertia, elasticity and weight of rigid bodies and of bodies in a floating frame of reference.

A point of the body is at ``r + R (x + Psi z)``: r and R are the pose of the frame, z the modal coordinates
and Psi the mode shapes. Its acceleration in the frame's axes is
``R^T r'' + Omega p + 2 omega x Psi z' + Psi z''`` with ``p = x + Psi z`` and
``Omega = alpha~ + omega~ omega~``. Integrals of it over the mass, alone,
times p and times Psi, give force, moment and modal forces. The integrals of the shapes are constant; no term
is neglected (Shabana, Dynamics of Multibody Systems, chapter 5). A rigid body is one without modes.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, basis, cross, dot, turned, turned_back
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, Ints1
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.ground.rows import Weights


class Bodies(NamedTuple):
    """Table of all bodies of a system: b of them, shoes first."""

    coordinate: Ints1  # (b,): first of the six coordinates of each, position and angles
    modal: Ints1  # (b,): first of its modal coordinates, -1 for a rigid body
    reference: Floats2  # (b, 6): position (m, global) and angles (rad) where its coordinates are zero
    mass: Floats1  # (b,): kg
    first: Floats2  # (b, 3): integral over the mass of the places x in the body's frame, kg m
    second: Floats3  # (b, 3, 3): of x_a x_b, kg m2
    # (b, 2, 3): cosines and sines of the angles, from `write_angles`; every attitude is read from these
    of_angles: Floats3


class Modes(NamedTuple):
    """Modes that all flexible bodies share, m of modal mass 1, and their integrals over the mass."""

    stiffness: Floats1  # (m,): 1/s2
    damping: Floats1  # (m,): 1/s
    shapes: Floats2  # (3, m): integral of the mode shapes
    places: Floats2  # (9, m): of x_a Psi_ck over (a, c) and k
    products: Floats2  # (m, 9 m): of Psi_aj Psi_ck over j and (a, c, k)


def second_moment(mass: float, inertia: FloatArray, center: FloatArray) -> FloatArray:
    """Return the integral of x_a x_b over a mass (kg): array (3, 3), kg m2.

    `inertia` (3, 3) is about the centre of mass, kg m2; `center` (3,) is the position of that centre, m.
    """
    return 0.5 * np.trace(inertia) * np.eye(3) - inertia + mass * np.outer(center, center)


class Inertia(NamedTuple):
    """Integrals over the mass of a deformed body, in its frame; workspace."""

    first: FloatArray  # (3,): of the places p, kg m
    second: FloatArray  # (3, 3): of p_a p_b, kg m2
    turning: FloatArray  # (3, m): of p x Psi, the moment of unit modal accelerations


@inner
def moved(place: Vector, shapes: FloatArray, row: FloatArray) -> Vector:
    """Return a point (m, body's frame) displaced by shapes (3, m) at coordinates and modes (6 + m,)."""
    x, y, z = place
    for k in range(shapes.shape[1]):
        x += shapes[0, k] * row[6 + k]
        y += shapes[1, k] * row[6 + k]
        z += shapes[2, k] * row[6 + k]
    return x, y, z


@inner
def _moment_of(tensor: FloatArray) -> Vector:
    """Return the moment of ``integral p_a f_c``."""
    return tensor[1, 2] - tensor[2, 1], tensor[2, 0] - tensor[0, 2], tensor[0, 1] - tensor[1, 0]


class Motion(NamedTuple):
    """Motion of a body's frame in its own axes."""

    omega: Vector  # rad/s
    turning: Matrix  # rows of Omega, 1/s2
    acceleration: Vector  # of the origin less that of gravity, m/s2


@inner
def _motion(attitude: Attitude, state: FloatArray, gravity: Vector) -> Motion:
    """Return the motion of the frame of a body at its coordinates, rates and accelerations (3, 6 + m)."""
    rates = (state[1, 3], state[1, 4], state[1, 5])
    w = turned_back(attitude.R, rotations.spin(attitude, rates))
    al = turned_back(
        attitude.R, rotations.spin_rate(attitude, rates, (state[2, 3], state[2, 4], state[2, 5]))
    )
    w2 = dot(w, w)
    turning = (
        (w[0] * w[0] - w2, w[0] * w[1] - al[2], w[0] * w[2] + al[1]),
        (w[1] * w[0] + al[2], w[1] * w[1] - w2, w[1] * w[2] - al[0]),
        (w[2] * w[0] - al[1], w[2] * w[1] + al[0], w[2] * w[2] - w2),
    )
    upward = along((state[2, 0], state[2, 1], state[2, 2]), -1.0, gravity)
    return Motion(w, turning, turned_back(attitude.R, upward))


@inner(merged=True)
def _sums(row: FloatArray, still: FloatArray, z: FloatArray) -> tuple[float, float, float, float]:
    """Return sums of a row (m,) times modal coordinates, rates and accelerations (3, m).

    The fourth sum is that of the row `still` times the coordinates. All four grow at once, because each has
    to wait for its last term.
    """
    place = rate = second = other = 0.0
    for k in range(row.shape[0]):
        place += row[k] * z[0, k]
        rate += row[k] * z[1, k]
        second += row[k] * z[2, k]
        other += still[k] * z[0, k]
    return place, rate, second, other


@inner(allocates=True)
def _bend(
    modes: Modes,
    state: FloatArray,
    motion: Motion,
    residual: FloatArray,
    inertia: Inertia,
    tensor: FloatArray,
) -> Vector:
    """Add inertia and elastic forces of the modes, and their part of the body's integrals.

    `tensor` (3, 3) gathers ``integral p_a f_c`` of inertia forces f. Return the force of the modes' motion,
    N, in the body's axes.
    """
    m = modes.stiffness.shape[0]
    z = state[:3, 6:].copy()
    force = (0.0, 0.0, 0.0)
    # over (a, c) and k: integrals of p_a Psi_ck, here without x_a, and of those of velocities Psi z' with Psi
    sums = np.dot(z[:2], modes.products)
    forces = residual[6:]
    for k in range(m):
        forces[k] += z[2, k] + modes.stiffness[k] * z[0, k] + modes.damping[k] * z[1, k]
    for a in range(3):
        shape = modes.shapes[a]
        acceleration = motion.acceleration[a]
        swirl = cross(motion.omega, basis(a))
        for k in range(m):
            forces[k] += shape[k] * acceleration
        place, rate, second, _ = _sums(shape, shape, z)
        inertia.first[a] += place
        force = along(along(force, second, basis(a)), 2.0 * rate, swirl)
        for c in range(3):
            n = 3 * a + c
            lever = sums[0, n * m : n * m + m]
            speed = sums[1, n * m : n * m + m]
            still = modes.places[n]
            # of the turning frame, and 2 omega x Psi z'
            turning = motion.turning[c][a]
            spin = 2.0 * swirl[c]
            for k in range(m):
                lever[k] += still[k]
                forces[k] += lever[k] * turning + speed[k] * spin
            place, rate, second, other = _sums(lever, still, z)
            inertia.second[a, c] += place
            inertia.second[c, a] += other
            tensor[a, c] += second
            around = cross(motion.omega, basis(c))
            for d in range(3):
                tensor[a, d] += 2.0 * rate * around[d]
    for a in range(3):
        b, c = (a + 1) % 3 * 3 + (a + 2) % 3, (a + 2) % 3 * 3 + (a + 1) % 3
        for k in range(m):
            inertia.turning[a, k] = sums[0, b * m + k] - sums[0, c * m + k]
    return force


@inner
def add_body_matrix(
    bodies: Bodies,
    b: int,
    modes: Modes,
    attitude: Attitude,
    inertia: Inertia,
    weights: Weights,
    first_row: int,
    matrix: FloatArray,
) -> None:
    """Add the weighted mass, stiffness and damping of a body to a matrix, from a row and column on."""
    x = first_row
    factor = weights.acceleration
    mass = bodies.mass[b]
    trace = inertia.second[0, 0] + inertia.second[1, 1] + inertia.second[2, 2]
    first = turned(attitude.R, (inertia.first[0], inertia.first[1], inertia.first[2]))
    for j in range(3):
        matrix[x + j, x + j] += factor * mass
        axis = attitude.axes[j]
        lever = cross(axis, first)
        local = turned_back(attitude.R, axis)
        row = inertia.second
        moment = (
            trace * local[0] - row[0, 0] * local[0] - row[0, 1] * local[1] - row[0, 2] * local[2],
            trace * local[1] - row[1, 0] * local[0] - row[1, 1] * local[1] - row[1, 2] * local[2],
            trace * local[2] - row[2, 0] * local[0] - row[2, 1] * local[1] - row[2, 2] * local[2],
        )
        turning = turned(attitude.axes, turned(attitude.R, moment))
        for i in range(3):
            matrix[x + i, x + 3 + j] += factor * lever[i]
            matrix[x + 3 + j, x + i] += factor * lever[i]
            matrix[x + 3 + i, x + 3 + j] += factor * turning[i]
    if bodies.modal[b] < 0:
        return
    for k in range(modes.stiffness.shape[0]):
        shape = turned(attitude.R, (modes.shapes[0, k], modes.shapes[1, k], modes.shapes[2, k]))
        moment = (inertia.turning[0, k], inertia.turning[1, k], inertia.turning[2, k])
        turning = turned(attitude.axes, turned(attitude.R, moment))
        for i in range(3):
            matrix[x + i, x + 6 + k] += factor * shape[i]
            matrix[x + 6 + k, x + i] += factor * shape[i]
            matrix[x + 3 + i, x + 6 + k] += factor * turning[i]
            matrix[x + 6 + k, x + 3 + i] += factor * turning[i]
        elastic = weights.position * modes.stiffness[k] + weights.velocity * modes.damping[k]
        matrix[x + 6 + k, x + 6 + k] += factor + elastic


@inner(merged=True)
def read_body(bodies: Bodies, b: int, values: FloatArray, out: FloatArray) -> None:
    """Write the coordinates of a body and its modes to a row (6 + m,); without modes the last m stay."""
    first = bodies.coordinate[b]
    modal = bodies.modal[b]
    for k in range(6):
        out[k] = values[first + k]
    for k in range(6, out.shape[0] if modal >= 0 else 6):
        out[k] = values[modal + k - 6]


@inner(merged=True)
def add_body(bodies: Bodies, b: int, row: FloatArray, factor: float, residual: FloatArray) -> None:
    """Add a row (6 + m,) of a body's coordinates and modes, times a factor, to the residual."""
    first = bodies.coordinate[b]
    modal = bodies.modal[b]
    for k in range(6):
        residual[first + k] += factor * row[k]
    if modal >= 0:
        for k in range(6, row.shape[0]):
            residual[modal + k - 6] += factor * row[k]


@inner
def write_angles(bodies: Bodies, q: FloatArray) -> None:
    """Write the cosines and sines of all bodies' angles, which take long to compute, at the coordinates."""
    for b in range(bodies.mass.shape[0]):
        for k in range(3):
            angle = q[bodies.coordinate[b] + 3 + k] + bodies.reference[b, 3 + k]
            bodies.of_angles[b, 0, k], bodies.of_angles[b, 1, k] = math.cos(angle), math.sin(angle)


@inner(merged=True)
def attitude_of(bodies: Bodies, b: int) -> Attitude:
    """Return the attitude of a body at the coordinates of `write_angles`."""
    c = bodies.of_angles[b, 0]
    s = bodies.of_angles[b, 1]
    return rotations.attitude_by((c[0], c[1], c[2]), (s[0], s[1], s[2]))


@inner(merged=True)
def frame_of(bodies: Bodies, b: int, state: FloatArray, attitude: Attitude) -> Frame:
    """Return pose and motion of a body at all coordinates and rates (2 or more, coordinates)."""
    k = bodies.coordinate[b]
    reference = bodies.reference[b]
    q = state[0]
    q_t = state[1]
    place = (q[k] + reference[0], q[k + 1] + reference[1], q[k + 2] + reference[2])
    omega = rotations.spin(attitude, (q_t[k + 3], q_t[k + 4], q_t[k + 5]))
    return Frame(place, attitude.R, (q_t[k], q_t[k + 1], q_t[k + 2]), omega)


@inner
def add_bodies(
    bodies: Bodies,
    modes: Modes,
    state: FloatArray,
    gravity: Vector,
    inertias: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
    tensor: FloatArray,
    residual: FloatArray,
) -> None:
    """Add inertia, elastic forces and weights of all bodies; store their `Inertia` in arrays (bodies, ...).

    `gravity` is in m/s2, global, `residual` in N, N m and modal; `rows` (4, 6 + m) and `tensor` (3, 3) are
    scratch.
    """
    forces = rows[3]
    for b in range(bodies.mass.shape[0]):
        for rate in range(3):
            read_body(bodies, b, state[rate], rows[rate])
        forces.fill(0.0)
        inertia = Inertia(inertias[0][b], inertias[1][b], inertias[2][b])
        attitude = attitude_of(bodies, b)
        motion = _motion(attitude, rows, gravity)
        for a in range(3):
            inertia.first[a] = bodies.first[b, a]
            for c in range(3):
                inertia.second[a, c] = bodies.second[b, a, c]
                tensor[a, c] = 0.0
        force = (0.0, 0.0, 0.0)
        if bodies.modal[b] >= 0:
            force = _bend(modes, rows, motion, forces, inertia, tensor)
        first = (inertia.first[0], inertia.first[1], inertia.first[2])
        turning = turned(motion.turning, first)
        force = along(along(force, bodies.mass[b], motion.acceleration), 1.0, turning)
        for a in range(3):
            for c in range(3):
                tensor[a, c] += first[a] * motion.acceleration[c]
                for d in range(3):
                    tensor[a, c] += inertia.second[a, d] * motion.turning[c][d]
        force = turned(attitude.R, force)
        moment = turned(attitude.axes, turned(attitude.R, _moment_of(tensor)))
        for k in range(3):
            forces[k] += force[k]
            forces[3 + k] += moment[k]
        add_body(bodies, b, forces, 1.0, residual)
