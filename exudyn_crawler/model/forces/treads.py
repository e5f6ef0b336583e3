"""Law of a strip of a wheel's tread on the rail of a shoe, as functions of numbers.

The force acts at the rail's nearest point on both bodies, so that action equals reaction in moment too: the
rolling resistance is assumed to be the friction of the wheel's bearing and seals. At this point the body that
carries the wheel moves over the rail at the speed of the wheel's rim in its bearing. The resistance opposes
that speed and fades with it. It never adds energy, and is zero for a wheel at rest.

In the shoe's x-z plane the strip is a disc about the wheel's axis and the rail a segment, which ends at the
gap to the next shoe; a flexible shoe's rail is bent. Depth is the disc's radius less the distance of its
centre to the segment, ends included, so that a disc over a gap lies on the edges of both shoes. The force is
the gradient of the depth times the normal law, and the rail's bending is loaded by the same force: the
elastic part has a potential. Resistance is along the rail.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import turned
from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.forces.impact import law_slopes

Pair = tuple[float, float]
Triple = tuple[float, float, float]


class Rail(NamedTuple):
    """Rail of an unbent shoe in its frame, m: x of its ends, z of its top."""

    rear: float
    front: float
    height: float


class Disc(NamedTuple):
    """Strip of a wheel."""

    radius: float  # m
    resistance: float  # over the normal force; of a wheel that turns in its bearing, or of a line that rubs
    fading: float  # m/s over the rail, at which it has 0.7 of the resistance


class Bending(NamedTuple):
    """Bending of a rail at a tread: rise (m), slope and rate of the rise (m/s); aside, m and m/s.

    The last value is the rate along the rail, m/s.
    """

    rise: float
    slope: float
    rate: float
    aside: float = 0.0
    aside_rate: float = 0.0
    along_rate: float = 0.0


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
    """Normal force (N), its derivatives by depth and by its rate; resistance over it, and by the speed."""

    force: float
    by_depth: float
    by_rate: float
    drag: float
    by_speed: float  # s/m


class Sliding(NamedTuple):
    """Motion over a rail of the body that carries a wheel."""

    x_rate: float  # of the wheel's centre along the rail, m/s
    z_rate: float  # m/s
    spin: float  # about y, rad/s


@kernel
def tread_force(
    law: Impact, rail: Rail, disc: Disc, center: Pair, rates: Triple, bending: Bending, derive: bool
) -> Tread:
    """Return the force of a rail on a strip with this normal law; its derivatives, or zeros without `derive`.

    `center` are x and z of its centre in the shoe's frame (m). `rates` are their rates (m/s) and the angular
    velocity about y, against the shoe, of the body that carries the wheel (rad/s).
    """
    x = min(max(center[0], rail.rear), rail.front)
    inside = 1.0 if x == center[0] else 0.0
    outside = 1.0 - inside
    dx = center[0] - x
    dz = center[1] - rail.height - bending.rise
    distance = math.sqrt(dx * dx + dz * dz)
    ex = dx / distance
    ez = dz / distance
    # from the rail to the roller; within the rail along its bent normal
    nx = ex - inside * bending.slope
    nz = ez
    depth = disc.radius - distance
    rate = ez * bending.rate - nx * rates[0] - nz * rates[1]
    force, by_depth, by_rate = law_slopes(law, depth, rate)
    sliding = Sliding(rates[0] - bending.along_rate, rates[1] - bending.rate, rates[2])
    drag, by_speed = resistance(disc, sliding.x_rate * nz - sliding.z_rate * nx - sliding.spin * distance)
    push = (force * (nx - drag * nz), force * (nz + drag * nx))
    foot = (x, rail.height + bending.rise)
    if not derive:
        none = (0.0, 0.0)
        return Tread(push, foot, depth, inside, (none, none, none, none), (none, none, none))
    slopes = Slopes(force, by_depth, by_rate, drag, by_speed)
    speeds = (rates[0], rates[1], outside * bending.rate)
    turn = outside / distance
    return Tread(
        push,
        foot,
        depth,
        inside,
        (
            _by_place(slopes, (nx, nz), -nx, (turn * ez * ez, -turn * ex * ez), speeds, sliding),
            _by_place(slopes, (nx, nz), -nz, (-turn * ex * ez, turn * ex * ex), speeds, sliding),
            _by_place(slopes, (nx, nz), ez, (turn * ex * ez, -turn * ex * ex), speeds, sliding),
            _by_place(slopes, (nx, nz), 0.0, (-inside, 0.0), speeds, sliding),
        ),
        (
            _by_rate(slopes, (nx, nz), -nx, nz),
            _by_rate(slopes, (nx, nz), -nz, -nx),
            _by_rate(slopes, (nx, nz), ez, nx),
        ),
    )


@kernel
def resistance(disc: Disc, speed: float) -> tuple[float, float]:
    """Return rolling resistance over normal force at a speed (m/s) over the rail, and its slope (s/m).

    It follows the sign of the speed as ``v / sqrt(v**2 + v_r**2)``: at rest it is zero.
    """
    whole = math.sqrt(speed * speed + disc.fading * disc.fading)
    return disc.resistance * speed / whole, disc.resistance * disc.fading * disc.fading / whole**3


@inner
def _by_place(
    slopes: Slopes, normal: Pair, deeper: float, turned: Pair, speeds: Triple, sliding: Sliding
) -> Pair:
    """Return derivatives of both forces by a motion that deepens by `deeper` and rotates the normal."""
    nx, nz = normal
    faster = speeds[2] * turned[1] - speeds[0] * turned[0] - speeds[1] * turned[1]
    more = slopes.by_depth * deeper + slopes.by_rate * faster
    over = sliding.x_rate * turned[1] - sliding.z_rate * turned[0] + sliding.spin * deeper
    drawn = slopes.force * slopes.by_speed * over
    return (
        more * (nx - slopes.drag * nz) + slopes.force * (turned[0] - slopes.drag * turned[1]) - drawn * nz,
        more * (nz + slopes.drag * nx) + slopes.force * (turned[1] + slopes.drag * turned[0]) + drawn * nx,
    )


@inner
def _by_rate(slopes: Slopes, normal: Pair, deeper: float, over: float) -> Pair:
    """Return derivatives of both forces by a rate, from its shares in the depth's rate and in the speed."""
    nx, nz = normal
    more = slopes.by_rate * deeper
    drawn = slopes.force * slopes.by_speed * over
    return more * (nx - slopes.drag * nz) - drawn * nz, more * (nz + slopes.drag * nx) + drawn * nx


@inner(merged=True)
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
