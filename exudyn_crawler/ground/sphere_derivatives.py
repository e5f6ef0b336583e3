"""Derivatives of the spheres' forces on frames, one block a pair of shoe and unit.

A block is made by displacements and small rotations about global axes; only at its end it is turned into
one by the shoe's coordinates.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.faces import EDGE, FACE
from exudyn_crawler.ground.frames import Vector, along, basis, compiled, cross, dot, norm, within
from exudyn_crawler.ground.laws.linear import Linear
from exudyn_crawler.ground.rotations import FloatArray, attitude, to_angles
from exudyn_crawler.ground.spheres import Touch, kept, touch_force
from exudyn_crawler.ground.triplets import Weights

COORDINATES = 8
"""Coordinates of a pair: displacement and rotation of the shoe, heave and tilt of the unit."""


class Centers(NamedTuple):
    """Centres of a pair's shoe and unit (m), and the axis that the unit tilts about."""

    shoe: Vector
    unit: Vector
    axis: int


@within
def _lever(at: Centers, place: Vector, c: int) -> Vector:
    """Motion of a place on the shoe less that on the unit, by coordinate c of the pair."""
    if c < 3:
        return basis(c)
    if c < 6:
        return cross(basis(c - 3), along(place, -1.0, at.shoe))
    if c == 6:
        return (0.0, 0.0, -1.0)
    return cross(along(place, -1.0, at.unit), basis(at.axis))


@within
def _held(touch: Touch, motion: Vector) -> Vector:
    """Part of a motion of the centre that the nearest point does not follow."""
    if touch.kind == FACE:
        return along((0.0, 0.0, 0.0), dot(touch.normal, motion), touch.normal)
    if touch.kind == EDGE:
        return along(motion, -dot(touch.edge, motion), touch.edge)
    return motion


@within
def _by_place(touch: Touch, law: Linear, motion: Vector) -> Vector:
    """Change of the force by a motion of the centre: of its depth, and of its normal beside a face."""
    deeper = -law.stiffness * dot(touch.normal, motion)
    ratio = touch.drag / touch.size if touch.size != 0.0 else 0.0
    push = along(touch.normal, -ratio, touch.slip)
    turn = along(_held(touch, motion), -dot(touch.normal, motion), touch.normal)
    return along(along((0.0, 0.0, 0.0), deeper, push), touch.size / touch.distance, turn)


@within
def _by_speed(touch: Touch, law: Linear, motion: Vector, secant: bool) -> Vector:
    """Change of the force by a velocity of the shoe at the point."""
    nearer = dot(touch.normal, motion)
    ratio = touch.drag / touch.size if touch.size != 0.0 else 0.0
    push = along(touch.normal, -ratio, touch.slip)
    across = along(motion, -nearer, touch.normal)
    speed = norm(touch.slip)
    if speed > law.friction_speed and not secant:
        across = along(across, -dot(touch.slip, motion) / speed**2, touch.slip)
    return along(along((0.0, 0.0, 0.0), -law.damping * nearer, push), -touch.drag, across)


@within
def _add_sphere(touch: Touch, at: Centers, law: Linear, weights: Weights, block: FloatArray) -> None:
    """Add one sphere's derivatives to its pair's block."""
    force = touch_force(touch)
    center = along(touch.point, touch.distance, touch.normal)
    # the normal turns with the unit
    turned = cross(basis(at.axis), touch.normal)
    for c in range(COORDINATES):
        moved = _lever(at, center, c)
        change = along((0.0, 0.0, 0.0), weights.position, _by_place(touch, law, moved))
        by_speed = _by_speed(touch, law, _lever(at, touch.point, c), weights.secant)
        change = along(change, weights.velocity, by_speed)
        wander = _held(touch, moved)
        if c == 7:
            change = along(change, weights.position * touch.size, turned)
            wander = along(wander, touch.distance, turned)
        for r in range(COORDINATES):
            block[r, c] += dot(_lever(at, touch.point, r), change)
        # what the force does about both centres as the point wanders
        arm = along((0.0, 0.0, 0.0), -1.0, wander)
        own = moved if c < 6 else (0.0, 0.0, 0.0)
        shoe_moment = cross(along(arm, 1.0 if c > 2 else 0.0, own), force)
        arm = along(arm, 1.0, own)
        unit_moment = cross((arm[0], arm[1], arm[2] - (1.0 if c == 6 else 0.0)), force)
        for k in range(3):
            block[3 + k, c] += weights.position * shoe_moment[k]
        block[7, c] -= weights.position * dot(basis(at.axis), unit_moment)


@within
def _pair(pairs: NDArray[np.int64], count: int, s: int, u: int) -> int:
    """Index of a pair among the first `count`, or `count` where it is new."""
    for p in range(count):
        if pairs[p, 0] == s and pairs[p, 1] == u:
            return p
    return count


@compiled
def sphere_derivatives(
    places: tuple, axis: int, spring: tuple, table: FloatArray, factors: tuple, out: tuple
) -> int:
    """Derivatives of the forces, one block a pair of shoe and unit.

    Parameters
    ----------
    places : tuple
        Places of the shoes (shoes, 6) and units (units, 4).
    axis : int
        What the units tilt about.
    spring, factors : tuple
        `Linear` and `Weights` as plain tuples. A block is ``Weights.position`` times the
        derivative by the pair's coordinates plus ``Weights.velocity`` times the one by their rates.
    table : array (contacts, COLUMNS)
        Touching spheres.
    out : tuple
        Pairs and values as of `triplets.PairBlocks`, and the moments about the shoe's COM (contacts, 3), N m.

    Returns
    -------
    int
        Number of pairs.

    Notes
    -----
    The change of the slip with the places is left out: it is far smaller than what it stands beside.
    """
    shoes, units = places
    pairs, blocks, moments = out
    law, weights = Linear(*spring), Weights(*factors)
    count = np.int64(0)
    for n in range(table.shape[0]):
        touch, s, u = kept(table[n]), int(table[n, 0]), int(table[n, 1])
        p = _pair(pairs, count, s, u)
        if p == count:
            if count >= blocks.shape[0]:
                continue
            count += 1
            pairs[p, 0], pairs[p, 1] = s, u
            blocks[p].fill(0.0)
            moments[p].fill(0.0)
        at = Centers((shoes[s, 0], shoes[s, 1], shoes[s, 2]), (units[u, 0], units[u, 1], units[u, 2]), axis)
        _add_sphere(touch, at, law, weights, blocks[p])
        moment = cross(along(touch.point, -1.0, at.shoe), touch_force(touch))
        for k in range(3):
            moments[p, k] += moment[k]
    for p in range(count):
        shoe = shoes[pairs[p, 0]]
        moment = (moments[p, 0], moments[p, 1], moments[p, 2])
        to_angles(blocks[p], moment, weights.position, attitude(shoe[3], shoe[4], shoe[5]))
    return int(count)
