"""Equations of motion of a whole track, evaluated and derived as one.

The unknowns are the coordinates, in the order of `model.state`, and behind them the multipliers: five a
pin, one of the drive and one of the turn. The residual is inertia less forces plus constraint forces for the
first, and what constraints are off for the second. Where a side frame rolls over the track, the drive's
multiplier is what pulls the chain, and its equation the frame's along x.
"""

import numpy as np

from exudyn_crawler.ground.pair_stiffness import MOTIONS, TouchingPairs, touching_pairs
from exudyn_crawler.ground.pair_track import Bodies
from exudyn_crawler.ground.rotations import Attitude, FloatArray
from exudyn_crawler.model.compiled.bodies import Inertia, body_residual
from exudyn_crawler.model.compiled.elimination import solving, solving_within
from exudyn_crawler.model.compiled.joints import ROWS, End, Pins, direction, end_of, pin
from exudyn_crawler.model.compiled.own import add_own, modal_start, read_own, shoe_attitude
from exudyn_crawler.model.compiled.records import Ground, Inputs, Memory, Model, Weights, named_model
from exudyn_crawler.model.compiled.side_frame import add_side_frame

STIFFNESS = 1e9
"""N/m and N m/rad, what turns a gap of a constraint into a residual beside forces: about what closing it
within a step of some ms takes of a shoe's mass."""


@solving_within
def _units(ground: Ground, q: FloatArray, out: FloatArray) -> None:
    """Write heave and tilt of the units by the terrain's coordinates, or their rates."""
    for u in range(ground.heave.shape[0]):
        z = a = 0.0
        for k in range(q.shape[0]):
            z += ground.heave[u, k] * q[k]
            a += ground.tilt[u, k] * q[k]
        out[u, 2], out[u, 3] = z, a


@solving_within
def _contact(model: Model, state: FloatArray, weights: Weights, memory: Memory, residual: FloatArray) -> int:
    """Take the contact forces off the residual; gives the number of contacts."""
    n, t, m = model.sizes.shoes, model.sizes.terrain, model.sizes.modes
    ground, terrain = model.ground, 6 * n
    _units(ground, state[0, terrain : terrain + t], memory.units)
    _units(ground, state[1, terrain : terrain + t], memory.unit_rates)
    for u in range(ground.heave.shape[0]):
        for k in range(4):
            memory.units[u, k] = ground.reference[u, k] + (memory.units[u, k] if k > 1 else 0.0)
    shoes = model.reference + state[0, :terrain].reshape((n, 6))
    modal = state[0, terrain + t : state.shape[1] - model.sizes.frame]
    rates = state[1, terrain + t : state.shape[1] - model.sizes.frame]
    flexible = modal.shape[0] // max(m, 1)
    bodies = Bodies(
        shoes,
        state[1, :terrain].reshape((n, 6)),
        memory.units,
        memory.unit_rates,
        modal.reshape((flexible, m)),
        rates.reshape((flexible, m)),
    )
    # derivatives of what stands negative in the residual
    factors = (-weights.position, -weights.velocity, weights.secant)
    count = touching_pairs(_tuple(bodies), model.contact, factors, memory.touching, memory.work)
    found = TouchingPairs(*memory.touching)
    forces = np.zeros((ground.heave.shape[0], 2))
    own = np.zeros(6 + m)
    for p in range(count):
        s, u = found.pairs[p, 0], found.pairs[p, 1]
        wrench, motion = found.wrench[p], found.motion[p]
        own.fill(0.0)
        for r in range(MOTIONS):
            for c in range(6):
                own[c] += motion[r, c] * wrench[r]
            for c in range(2):
                forces[u, c] += motion[r, 6 + c] * wrench[r]
        if model.row[s] >= 0:
            for c in range(3):
                push = 0.0
                for r in range(MOTIONS):
                    push += motion[r, 8 + c] * wrench[r]
                for k in range(m):
                    own[6 + k] += push * found.rows[p, c, k]
        add_own(s, modal_start(model.sizes, model.row[s]), own, -1.0, residual)
    for u in range(forces.shape[0]):
        if forces[u, 0] != 0.0 or forces[u, 1] != 0.0:
            for k in range(t):
                residual[terrain + k] -= ground.heave[u, k] * forces[u, 0] + ground.tilt[u, k] * forces[u, 1]
    return count


@solving_within
def _tuple(bodies: Bodies) -> tuple:
    """Bodies as a plain tuple."""
    return (
        bodies.shoes,
        bodies.shoe_rates,
        bodies.units,
        bodies.unit_rates,
        bodies.modal,
        bodies.modal_rates,
    )


@solving_within
def _terrain(model: Model, state: FloatArray, inputs: Inputs, residual: FloatArray) -> None:
    """Add inertia, supports and weight of the terrain."""
    first, ground = 6 * model.sizes.shoes, model.ground
    for i in range(model.sizes.terrain):
        force = state[2, first + i] + inputs.gravity[2] * ground.weight[i]
        for k in range(model.sizes.terrain):
            force += ground.stiffness[i, k] * state[0, first + k] + ground.damping[i, k] * state[1, first + k]
        residual[first + i] += force


@solving_within
def _bodies(model: Model, state: FloatArray, inputs: Inputs, memory: Memory, residual: FloatArray) -> None:
    """Add inertia, elastic forces, weights and loads of all shoes."""
    m = model.sizes.modes
    own, forces = np.empty((3, 6 + m)), np.empty(6 + m)
    for s in range(model.sizes.shoes):
        modal = modal_start(model.sizes, model.row[s])
        for rate in range(3):
            read_own(s, modal, state[rate], own[rate])
        forces.fill(0.0)
        inertia = Inertia(memory.first[s], memory.second[s], memory.turning[s])
        load = ((inputs.loads[s, 0], inputs.loads[s, 1], inputs.loads[s, 2]), inputs.shift)
        at = shoe_attitude(state, s)
        if modal >= 0:
            body_residual(model.flexible, at, own, inputs.gravity, load, forces, inertia)
        else:
            body_residual(model.rigid, at, own, inputs.gravity, load, forces, inertia)
        add_own(s, modal, forces, 1.0, residual)


@solving_within
def _end(pins: Pins, p: int, end: int, at: Attitude, own: FloatArray) -> End:
    return end_of(pins.places[p, end], pins.shifts[p, end], pins.turns[p, end], at, own)


@solving_within
def _pins(
    model: Model, state: FloatArray, multipliers: FloatArray, memory: Memory, residual: FloatArray
) -> None:
    """Add the forces of all pins, and write what they are off."""
    pins, sizes, reference = model.pins, model.sizes, model.reference
    own = np.empty((2, 6 + sizes.modes))
    for p in range(sizes.pins):
        a, b = pins.shoes[p, 0], pins.shoes[p, 1]
        modal_a, modal_b = modal_start(sizes, model.row[a]), modal_start(sizes, model.row[b])
        read_own(a, modal_a, state[0], own[0])
        read_own(b, modal_b, state[0], own[1])
        at_a, at_b = shoe_attitude(state, a), shoe_attitude(state, b)
        apart = (
            reference[b, 0] + own[1, 0] - reference[a, 0] - own[0, 0],
            reference[b, 1] + own[1, 1] - reference[a, 1] - own[0, 1],
            reference[b, 2] + own[1, 2] - reference[a, 2] - own[0, 2],
        )
        shapes = (pins.shifts[p, 0], pins.turns[p, 0], pins.shifts[p, 1], pins.turns[p, 1])
        ends = _end(pins, p, 0, at_a, own[0]), _end(pins, p, 1, at_b, own[1])
        pin(shapes, ends, (at_a, at_b), apart, memory.off[ROWS * p : ROWS * p + ROWS], memory.pins[p])
        for r in range(ROWS):
            add_own(a, modal_a, memory.pins[p, 0, r], multipliers[ROWS * p + r], residual)
            add_own(b, modal_b, memory.pins[p, 1, r], multipliers[ROWS * p + r], residual)


@solving_within
def _drive(
    model: Model,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    memory: Memory,
    residual: FloatArray,
) -> None:
    """Add the forces of drive and turn on the last shoe, and write what its speeds are off."""
    s, first = model.sizes.shoes - 1, ROWS * model.sizes.pins
    modal = modal_start(model.sizes, model.row[s])
    own = np.empty((2, 6 + model.sizes.modes))
    read_own(s, modal, state[0], own[0])
    read_own(s, modal, state[1], own[1])
    at = shoe_attitude(state, s)
    place, shifts, none = model.pulled
    pulled = end_of(place, shifts, none, at, own[0])
    nothing = (0.0, 0.0, 0.0)
    direction((1.0, 0.0, 0.0), nothing, pulled, (shifts, none), at, 1.0, memory.drive[0])
    frame = End(nothing, nothing)
    direction(nothing, at.axes[2], frame, (none, none), at, 1.0, memory.drive[1])
    for k in range(2):
        if inputs.drive[k, 0] > 0.0:
            speed = -inputs.drive[k, 1]
            for c in range(own.shape[1]):
                speed += memory.drive[k, c] * own[1, c]
            memory.off[first + k] = speed
            add_own(s, modal, memory.drive[k], multipliers[first + k], residual)
        else:
            memory.off[first + k] = multipliers[first + k]


@solving
def evaluate(
    values: tuple,
    state: FloatArray,
    multipliers: FloatArray,
    given: tuple,
    factors: tuple,
    kept: tuple,
    residual: FloatArray,
) -> int:
    """Residual of all equations: forces, then gaps times `STIFFNESS`; gives the number of contacts.

    Parameters
    ----------
    values, given, factors, kept : tuple
        `Model`, `Inputs`, `Weights` and `Memory` as plain tuples.
    state : array (3, coordinates)
        Coordinates, rates and accelerations.
    multipliers : array (multipliers,)
        N and N m.
    residual : array (coordinates + multipliers,)
        Overwritten.
    """
    model, inputs, weights, memory = named_model(values), Inputs(*given), Weights(*factors), Memory(*kept)
    n = state.shape[1]
    residual.fill(0.0)
    count = _contact(model, state, weights, memory, residual)
    _bodies(model, state, inputs, memory, residual)
    _terrain(model, state, inputs, residual)
    _pins(model, state, multipliers, memory, residual)
    _drive(model, state, multipliers, inputs, memory, residual)
    add_side_frame(model, state, multipliers, inputs, weights, memory, residual)
    pins = ROWS * model.sizes.pins
    for k in range(pins):
        residual[n + k] = STIFFNESS * memory.off[k]
    for k in range(2):
        level = STIFFNESS * weights.level if inputs.drive[k, 0] > 0.0 else 1.0
        residual[n + pins + k] = level * memory.off[pins + k]
    return count
