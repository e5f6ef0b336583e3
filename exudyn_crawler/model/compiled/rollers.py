"""Rollers of a side frame on the rails of the shoes, and what pulls the chain.

The side frame is a rigid body whose travel is prescribed; its heave, roll and pitch are unknown. Each strip
of a tread may touch the shoe at or behind its axis and the next one. The force acts at the rail's nearest
point on both bodies, so that action equals reaction in moment too: what resists rolling is taken to be the
friction of the roller's bearing and seals.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import Frame, Vector, along, basis, cross, dot, turned, turned_back
from exudyn_crawler.ground.laws.impact import Impact
from exudyn_crawler.ground.rotations import Attitude, FloatArray
from exudyn_crawler.model.compiled.bodies import Body
from exudyn_crawler.model.compiled.elimination import IntArray, solving_within
from exudyn_crawler.model.compiled.treads import Bending, Rail, Tread, tread_force

FRAME = 3
"""Coordinates of the side frame: heave, then the angles about x and y."""
TOUCHED = 2
"""Shoes that a strip may touch at once: the one at or behind its axis and the next."""
FORCES, CHANGES = 13, 11
"""Rows and columns of a tread's derivative.

Rows: what the force adds to the residual of the shoe's six coordinates, of the frame's x and of its three;
force along x and z in the shoe's axes; along z times how far its foot moves. Columns: the shoe's six
coordinates, the frame's three, rise and slope of the rail.
"""


class Rollers(NamedTuple):
    """Rollers of a side frame, each with the same strips of treads.

    Attributes
    ----------
    places : array (rollers, strips, 3)
        Middle of every strip's axis in the frame's axes, m.
    radius : float
        m.
    law : tuple
        `Impact` of a strip.
    rail : tuple
        `Rail`.
    rows : array (strips, stations + 2, 2, m)
        Displacement along x and z of a flexible shoe's rail under each strip by its modes, at stations from
        the rail's rear end to its front end, and extrapolated by one on either side.
    spacing : float
        Of the stations, m.
    pitch : float
        Of the chain, m.
    tumbler : float
        x in the frame where the chain is pulled, m.
    pins : array (2, 3)
        Middle of the rear and of the front pins of a shoe, m.
    pin_rows : array (2, 3, m)
        Their displacement by the modes.
    tension : float
        Pull on both ends of the chain, N.
    """

    places: FloatArray
    radius: float
    law: tuple[float, float, float, float]
    rail: tuple[float, float, float]
    rows: FloatArray
    spacing: float
    pitch: float
    tumbler: float
    pins: FloatArray
    pin_rows: FloatArray
    tension: float


class SideFrame(NamedTuple):
    """A side frame: its body in axes whose origin is at its rollers, and the rollers.

    `place` (3,) is where its origin is where its coordinates and its travel are zero, on rails that have not
    settled, m.
    """

    body: Body
    place: FloatArray
    rollers: Rollers


class Rolling(NamedTuple):
    """What an evaluation leaves of treads and pull; t counts rollers, strips and touched shoes.

    Attributes
    ----------
    rear : array (rollers,)
        Shoe at or behind the axis.
    depth : array (t,)
        m; no touch unless positive.
    force, foot : array (t, 3)
        On the frame, N, and where, m, global.
    change : array (t, FORCES, CHANGES)
        Weighted derivatives.
    rows : array (t, 3, m)
        Displacement of the foot by the shoe's modes along x and z, and the slope of the latter.
    first, second, turning : array (3,), (3, 3), (3, 0)
        `Inertia` of the frame.
    link : array (1,)
        Shoe behind the first link that is pulled.
    share : array (2,)
        Shares of this link and the next in the pull.
    pull : array (2, 6 + m)
        Directions of a unit pull on the shoes behind them.
    pulling : array (FRAME,)
        Generalized forces of a unit pull on the frame.
    """

    rear: IntArray
    depth: FloatArray
    force: FloatArray
    foot: FloatArray
    change: FloatArray
    rows: FloatArray
    first: FloatArray
    second: FloatArray
    turning: FloatArray
    link: IntArray
    share: FloatArray
    pull: FloatArray
    pulling: FloatArray

    @classmethod
    def room(cls, rollers: int, strips: int, modes: int) -> "Rolling":
        """Memory for so many rollers."""
        touches = rollers * strips * TOUCHED
        return cls(
            np.zeros(rollers, dtype=np.int64),
            np.zeros(touches),
            np.zeros((touches, 3)),
            np.zeros((touches, 3)),
            np.zeros((touches, FORCES, CHANGES)),
            np.zeros((touches, 3, modes)),
            np.zeros(3),
            np.zeros((3, 3)),
            np.zeros((3, 0)),
            np.zeros(1, dtype=np.int64),
            np.zeros(2),
            np.zeros((2, 6 + modes)),
            np.zeros(FRAME),
        )


@solving_within
def rows_at(rollers: Rollers, strip: int, x: float, out: FloatArray) -> None:
    """Write displacement along x and z of a rail by the modes, and the slope of the latter: (3, m).

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
        out[0, k] = out[1, k] = out[2, k] = 0.0
        for n in range(4):
            out[0, k] += values[n] * table[i + n, 0, k]
            out[1, k] += values[n] * table[i + n, 1, k]
            out[2, k] += slopes[n] * table[i + n, 1, k]


@solving_within
def bending(rows: FloatArray, own: FloatArray) -> Bending:
    """How modes bend a rail: rows (3, m) of `rows_at` times coordinates and rates (2, 6 + m)."""
    rise = slope = rate = 0.0
    for k in range(rows.shape[1]):
        rise += rows[1, k] * own[0, 6 + k]
        slope += rows[2, k] * own[0, 6 + k]
        rate += rows[1, k] * own[1, 6 + k]
    return Bending(rise, slope, rate)


class Meeting(NamedTuple):
    """Strip and shoe that meet: vectors (global, m) and what the rail does.

    `arm` from the frame's origin to the strip's middle, `apart` from the shoe's origin to it, `shoe_arm` and
    `frame_arm` from the origins to the foot; `force` on the frame, N.
    """

    tread: Tread
    slope: float
    arm: Vector
    apart: Vector
    shoe_arm: Vector
    frame_arm: Vector
    force: Vector


@solving_within
def meet(rollers: Rollers, strip: tuple[Vector, float], frame: Frame, shoe: Frame, bent: Bending) -> Meeting:
    """Force of a shoe's rail on a strip.

    Parameters
    ----------
    strip : tuple
        Its middle in the frame's axes (m), and rolling resistance over normal force with the sign of the
        travel.
    """
    place, drag = strip
    arm = turned(frame.R, place)
    apart = along(along(frame.r, 1.0, arm), -1.0, shoe.r)
    velocity = along(along(frame.v, 1.0, cross(frame.omega, arm)), -1.0, shoe.v)
    center = turned_back(shoe.R, apart)
    rates = turned_back(shoe.R, along(velocity, -1.0, cross(shoe.omega, apart)))
    tread = tread_force(
        Impact(*rollers.law),
        Rail(*rollers.rail),
        (rollers.radius, drag),
        (center[0], center[2]),
        (rates[0], rates[2]),
        bent,
    )
    shoe_arm = turned(shoe.R, (tread.foot[0], center[1], tread.foot[1]))
    frame_arm = along(along(shoe.r, 1.0, shoe_arm), -1.0, frame.r)
    force = turned(shoe.R, (tread.force[0], 0.0, tread.force[1]))
    return Meeting(tread, bent.slope, arm, apart, shoe_arm, frame_arm, force)


@solving_within
def _place_change(c: int, axes: tuple, frame_axes: tuple) -> tuple[Vector, Vector, Vector, Vector]:
    """Displacement and rotation of the shoe, then of the frame, by coordinate c of `CHANGES`."""
    none = (0.0, 0.0, 0.0)
    if c < 3:
        return basis(c), none, none, none
    if c < 6:
        return none, axes[c - 3], none, none
    if c == 6:
        return none, none, (0.0, 0.0, 1.0), none
    return none, none, none, frame_axes[c - 7]


@solving_within
def write_change(
    met: Meeting, shoe: Attitude, frame: Attitude, by_place: float, by_rate: float, out: FloatArray
) -> None:
    """Write the weighted derivative of a tread's force (FORCES, CHANGES).

    Centres move as their places do, and so do rates: how these change as the bodies turn is left out.
    """
    tread, force = met.tread, met.force
    moment, frame_moment = cross(met.shoe_arm, force), cross(met.frame_arm, force)
    for c in range(CHANGES):
        moves = (0.0, 0.0, 0.0)
        shift, turn, frame_shift, frame_turn = moves, moves, moves, moves
        if c < 9:
            shift, turn, frame_shift, frame_turn = _place_change(c, shoe.axes, frame.axes)
            apart = along(along(frame_shift, 1.0, cross(frame_turn, met.arm)), -1.0, shift)
            moves = turned_back(shoe.R, along(apart, -1.0, cross(turn, met.apart)))
        rise, slope = 1.0 if c == 9 else 0.0, 1.0 if c == 10 else 0.0
        x, z = 0.0, 0.0
        for k, move in enumerate((moves[0], moves[2], rise, slope)):
            x += by_place * move * tread.by_place[k][0]
            z += by_place * move * tread.by_place[k][1]
        for k, move in enumerate((moves[0], moves[2], rise)):
            x += by_rate * move * tread.by_rate[k][0]
            z += by_rate * move * tread.by_rate[k][1]
        ahead = by_place * tread.inside * moves[0]
        change = along(turned(shoe.R, (x, 0.0, z)), by_place, cross(turn, force))
        foot = turned(shoe.R, (ahead, by_place * moves[1], by_place * rise + met.slope * ahead))
        foot = along(foot, by_place, cross(turn, met.shoe_arm))
        frame_foot = along(along(foot, by_place, shift), -by_place, frame_shift)
        turning = along(cross(foot, force), 1.0, cross(met.shoe_arm, change))
        frame_turning = along(cross(frame_foot, force), 1.0, cross(met.frame_arm, change))
        for r in range(3):
            out[r, c] = change[r]
            out[3 + r, c] = dot(shoe.axes[r], turning)
            if 3 <= c < 3 + r:
                # the axis that the angle turns about turns with the angles before
                out[3 + r, c] += by_place * dot(cross(shoe.axes[c - 3], shoe.axes[r]), moment)
        out[6, c], out[7, c] = -change[0], -change[2]
        out[8, c], out[9, c] = -dot(frame.axes[0], frame_turning), -dot(frame.axes[1], frame_turning)
        if c == 7:
            out[9, c] -= by_place * dot(cross(frame.axes[0], frame.axes[1]), frame_moment)
        out[10, c], out[11, c], out[12, c] = x, z, tread.force[1] * ahead
