"""Derivative of a track's equations, put into the fronts of its elimination.

Exact but for three things, which change over seconds and not over a step: how the forces of constraints and
loads turn with the shoes, how centrifugal and gyroscopic forces change with the rates, and how the outline of
an overlap moves. The residual has all of them, so that they cost iterations and not accuracy.
"""

import numpy as np

from exudyn_crawler.ground.pair_stiffness import MOTIONS, TouchingPairs
from exudyn_crawler.ground.rotations import FloatArray
from exudyn_crawler.model.compiled.bodies import Inertia, add_mass
from exudyn_crawler.model.compiled.elimination import front, solving, solving_within
from exudyn_crawler.model.compiled.equations import STIFFNESS
from exudyn_crawler.model.compiled.joints import ROWS
from exudyn_crawler.model.compiled.own import shoe_attitude
from exudyn_crawler.model.compiled.records import Ground, Inputs, Memory, Model, Weights, named_model
from exudyn_crawler.model.compiled.side_frame import assemble_side_frame


@solving_within
def _motions(found: TouchingPairs, first: int, last: int, modes: int, ground: Ground) -> FloatArray:
    """Motions of a shoe's contacts by its coordinates and the terrain's, row under row."""
    terrain, size = ground.heave.shape[1], 6 + modes
    out = np.empty((MOTIONS * (last - first), size + terrain))
    for p in range(first, last):
        u, row = found.pairs[p, 1], MOTIONS * (p - first)
        for r in range(MOTIONS):
            for c in range(6):
                out[row + r, c] = found.motion[p, r, c]
            x, y, z = found.motion[p, r, 8], found.motion[p, r, 9], found.motion[p, r, 10]
            for k in range(modes):
                by_patch = x * found.rows[p, 0, k] + y * found.rows[p, 1, k] + z * found.rows[p, 2, k]
                out[row + r, 6 + k] = by_patch
            x, y = found.motion[p, r, 6], found.motion[p, r, 7]
            for k in range(terrain):
                out[row + r, size + k] = x * ground.heave[u, k] + y * ground.tilt[u, k]
    return out


@solving_within
def _add_contacts(
    found: TouchingPairs, first: int, last: int, modes: int, ground: Ground, shift: int, matrix: FloatArray
) -> None:
    """Add the contacts of a shoe to its front, in which the terrain's rows come later by `shift`."""
    motions, size = _motions(found, first, last, modes, ground), 6 + modes
    forces = np.empty_like(motions)
    for p in range(first, last):
        row = MOTIONS * (p - first)
        for r in range(MOTIONS):
            for c in range(motions.shape[1]):
                force = 0.0
                for k in range(MOTIONS):
                    force += found.stiffness[p, r, k] * motions[row + k, c]
                forces[row + r, c] = force
    block = np.dot(motions.T, forces)
    for r in range(block.shape[0]):
        i = r if r < size else r + shift
        for c in range(size):
            matrix[i, c] += block[r, c]
        for c in range(size, block.shape[1]):
            matrix[i, c + shift] += block[r, c]


@solving_within
def _add_pins(model: Model, memory: Memory, values: FloatArray) -> None:
    """Add the directions of all pins to the fronts of their shoes."""
    for p in range(model.sizes.pins):
        for end in range(2):
            s = model.pins.shoes[p, end]
            matrix, row = front(model.fronts, values, s), model.places.pins[p, end]
            size = 6 + (model.sizes.modes if model.row[s] >= 0 else 0)
            for r in range(ROWS):
                for c in range(size):
                    matrix[c, row + r] += memory.pins[p, end, r, c]
                    matrix[row + r, c] += STIFFNESS * memory.pins[p, end, r, c]


@solving_within
def _add_drive(model: Model, inputs: Inputs, weights: Weights, memory: Memory, values: FloatArray) -> None:
    """Add the directions of drive and turn to the front of the last shoe."""
    s = model.sizes.shoes - 1
    matrix, border = front(model.fronts, values, s), front(model.fronts, values, model.places.border[0])
    size = 6 + (model.sizes.modes if model.row[s] >= 0 else 0)
    factor = STIFFNESS * weights.level * (weights.velocity if weights.velocity != 0.0 else 1.0)
    for k in range(2):
        if k == 0 and model.sizes.frame > 0:
            continue
        if inputs.drive[k, 0] <= 0.0:
            border[model.places.border[1 + k], model.places.border[1 + k]] += 1.0
            continue
        row = model.places.drive[k]
        for c in range(size):
            matrix[c, row] += memory.drive[k, c]
            matrix[row, c] += factor * memory.drive[k, c]


@solving
def assemble(
    plain_model: tuple,
    state: FloatArray,
    given: tuple,
    factors: tuple,
    contacts: int,
    kept: tuple,
    values: FloatArray,
) -> None:
    """Write the weighted derivative of the residual into the values of the fronts.

    Parameters
    ----------
    plain_model, given, factors, kept : tuple
        As the first, fourth, fifth and sixth of `equations.evaluate`.
    contacts : int
        As `equations.evaluate` gave with the same weights, just before and at the same state.
    """
    model, inputs = named_model(plain_model), Inputs(*given)
    weights, memory = Weights(*factors), Memory(*kept)
    values.fill(0.0)
    found = TouchingPairs(*memory.touching)
    first = np.int64(0)
    for s in range(model.sizes.shoes):
        modes, at = model.sizes.modes if model.row[s] >= 0 else 0, shoe_attitude(state, s)
        matrix = front(model.fronts, values, s)
        inertia = Inertia(memory.first[s], memory.second[s], memory.turning[s])
        if model.row[s] >= 0:
            add_mass(model.flexible, at, inertia, weights.acceleration, matrix)
        else:
            add_mass(model.rigid, at, inertia, weights.acceleration, matrix)
        for k in range(modes):
            elastic = weights.position * model.flexible.stiffness[k]
            matrix[6 + k, 6 + k] += elastic + weights.velocity * model.flexible.damping[k]
        last = first
        while last < contacts and found.pairs[last, 0] == s:
            last += 1
        if last > first:
            shift = model.places.terrain[s] - 6 - modes
            _add_contacts(found, first, last, modes, model.ground, shift, matrix)
        first = last
    matrix, ground = front(model.fronts, values, model.places.border[0]), model.ground
    for i in range(model.sizes.terrain):
        matrix[i, i] += weights.acceleration
        for k in range(model.sizes.terrain):
            matrix[i, k] += (
                weights.position * ground.stiffness[i, k] + weights.velocity * ground.damping[i, k]
            )
    _add_pins(model, memory, values)
    _add_drive(model, inputs, weights, memory, values)
    assemble_side_frame(model, state, weights, memory, values)
