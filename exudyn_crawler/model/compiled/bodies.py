"""Inertia, elasticity and loads of one shoe, rigid or in a floating frame of reference.

A point of the shoe is at ``r + R (x + Psi z)``: r and R place the frame, z are the modal coordinates and Psi
the mode shapes. Its acceleration in the frame's axes is ``R^T r'' + Omega p + 2 omega x Psi z' + Psi z''``
with ``p = x + Psi z`` and ``Omega = alpha~ + omega~ omega~``; integrated over the mass, alone, times p and
times Psi, it gives force, moment and modal forces. The integrals do not change; nothing is left out (Shabana,
Dynamics of Multibody Systems, chapter 5). A rigid shoe is one without modes.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import Matrix, Vector, along, cross, dot, turned, turned_back
from exudyn_crawler.ground.rotations import Attitude, FloatArray, spin, spin_rate
from exudyn_crawler.model.compiled.elimination import solving_within


class Body(NamedTuple):
    """Integrals over the mass of a shoe with m modes, in its frame, and what it is loaded by.

    Attributes
    ----------
    mass : float
        kg.
    first : array (3,)
        Of the places x, kg m.
    second : array (3, 3)
        Of x_a x_b, kg m2.
    shapes : array (3, m)
        Of the mode shapes.
    places : array (9 m,)
        Of x_a Psi_ck over (a, k, c).
    products : array (m, 9 m)
        Of Psi_aj Psi_ck over j and (a, k, c).
    stiffness, damping : array (m,)
        Of the modes, whose mass is 1: 1/s2 and 1/s.
    load_place : array (3,)
        Where the machine load acts, m.
    load_shapes : array (3, m)
        Displacement of that place by the modes.
    side_place, side_shapes : array (3,), (3, m)
        What both change by per metre that the load shifts to the left.
    """

    mass: float
    first: FloatArray
    second: FloatArray
    shapes: FloatArray
    places: FloatArray
    products: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    load_place: FloatArray
    load_shapes: FloatArray
    side_place: FloatArray
    side_shapes: FloatArray


def rigid_body(mass: float, inertia: FloatArray, center: FloatArray, load_place: FloatArray) -> Body:
    """Body without modes.

    Parameters
    ----------
    mass : float
        kg.
    inertia : array (3, 3)
        About the centre of mass, kg m2.
    center, load_place : array (3,)
        Centre of mass and where a load acts, m.
    """
    none = np.zeros((3, 0))
    return Body(
        mass=float(mass),
        first=mass * center,
        second=0.5 * np.trace(inertia) * np.eye(3) - inertia + mass * np.outer(center, center),
        shapes=none,
        places=np.zeros(0),
        products=np.zeros((0, 0)),
        stiffness=np.zeros(0),
        damping=np.zeros(0),
        load_place=load_place,
        load_shapes=none,
        side_place=np.array([0.0, 1.0, 0.0]),
        side_shapes=none,
    )


class Inertia(NamedTuple):
    """Integrals over the mass of a shoe as it is bent, in its frame.

    Attributes
    ----------
    first : array (3,)
        Of the places p, kg m.
    second : array (3, 3)
        Of p_a p_b, kg m2.
    turning : array (3, m)
        Of p x Psi: moment of unit modal accelerations.
    """

    first: FloatArray
    second: FloatArray
    turning: FloatArray


@solving_within
def moved(place: Vector, shapes: FloatArray, own: FloatArray) -> Vector:
    """Place (m, the shoe's frame) moved by shapes (3, m) at the shoe's coordinates and modes (6 + m,)."""
    x, y, z = place
    for k in range(shapes.shape[1]):
        x += shapes[0, k] * own[6 + k]
        y += shapes[1, k] * own[6 + k]
        z += shapes[2, k] * own[6 + k]
    return x, y, z


@solving_within
def _moment_of(tensor: FloatArray) -> Vector:
    """Moment of ``integral p_a f_c``."""
    return tensor[1, 2] - tensor[2, 1], tensor[2, 0] - tensor[0, 2], tensor[0, 1] - tensor[1, 0]


class Motion(NamedTuple):
    """Motion of a shoe's frame in its own axes.

    `omega` (rad/s), the rows of Omega (1/s2) and the acceleration of the origin less that of gravity (m/s2).
    """

    omega: Vector
    turning: Matrix
    acceleration: Vector


@solving_within
def _motion(at: Attitude, state: FloatArray, gravity: Vector) -> Motion:
    """Motion of the frame of a shoe at its coordinates, rates and accelerations (3, 6 + m)."""
    rates = (state[1, 3], state[1, 4], state[1, 5])
    w = turned_back(at.R, spin(at, rates))
    al = turned_back(at.R, spin_rate(at, rates, (state[2, 3], state[2, 4], state[2, 5])))
    w2 = dot(w, w)
    turning = (
        (w[0] * w[0] - w2, w[0] * w[1] - al[2], w[0] * w[2] + al[1]),
        (w[1] * w[0] + al[2], w[1] * w[1] - w2, w[1] * w[2] - al[0]),
        (w[2] * w[0] - al[1], w[2] * w[1] + al[0], w[2] * w[2] - w2),
    )
    upward = along((state[2, 0], state[2, 1], state[2, 2]), -1.0, gravity)
    return Motion(w, turning, turned_back(at.R, upward))


@solving_within
def _column(tensor: FloatArray, a: int, k: int) -> Vector:
    return tensor[a, k, 0], tensor[a, k, 1], tensor[a, k, 2]


@solving_within
def _bend(
    body: Body, state: FloatArray, motion: Motion, residual: FloatArray, inertia: Inertia, tensor: FloatArray
) -> Vector:
    """Add inertia and elastic forces of the modes, and what they add to the shoe's own integrals.

    `tensor` (3, 3) gathers ``integral p_a f_c`` of inertia forces f. Gives the force of the modes' motion, N,
    in the shoe's axes.
    """
    m, w = body.stiffness.shape[0], motion.omega
    bent = np.dot(np.ascontiguousarray(state[:2, 6 : 6 + m]), body.products)
    shifts, speeds = bent[0].reshape((3, m, 3)), bent[1].reshape((3, m, 3))
    places = body.places.reshape((3, m, 3))
    force = (0.0, 0.0, 0.0)
    for k in range(m):
        z, z_t, z_tt = state[0, 6 + k], state[1, 6 + k], state[2, 6 + k]
        modal = z_tt + body.stiffness[k] * z + body.damping[k] * z_t
        levers = np.empty((3, 3))
        for a in range(3):
            inertia.first[a] += body.shapes[a, k] * z
            modal += body.shapes[a, k] * motion.acceleration[a]
            # integral of p_a Psi_k
            lever = along(_column(places, a, k), 1.0, _column(shifts, a, k))
            for c in range(3):
                levers[a, c] = lever[c]
                modal += lever[c] * motion.turning[c][a]
            # 2 Psi_k . (omega x Psi z'), of which this is the part of component a of Psi z'
            modal += 2.0 * cross(_column(speeds, a, k), w)[a]
            swirl = cross(w, lever)
            for c in range(3):
                inertia.second[a, c] += lever[c] * z + places[c, k, a] * z
                tensor[a, c] += lever[c] * z_tt + 2.0 * swirl[c] * z_t
        moment = _moment_of(levers)
        for a in range(3):
            inertia.turning[a, k] = moment[a]
        shape = (body.shapes[0, k], body.shapes[1, k], body.shapes[2, k])
        force = along(along(force, z_tt, shape), 2.0 * z_t, cross(w, shape))
        residual[6 + k] += modal
    return force


@solving_within
def body_residual(
    body: Body,
    at: Attitude,
    state: FloatArray,
    gravity: Vector,
    load: tuple[Vector, float],
    residual: FloatArray,
    inertia: Inertia,
) -> None:
    """Add inertia less applied forces to the residual of one shoe, and keep its integrals for `add_mass`.

    Parameters
    ----------
    state : array (3, 6 + m)
        Coordinates of the shoe and its modes, their rates and accelerations.
    gravity : Vector
        Acceleration of gravity, m/s2, global.
    load : tuple
        Machine load, N, global, and how far it shifts to the left, m.
    residual : array (6 + m,)
        Generalized forces, N, N m and modal.
    """
    motion = _motion(at, state, gravity)
    tensor = np.empty((3, 3))
    for a in range(3):
        inertia.first[a] = body.first[a]
        for c in range(3):
            inertia.second[a, c], tensor[a, c] = body.second[a, c], 0.0
    force = (0.0, 0.0, 0.0)
    if body.stiffness.shape[0] > 0:
        force = _bend(body, state, motion, residual, inertia, tensor)
    first = (inertia.first[0], inertia.first[1], inertia.first[2])
    force = along(along(force, body.mass, motion.acceleration), 1.0, turned(motion.turning, first))
    for a in range(3):
        for c in range(3):
            tensor[a, c] += first[a] * motion.acceleration[c]
            for d in range(3):
                tensor[a, c] += inertia.second[a, d] * motion.turning[c][d]
    _apply(at, force, _moment_of(tensor), residual)
    _apply_load(body, at, state[0], load, residual)


@solving_within
def _apply_load(
    body: Body, at: Attitude, own: FloatArray, load: tuple[Vector, float], residual: FloatArray
) -> None:
    """Take the machine load off the residual; it acts at a place that the modes move."""
    (x, y, z), shift = load
    push = turned_back(at.R, (-x, -y, -z))
    place = moved((body.load_place[0], body.load_place[1], body.load_place[2]), body.load_shapes, own)
    beside = moved((body.side_place[0], body.side_place[1], body.side_place[2]), body.side_shapes, own)
    _apply(at, push, cross(along(place, shift, beside), push), residual)
    for k in range(body.stiffness.shape[0]):
        for a in range(3):
            residual[6 + k] += (body.load_shapes[a, k] + shift * body.side_shapes[a, k]) * push[a]


@solving_within
def _apply(at: Attitude, force: Vector, moment: Vector, residual: FloatArray) -> None:
    """Add a force and a moment about the frame's origin, in its axes, to the shoe's six equations."""
    force, moment = turned(at.R, force), turned(at.axes, turned(at.R, moment))
    for k in range(3):
        residual[k] += force[k]
        residual[3 + k] += moment[k]


@solving_within
def add_mass(body: Body, at: Attitude, inertia: Inertia, factor: float, matrix: FloatArray) -> None:
    """Add the mass matrix of a shoe times a factor to the leading 6 + m rows and columns of a matrix."""
    m = body.stiffness.shape[0]
    trace = inertia.second[0, 0] + inertia.second[1, 1] + inertia.second[2, 2]
    first = turned(at.R, (inertia.first[0], inertia.first[1], inertia.first[2]))
    for j in range(3):
        matrix[j, j] += factor * body.mass
        axis = at.axes[j]
        lever = cross(axis, first)
        local = turned_back(at.R, axis)
        row = inertia.second
        moment = (
            trace * local[0] - row[0, 0] * local[0] - row[0, 1] * local[1] - row[0, 2] * local[2],
            trace * local[1] - row[1, 0] * local[0] - row[1, 1] * local[1] - row[1, 2] * local[2],
            trace * local[2] - row[2, 0] * local[0] - row[2, 1] * local[1] - row[2, 2] * local[2],
        )
        turning = turned(at.axes, turned(at.R, moment))
        for i in range(3):
            matrix[i, 3 + j] += factor * lever[i]
            matrix[3 + j, i] += factor * lever[i]
            matrix[3 + i, 3 + j] += factor * turning[i]
    for k in range(m):
        shape = turned(at.R, (body.shapes[0, k], body.shapes[1, k], body.shapes[2, k]))
        moment = (inertia.turning[0, k], inertia.turning[1, k], inertia.turning[2, k])
        turning = turned(at.axes, turned(at.R, moment))
        for i in range(3):
            matrix[i, 6 + k] += factor * shape[i]
            matrix[6 + k, i] += factor * shape[i]
            matrix[3 + i, 6 + k] += factor * turning[i]
            matrix[6 + k, 3 + i] += factor * turning[i]
        matrix[6 + k, 6 + k] += factor
