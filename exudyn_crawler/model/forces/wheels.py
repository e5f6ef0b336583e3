"""Contact of wheels with the rails of the shoes: rollers of a frame, idler and carriers of a closed track.

Each strip of a wheel may touch any shoe of its track, by the law of `forces.treads`. While a rail is between
the flanges of a wheel, these guide its shoe sideways, with a play.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Frame, Vector, along, basis, cross, turned, turned_back
from exudyn_crawler.ground.laws import Impact, step
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, Floats4, Ints1, Ints2
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, read_body
from exudyn_crawler.model.forces import treads
from exudyn_crawler.model.forces.impact import Flange, flange_force, stored_energy
from exudyn_crawler.model.markers import write_point

ASIDE = 0.3
"""Distance (m) that exceeds any lateral offset of a touching shoe from its track's middle."""
ROLLED = 0.05
"""Distance (m) that exceeds any motion of a rail by bending and by roll against a wheel."""


class Wheels(NamedTuple):
    """Wheels of frames, each with the same strips, and the shoes below them."""

    frames: Ints1  # (wheels,): body that carries each
    shoes: Ints2  # (wheels, 2): first and last but one shoe of its track
    places: Floats3  # (wheels, strips, 3): middle of every strip's axis in the frame's axes, m
    middles: Floats1  # (wheels,): y of the middle of its track in the frame's axes, m
    radii: Floats1  # (wheels,): m
    resistances: Floats1  # (wheels,): over the normal force
    fading: float  # m/s over the rail, at which a wheel has 0.7 of its resistance
    law: Impact  # of a strip
    flange: Flange  # of a strip
    height: float  # of the flanges above the treads, m; zero for none
    rail: treads.Rail
    rows: Floats4  # (strips, stations + 2, 3, m): see `shoe_mesh.RailRows`
    spacing: float  # of the stations, m
    slots: int  # wheels that may be on one shoe at once


class WheelWorkspace(NamedTuple):
    """Contacts of wheels at a state."""

    rows: ForceRows  # those that touch: force on the frame, N, global
    wheel: Ints2  # (shoes, slots): wheel that is on a shoe, -1 for none
    force: Floats4  # (shoes, slots, strips, 3): on the shoe, N, global
    foot: Floats4  # (shoes, slots, strips, 3): where, m, global
    guide: Floats3  # (shoes, slots, strips): part of the force along the shoe's y, N
    on_shoes: Floats2  # (shoes, 6): force (N) and moment about the COM (N m) of all wheels, global
    on_wheels: Floats2  # (wheels, 3): force of all shoes, N, global
    energy: Floats1  # (1,): in the treads, J
    modes: Floats2  # (4, m): scratch, see `_bending`

    @classmethod
    def allocate(cls, wheels: Wheels, modes: int) -> "WheelWorkspace":
        """Return a workspace for these wheels."""
        shoes = int(wheels.shoes.max(initial=0))
        slots = wheels.slots
        strips = wheels.places.shape[1]
        return cls(
            rows=ForceRows.allocate(shoes * slots * strips, 3, modes),
            wheel=np.full((shoes, slots), -1),
            force=np.zeros((shoes, slots, strips, 3)),
            foot=np.zeros((shoes, slots, strips, 3)),
            guide=np.zeros((shoes, slots, strips)),
            on_shoes=np.zeros((shoes, 6)),
            on_wheels=np.zeros((len(wheels.frames), 3)),
            energy=np.zeros(1),
            modes=np.zeros((4, modes)),
        )


class WheelState(NamedTuple):
    """Wheel at a state."""

    number: int
    attitude: Attitude  # of the body that carries it
    frame: Frame
    middle: Vector  # of its axis, in the middle of its track, m, global
    reach: float  # distance from its axis at which it may touch a rail, m
    far: float  # square of the distance to the COM of a shoe that it cannot reach, m2


class ShoeState(NamedTuple):
    """Shoe near a wheel at a state."""

    number: int
    slot: int  # of the wheel on this shoe, see `WheelWorkspace`
    attitude: Attitude
    frame: Frame
    flexible: bool


class Strip(NamedTuple):
    """Strip of a wheel against the shoe below it."""

    tread: treads.Tread
    side: float  # force of the flange on the frame along the shoe's y, N
    stiffness: float  # of it, N/m
    damping: float  # N s/m
    arm: Vector  # from the shoe's origin to the foot, m, global


@inner(allocates=True)
def write_rows(
    wheels: Wheels,
    bodies: Bodies,
    state: FloatArray,
    resists: float,
    weights: Weights,
    work: WheelWorkspace,
) -> None:
    """Write the rows of the strips that touch at a state, with a fraction `resists` of their resistance."""
    count = np.int64(0)
    values = np.zeros((2, 6 + work.modes.shape[1]))
    _clear(work)
    for w in range(wheels.frames.shape[0]):
        wheel = _wheel_at(wheels, bodies, state, w)
        for s in range(wheels.shoes[w, 0], wheels.shoes[w, 1]):
            slot = _free_slot(work, s)
            if slot < 0 or _is_far(wheel, bodies, state, s):
                continue
            attitude = attitude_of(bodies, s)
            shoe = ShoeState(s, slot, attitude, frame_of(bodies, s, state, attitude), bodies.modal[s] >= 0)
            if _misses(wheel, wheels.rail, shoe.frame):
                continue
            if shoe.flexible:
                read_body(bodies, s, state[0], values[0])
                read_body(bodies, s, state[1], values[1])
            count = _write_strips(wheels, wheel, shoe, resists, values, weights, work, count)
    work.rows.acting[0] = count


@inner
def _clear(work: WheelWorkspace) -> None:
    """Clear the results of an earlier state."""
    work.wheel.fill(-1)
    work.force.fill(0.0)
    work.foot.fill(0.0)
    work.guide.fill(0.0)
    work.on_shoes.fill(0.0)
    work.on_wheels.fill(0.0)
    work.energy[0] = 0.0


@inner(merged=True)
def _wheel_at(wheels: Wheels, bodies: Bodies, state: FloatArray, w: int) -> WheelState:
    """Return a wheel at a state."""
    attitude = attitude_of(bodies, wheels.frames[w])
    frame = frame_of(bodies, wheels.frames[w], state, attitude)
    place = wheels.places[w]
    middle = along(frame.r, 1.0, turned(frame.R, (place[0, 0], wheels.middles[w], place[0, 2])))
    rail = wheels.rail
    reach = wheels.radii[w] + wheels.height + ROLLED
    most = math.sqrt(max(rail.rear**2, rail.front**2) + rail.height**2) + reach
    return WheelState(w, attitude, frame, middle, reach, most * most + ASIDE**2)


@inner(merged=True)
def _free_slot(work: WheelWorkspace, s: int) -> int:
    """Return the first free slot of a shoe; -1 for none."""
    for slot in range(work.wheel.shape[1]):
        if work.wheel[s, slot] < 0:
            return slot
    return -1


@inner(merged=True)
def _is_far(wheel: WheelState, bodies: Bodies, state: FloatArray, s: int) -> bool:
    """Return True if the shoe's COM alone shows that a wheel does not reach the rail."""
    first = bodies.coordinate[s]
    square = 0.0
    for c in range(3):
        square += (bodies.reference[s, c] + state[0, first + c] - wheel.middle[c]) ** 2
    return square > wheel.far


@inner(merged=True)
def _misses(wheel: WheelState, rail: treads.Rail, shoe: Frame) -> bool:
    """Return True if a wheel, seen along the shoe's axis y, does not reach its rail."""
    center = turned_back(shoe.R, along(wheel.middle, -1.0, shoe.r))
    dx = center[0] - min(max(center[0], rail.rear), rail.front)
    dz = center[2] - rail.height
    return dx * dx + dz * dz > wheel.reach * wheel.reach


@inner(merged=True)
def _write_strips(
    wheels: Wheels,
    wheel: WheelState,
    shoe: ShoeState,
    resists: float,
    values: FloatArray,
    weights: Weights,
    work: WheelWorkspace,
    row: int,
) -> int:
    """Write the strips of a wheel that touch a shoe from a row on; return the row behind them.

    `values` (2, 6 + m) are coordinates and rates of a flexible shoe.
    """
    derive = weights.position != 0.0 or weights.velocity != 0.0
    for k in range(wheels.places.shape[1]):
        strip = _touch(wheels, wheel, shoe, k, resists, derive, values, work.modes)
        if strip.tread.depth <= 0.0 and strip.side == 0.0:
            continue
        work.wheel[shoe.number, shoe.slot] = wheel.number
        work.energy[0] += stored_energy(wheels.law, strip.tread.depth)
        _write_strip(wheels, strip, wheel, shoe, k, row, weights, work)
        row += 1
    return row


@inner
def _bending(
    wheels: Wheels, strip: int, place: float, coordinates: FloatArray, out: FloatArray
) -> treads.Bending:
    """Return the bending of a rail at a position, by modes of `coordinates` with their rates (2, 6 + m).

    Also write the displacement along x, y and z of the rail by the modes, and the slope of the last: (4, m).
    Between stations this is the cubic through the two nearest on either side, with slopes from their
    neighbours (Catmull and Rom, 1974), which has no kinks at stations.
    """
    t = (place - wheels.rail.rear) / wheels.spacing
    i = min(max(int(t), 0), wheels.rows.shape[1] - 4)
    u = t - i
    values = (
        0.5 * u * (u * (2.0 - u) - 1.0),
        1.0 + 0.5 * u * u * (3.0 * u - 5.0),
        0.5 * u * (1.0 + u * (4.0 - 3.0 * u)),
        0.5 * u * u * (u - 1.0),
    )
    slopes = (
        0.5 * (u * (4.0 - 3.0 * u) - 1.0) / wheels.spacing,
        0.5 * u * (9.0 * u - 10.0) / wheels.spacing,
        0.5 * (1.0 + u * (8.0 - 9.0 * u)) / wheels.spacing,
        0.5 * u * (3.0 * u - 2.0) / wheels.spacing,
    )
    table = wheels.rows[strip]
    rise = slope = rate = aside = aside_rate = along_rate = 0.0
    for row in range(4):
        (a, b, c, d) = values if row < 3 else slopes
        r = min(row, 2)
        for k in range(out.shape[1]):
            behind = a * table[i, r, k] + b * table[i + 1, r, k]
            ahead = c * table[i + 2, r, k]
            out[row, k] = behind + ahead + d * table[i + 3, r, k]
    for k in range(out.shape[1]):
        x = out[0, k]
        y = out[1, k]
        z = out[2, k]
        tilt = out[3, k]
        rise += z * coordinates[0, 6 + k]
        slope += tilt * coordinates[0, 6 + k]
        rate += z * coordinates[1, 6 + k]
        aside += y * coordinates[0, 6 + k]
        aside_rate += y * coordinates[1, 6 + k]
        along_rate += x * coordinates[1, 6 + k]
    return treads.Bending(rise, slope, rate, aside, aside_rate, along_rate)


@inner(merged=True)
def _touch(
    wheels: Wheels,
    on_wheel: WheelState,
    on_shoe: ShoeState,
    k: int,
    resists: float,
    derive: bool,
    values: FloatArray,
    modes: FloatArray,
) -> Strip:
    """Return strip k of a wheel against a shoe's rail, with derivatives if `derive`.

    Also write the modes of the rail below the strip to `modes`.
    """
    w = on_wheel.number
    frame = on_wheel.frame
    shoe = on_shoe.frame
    place = (wheels.places[w, k, 0], wheels.places[w, k, 1], wheels.places[w, k, 2])
    # place (m) and velocity (m/s) of the strip's axis in the shoe's axes
    arm = turned(frame.R, place)
    apart = along(along(frame.r, 1.0, arm), -1.0, shoe.r)
    velocity = along(along(frame.v, 1.0, cross(frame.omega, arm)), -1.0, shoe.v)
    rates = turned_back(shoe.R, along(velocity, -1.0, cross(shoe.omega, apart)))
    center = turned_back(shoe.R, apart)
    rail = wheels.rail
    bent = treads.Bending(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if on_shoe.flexible:
        bent = _bending(wheels, k, min(max(center[0], rail.rear), rail.front), values, modes)
    disc = treads.Disc(wheels.radii[w], resists * wheels.resistances[w], wheels.fading)
    middle = (center[0], center[2])
    turning = turned_back(shoe.R, along(frame.omega, -1.0, shoe.omega))
    speeds = (rates[0], rates[2], turning[1])
    tread = treads.tread_force(wheels.law, rail, disc, middle, speeds, bent, derive)
    engaged = step(tread.depth, -wheels.height, 0.0, 0.0, 1.0) if wheels.height > 0.0 else 0.0
    side = stiffness = damping = 0.0
    if engaged > 0.0:
        # of the wheel's plane where it meets the rail, not at its axis: a shoe may lean
        across = turned_back(shoe.R, turned(frame.R, basis(1)))
        dx = tread.foot[0] - center[0]
        dz = tread.foot[1] - center[2]
        leaning = (across[0] * dx + across[2] * dz) / across[1]
        off = center[1] - leaning - place[1] + wheels.middles[w] - bent.aside
        rate = rates[1] + turning[2] * dx - turning[0] * dz - bent.aside_rate
        force, stiffness, damping = flange_force(wheels.flange, off, rate)
        side = engaged * force
        stiffness = engaged * stiffness
        damping = engaged * damping
    foot = turned(shoe.R, (tread.foot[0], center[1], tread.foot[1]))
    return Strip(tread, side, stiffness, damping, foot)


@inner(merged=True)
def _write_strip(
    wheels: Wheels,
    strip: Strip,
    on_wheel: WheelState,
    on_shoe: ShoeState,
    k: int,
    row: int,
    weights: Weights,
    work: WheelWorkspace,
) -> None:
    """Write strip k of a wheel that touches a shoe: a row of forces, and results."""
    w = on_wheel.number
    s = on_shoe.number
    slot = on_shoe.slot
    frame = on_wheel.frame
    shoe = on_shoe.frame
    rows = work.rows
    tread = strip.tread
    foot = along(shoe.r, 1.0, strip.arm)
    pressed = (tread.force[0], tread.force[1]) if tread.depth > 0.0 else (0.0, 0.0)
    force = turned(shoe.R, (pressed[0], strip.side, pressed[1]))
    rows.bodies[row, 0] = wheels.frames[w]
    rows.bodies[row, 1] = s
    rows.unit[row] = -1
    arm = along(foot, -1.0, frame.r)
    modes = work.modes.shape[1] if on_shoe.flexible else 0
    write_point(on_wheel.attitude, arm, work.modes, np.int64(0), 1.0, rows.jacobian[row, 0])
    write_point(on_shoe.attitude, strip.arm, work.modes, modes, -1.0, rows.jacobian[row, 1])
    moment = cross(strip.arm, force)
    for r in range(3):
        rows.wrench[row, r] = force[r]
        work.force[s, slot, k, r] = -force[r]
        work.foot[s, slot, k, r] = foot[r]
        work.on_shoes[s, r] -= force[r]
        work.on_shoes[s, 3 + r] -= moment[r]
        work.on_wheels[w, r] += force[r]
    work.guide[s, slot, k] = -strip.side
    if not (weights.position != 0.0 or weights.velocity != 0.0):
        return
    tangent = rows.tangent[row]
    treads.write_tangent(tread, shoe.R, weights, tangent)
    across = weights.position * strip.stiffness + weights.velocity * strip.damping
    for r in range(3):
        for c in range(3):
            tangent[r, c] += across * shoe.R[r][1] * shoe.R[c][1]
