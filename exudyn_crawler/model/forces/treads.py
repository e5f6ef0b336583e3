"""Contact of the treads of a frame's rollers with the rails of the shoes.

Each strip of a tread may touch the shoe at or behind its axis and the next one. The force acts at the rail's
nearest point on both bodies, so that action equals reaction in moment too: what resists rolling is taken to
be the friction of the roller's bearing and seals.

In the shoe's x-z plane the strip is a disc about the roller's axis and the rail a segment, which ends where
the gap to the next shoe begins; a flexible shoe's rail is bent. Depth is the disc's radius less the distance
of its centre to the segment, ends included, so that a disc over a gap lies on the edges of both shoes. The
force is the gradient of the depth times the normal law, and what bends the rail feels the same force: the
elastic part has a potential. Rolling resistance lies along the rail.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import Frame, Vector, along, cross, turned, turned_back
from exudyn_crawler.ground.laws import Impact, impact_force, step
from exudyn_crawler.ground.rotations import Attitude, FloatArray, ForceRows, IntArray, Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, read_body
from exudyn_crawler.model.elimination import solving, solving_allocating, solving_inside, solving_within

Pair = tuple[float, float]
Triple = tuple[float, float, float]


class Rail(NamedTuple):
    """Rail of an unbent shoe in its frame, m: x of its ends, z of its top."""

    rear: float
    front: float
    height: float


class Bending(NamedTuple):
    """How a rail is bent where a tread is: rise (m), slope and rate of the rise (m/s); aside, m and m/s."""

    rise: float
    slope: float
    rate: float
    aside: float = 0.0
    aside_rate: float = 0.0


class Tread(NamedTuple):
    """Force of a rail on a strip of a tread in the shoe's frame."""

    force: Pair  # along x and z, N
    foot: Pair  # x and z of the rail's nearest point, m
    depth: float  # m
    inside: float  # 1 where the foot goes along with the roller, 0 at an end of the rail
    # derivatives of both forces by the centre's x, with which the place of rise and slope goes along, and z,
    # by the rise and by the slope
    by_place: tuple[Pair, Pair, Pair, Pair]
    by_rate: tuple[Pair, Pair, Pair]  # by the rates of the first three


class Slopes(NamedTuple):
    """Normal force (N), its derivatives by depth and by its rate, and rolling resistance over it."""

    force: float
    by_depth: float
    by_rate: float
    drag: float


@solving_within
def law_slopes(law: Impact, depth: float, rate: float) -> tuple[float, float, float]:
    """Normal force (N) of a law and its derivatives by depth and by its rate."""
    force = impact_force(law, depth, rate)
    if force <= 0.0:
        return 0.0, 0.0, 0.0
    part = min(depth / law.damping_depth, 1.0)
    faded = step(depth, 0.0, 0.0, law.damping_depth, 1.0)
    by_depth = law.exponent * law.stiffness * depth ** (law.exponent - 1.0)
    by_depth += law.damping * rate * 6.0 * part * (1.0 - part) / law.damping_depth
    return force, by_depth, law.damping * faded


@solving_within
def stored_energy(law: Impact, depth: float) -> float:
    """Energy (J) in a contact of this law, none where nothing touches."""
    return law.stiffness / (law.exponent + 1.0) * depth ** (law.exponent + 1.0) if depth > 0.0 else 0.0


@solving
def tread_force(
    law: Impact, rail: Rail, disc: Pair, center: Pair, rates: Pair, bending: Bending, derive: bool
) -> Tread:
    """Force of a rail on a strip whose normal law this is; with its derivatives, or with zeros for these.

    `disc` is its radius (m), and rolling resistance over normal force with the sign of the travel; `center`
    and `rates` are x and z of its centre in the shoe's frame (m) and their rates (m/s).
    """
    radius, drag = disc
    x = min(max(center[0], rail.rear), rail.front)
    inside = 1.0 if x == center[0] else 0.0
    outside = 1.0 - inside
    dx, dz = center[0] - x, center[1] - rail.height - bending.rise
    distance = math.sqrt(dx * dx + dz * dz)
    ex, ez = dx / distance, dz / distance
    # from the rail to the roller; within the rail along its bent normal
    nx, nz = ex - inside * bending.slope, ez
    depth = radius - distance
    rate = ez * bending.rate - nx * rates[0] - nz * rates[1]
    force, by_depth, by_rate = law_slopes(law, depth, rate)
    push, foot = (force * (nx - drag * nz), force * (nz + drag * nx)), (x, rail.height + bending.rise)
    if not derive:
        none = (0.0, 0.0)
        return Tread(push, foot, depth, inside, (none, none, none, none), (none, none, none))
    found = Slopes(force, by_depth, by_rate, drag)
    speeds = (rates[0], rates[1], outside * bending.rate)
    turn = outside / distance
    return Tread(
        push,
        foot,
        depth,
        inside,
        (
            _by_place(found, (nx, nz), -nx, (turn * ez * ez, -turn * ex * ez), speeds),
            _by_place(found, (nx, nz), -nz, (-turn * ex * ez, turn * ex * ex), speeds),
            _by_place(found, (nx, nz), ez, (turn * ex * ez, -turn * ex * ex), speeds),
            _by_place(found, (nx, nz), 0.0, (-inside, 0.0), speeds),
        ),
        (_by_rate(found, (nx, nz), -nx), _by_rate(found, (nx, nz), -nz), _by_rate(found, (nx, nz), ez)),
    )


@solving_within
def _by_place(found: Slopes, normal: Pair, deeper: float, turned: Pair, speeds: Triple) -> Pair:
    """Derivative of both forces by a place that makes the depth grow by `deeper` and turns the normal."""
    nx, nz = normal
    faster = speeds[2] * turned[1] - speeds[0] * turned[0] - speeds[1] * turned[1]
    more = found.by_depth * deeper + found.by_rate * faster
    return (
        more * (nx - found.drag * nz) + found.force * (turned[0] - found.drag * turned[1]),
        more * (nz + found.drag * nx) + found.force * (turned[1] + found.drag * turned[0]),
    )


@solving_within
def _by_rate(found: Slopes, normal: Pair, faster: float) -> Pair:
    """Derivative of both forces by a rate that makes the depth's grow by `faster`."""
    nx, nz = normal
    more = found.by_rate * faster
    return more * (nx - found.drag * nz), more * (nz + found.drag * nx)


TOUCHED = 2
"""Shoes that a strip may touch at once: the one at or behind its axis and the next."""
RISE = 0.02
"""m, more than a rail ever bends."""


class Rollers(NamedTuple):
    """Rollers of a frame, each with the same strips of treads."""

    frame: int  # body that carries them
    shoes: int  # number of shoes, the first bodies
    places: FloatArray  # (rollers, strips, 3): middle of every strip's axis in the frame's axes, m
    radius: float  # m
    law: tuple[float, float, float, float]  # `Impact` of a strip
    rail: tuple[float, float, float]  # `Rail`
    rows: FloatArray  # (strips, stations + 2, 3, m): as of `shoe_mesh.RailRows`
    spacing: float  # of the stations, m
    pitch: float  # of the chain, m


class TreadWorkspace(NamedTuple):
    """Treads as they touch at a state; t counts rollers, strips and touched shoes."""

    rows: tuple  # `ForceRows` of those that touch as a plain tuple: force on the frame, N, global
    rear: IntArray  # (rollers,): shoe at or behind the axis
    depth: FloatArray  # (t,): m; no touch unless positive
    force: FloatArray  # (t, 3): on the frame, N, global
    foot: FloatArray  # (t, 3): where, m, global
    modes: FloatArray  # (4, m): scratch, as of `rows_at`

    @classmethod
    def allocate(cls, rollers: int, strips: int, modes: int) -> "TreadWorkspace":
        """Workspace for so many rollers."""
        touches = rollers * strips * TOUCHED
        return cls(
            tuple(ForceRows.allocate(touches, 3, modes)),
            np.zeros(rollers, dtype=np.int64),
            np.zeros(touches),
            np.zeros((touches, 3)),
            np.zeros((touches, 3)),
            np.zeros((4, modes)),
        )


@solving_within
def rows_at(rollers: Rollers, strip: int, x: float, out: FloatArray) -> None:
    """Write displacement along x, y and z of a rail by the modes, and the slope of the last: (4, m).

    Between stations by the cubic through the two nearest on either side with the slopes that their neighbours
    give (Catmull and Rom, 1974), which has no kinks at stations.
    """
    t = (x - rollers.rail[0]) / rollers.spacing
    i = min(max(int(t), 0), rollers.rows.shape[1] - 4)
    u = t - i
    values = (
        0.5 * u * (u * (2.0 - u) - 1.0),
        1.0 + 0.5 * u * u * (3.0 * u - 5.0),
        0.5 * u * (1.0 + u * (4.0 - 3.0 * u)),
        0.5 * u * u * (u - 1.0),
    )
    slopes = (
        0.5 * (u * (4.0 - 3.0 * u) - 1.0) / rollers.spacing,
        0.5 * u * (9.0 * u - 10.0) / rollers.spacing,
        0.5 * (1.0 + u * (8.0 - 9.0 * u)) / rollers.spacing,
        0.5 * u * (3.0 * u - 2.0) / rollers.spacing,
    )
    table = rollers.rows[strip]
    for k in range(out.shape[1]):
        out[0, k] = out[1, k] = out[2, k] = out[3, k] = 0.0
        for n in range(4):
            out[0, k] += values[n] * table[i + n, 0, k]
            out[1, k] += values[n] * table[i + n, 1, k]
            out[2, k] += values[n] * table[i + n, 2, k]
            out[3, k] += slopes[n] * table[i + n, 2, k]


@solving_within
def bending(rows: FloatArray, own: FloatArray) -> Bending:
    """How modes bend a rail: rows (4, m) of `rows_at` times coordinates and rates (2, 6 + m)."""
    rise = slope = rate = aside = aside_rate = 0.0
    for k in range(rows.shape[1]):
        rise += rows[2, k] * own[0, 6 + k]
        slope += rows[3, k] * own[0, 6 + k]
        rate += rows[2, k] * own[1, 6 + k]
        aside += rows[1, k] * own[0, 6 + k]
        aside_rate += rows[1, k] * own[1, 6 + k]
    return Bending(rise, slope, rate, aside, aside_rate)


@solving_within
def _may_touch(rollers: Rollers, place: Vector, frame: Frame, shoe: Frame) -> bool:
    """Whether a strip is near a shoe's rail, however that bends."""
    apart = along(along(frame.r, 1.0, turned(frame.R, place)), -1.0, shoe.r)
    center, rail = turned_back(shoe.R, apart), rollers.rail
    dx = center[0] - min(max(center[0], rail[0]), rail[1])
    dz = center[2] - rail[2]
    return dx * dx + dz * dz < (rollers.radius + RISE) ** 2


@solving_inside
def motion_against(frame: Frame, shoe: Frame, place: Vector) -> tuple[Vector, Vector]:
    """Place (m) and velocity (m/s) of a point of a frame, at `place` in its axes, in a shoe's axes."""
    arm = turned(frame.R, place)
    apart = along(along(frame.r, 1.0, arm), -1.0, shoe.r)
    velocity = along(along(frame.v, 1.0, cross(frame.omega, arm)), -1.0, shoe.v)
    rates = turned_back(shoe.R, along(velocity, -1.0, cross(shoe.omega, apart)))
    return turned_back(shoe.R, apart), rates


@solving_within
def _touch(
    rollers: Rollers, strip: tuple[Vector, float], frame: Frame, shoe: Frame, bent: Bending, derive: bool
) -> Tread:
    """Force of a shoe's rail on a strip, in the shoe's axes, as of `tread_force`.

    `strip` is its middle in the frame's axes (m), and rolling resistance over normal force with the sign of
    the travel.
    """
    place, drag = strip
    center, rates = motion_against(frame, shoe, place)
    disc = (rollers.radius, drag)
    law, rail = Impact(*rollers.law), Rail(*rollers.rail)
    return tread_force(law, rail, disc, (center[0], center[2]), (rates[0], rates[2]), bent, derive)


@solving_inside
def write_tangent(tread: Tread, R: tuple, weights: Weights, out: FloatArray) -> None:
    """Write the weighted tangent (3, 3) of a tread by the motion of its centre against the rail."""
    for r in range(3):
        for c in range(3):
            out[r, c] = 0.0
    for k in range(2):
        x = weights.position * tread.by_place[k][0] + weights.velocity * tread.by_rate[k][0]
        z = weights.position * tread.by_place[k][1] + weights.velocity * tread.by_rate[k][1]
        change = turned(R, (x, 0.0, z))
        for r in range(3):
            for c in range(3):
                out[r, c] -= change[r] * R[c][2 * k]


@solving_inside
def write_point(at: Attitude, arm: Vector, sign: float, jacobian: FloatArray) -> None:
    """Write how a point of a rigid body moves, times a sign: `arm` leads there from its origin, m, global."""
    for c in range(3):
        by_angle = cross(at.axes[c], arm)
        for r in range(3):
            jacobian[r, c] = sign if r == c else 0.0
            jacobian[r, 3 + c] = sign * by_angle[r]


@solving_inside
def write_rows(
    rows: ForceRows,
    p: int,
    force: Vector,
    arms: tuple[Vector, Vector],
    frames: tuple[Attitude, Attitude],
    modes: FloatArray,
    flexible: bool,
) -> None:
    """Write a tread that pushes the frame with a force (N, global), and the shoe with the opposite.

    `arms` (m, global) lead from the origins of frame and shoe to the foot, `frames` are their attitudes;
    `modes` of a flexible shoe are as of `rows_at`.
    """
    rows.unit[p] = -1
    for k in range(2):
        write_point(frames[k], arms[k], 1.0 - 2.0 * k, rows.jacobian[p, k])
    for m in range(modes.shape[1] if flexible else 0):
        move = turned(frames[1].R, (modes[0, m], modes[1, m], modes[2, m]))
        for r in range(3):
            rows.jacobian[p, 1, r, 6 + m] = -move[r]
    for r in range(3):
        rows.wrench[p, r] = force[r]


@solving_within
def tread_contacts(
    rollers: tuple | None, bodies: Bodies, state: FloatArray, drag: float, weights: Weights, work: tuple
) -> int:
    """Find the treads that touch at a state and give their number; none where there are no rollers.

    `rollers` and `work` are `Rollers` and `TreadWorkspace` as plain tuples, `drag` is rolling resistance over
    normal force with the sign of the travel.
    """
    if rollers is None:
        return 0
    return _tread_contacts(Rollers(*rollers), bodies, state, drag, weights, TreadWorkspace(*work))


@solving_allocating
def _tread_contacts(
    rollers: Rollers, bodies: Bodies, state: FloatArray, drag: float, weights: Weights, work: TreadWorkspace
) -> int:
    rows, count = ForceRows(*work.rows), 0
    derive = weights.position != 0.0 or weights.velocity != 0.0
    at = attitude_of(bodies, rollers.frame)
    frame = frame_of(bodies, rollers.frame, state, at)
    values = np.zeros((2, 6 + work.modes.shape[1]))
    strips, first = rollers.places.shape[1], bodies.reference[0, 0] + state[0, bodies.coordinate[0]]
    for r in range(rollers.places.shape[0]):
        axis = frame.r[0] + turned(frame.R, (rollers.places[r, 0, 0], 0.0, rollers.places[r, 0, 2]))[0]
        rear = math.floor((axis - first) / rollers.pitch)
        work.rear[r] = min(max(rear, 0), rollers.shoes - TOUCHED)
        for half in range(TOUCHED):
            s = work.rear[r] + half
            shoe_at = attitude_of(bodies, s)
            shoe = frame_of(bodies, s, state, shoe_at)
            for k in range(strips):
                t = (r * strips + k) * TOUCHED + half
                work.depth[t] = 0.0
                place = (rollers.places[r, k, 0], rollers.places[r, k, 1], rollers.places[r, k, 2])
                if not _may_touch(rollers, place, frame, shoe):
                    continue
                center = along(along(frame.r, 1.0, turned(frame.R, place)), -1.0, shoe.r)
                local = turned_back(shoe.R, center)
                work.modes.fill(0.0)
                if bodies.modal[s] >= 0:
                    read_body(bodies, s, state[0], values[0])
                    read_body(bodies, s, state[1], values[1])
                    rows_at(rollers, k, min(max(local[0], rollers.rail[0]), rollers.rail[1]), work.modes)
                bent = bending(work.modes, values)
                tread = _touch(rollers, (place, drag), frame, shoe, bent, derive)
                if tread.depth <= 0.0:
                    continue
                shoe_arm = turned(shoe.R, (tread.foot[0], local[1], tread.foot[1]))
                foot = along(shoe.r, 1.0, shoe_arm)
                force = turned(shoe.R, (tread.force[0], 0.0, tread.force[1]))
                rows.bodies[count, 0], rows.bodies[count, 1] = rollers.frame, s
                arms = (along(foot, -1.0, frame.r), shoe_arm)
                write_rows(rows, count, force, arms, (at, shoe_at), work.modes, bodies.modal[s] >= 0)
                if derive:
                    write_tangent(tread, shoe.R, weights, rows.tangent[count])
                work.depth[t] = tread.depth
                for c in range(3):
                    work.force[t, c], work.foot[t, c] = force[c], foot[c]
                count += 1
    return count
