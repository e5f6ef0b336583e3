"""What the compiled equations of a track are made of: what stays, what time changes, and their memory."""

from typing import NamedTuple

from exudyn_crawler.ground.frames import Vector, inlined
from exudyn_crawler.ground.rotations import FloatArray
from exudyn_crawler.model.compiled.bodies import Body
from exudyn_crawler.model.compiled.elimination import Fronts, IntArray
from exudyn_crawler.model.compiled.joints import Pins
from exudyn_crawler.model.compiled.own import Sizes


class Ground(NamedTuple):
    """Terrain in its own coordinates, whose mass is 1; arrays over them.

    `heave` and `tilt` (units, coordinates) carry the units, `reference` (units, 4) is where they are with
    free springs; `stiffness` (1/s2) and `damping` (1/s) are of the supports, `weight` the load of a unit of
    gravity.
    """

    heave: FloatArray
    tilt: FloatArray
    reference: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    weight: FloatArray


class Places(NamedTuple):
    """Where in the fronts the terms of the equations go.

    Attributes
    ----------
    terrain : array (shoes,)
        Row of the terrain's first coordinate in the front of each shoe.
    pins : array (pins, 2)
        Row of a pin's first multiplier in the fronts of its shoes.
    drive : array (2,)
        Rows of the multipliers of drive and turn in the front of the last shoe.
    border : array (3,)
        Number of the last front, which the terrain heads, and rows of drive and turn in it.
    frame : array (shoes + 1, 2)
        Rows of the side frame's first coordinate and of its pull, the multiplier of the drive, in the fronts
        of all shoes and in the last one.
    """

    terrain: IntArray
    pins: IntArray
    drive: IntArray
    border: IntArray
    frame: IntArray


class Model(NamedTuple):
    """All that does not change; `contact` is `pair_track.Track`, `side` is `SideFrame` as plain tuples.

    `side` is empty where there is no side frame: its numbers alone would take a third more time to compile.
    """

    sizes: Sizes
    rigid: Body
    flexible: Body
    row: IntArray
    reference: FloatArray
    ground: Ground
    pins: Pins
    pulled: tuple[FloatArray, FloatArray, FloatArray]
    contact: tuple
    fronts: Fronts
    places: Places
    side: tuple


class Inputs(NamedTuple):
    """What time makes of loads and drive.

    Attributes
    ----------
    gravity : Vector
        m/s2, global.
    loads : array (shoes, 3)
        Machine loads, N, global.
    shift : float
        How far they act to the left of their places, m.
    drive : array (2, 2)
        Of drive and turn: whether it acts (1 or 0), and the speed, m/s or rad/s.
    travel : array (3,)
        Way of the side frame along x (m), its speed and acceleration.
    machine : array (6,)
        Force (N) and moment about the side frame's origin (N m) beside its weight, global.
    drag : float
        Rolling resistance over normal force, with the sign of the speed.
    """

    gravity: Vector
    loads: FloatArray
    shift: float
    drive: FloatArray
    travel: FloatArray
    machine: FloatArray
    drag: float


class Weights(NamedTuple):
    """Weights of the derivatives by coordinates, rates and accelerations.

    `secant` as of `triplets.Weights`; `level` is what turns what a constraint on velocity is off into a gap.
    """

    position: float
    velocity: float
    acceleration: float
    secant: bool
    level: float


class Memory(NamedTuple):
    """What an evaluation leaves for the derivative and for the next one.

    Attributes
    ----------
    units, unit_rates : array (units, 4)
        Places and rates of the units.
    touching : tuple
        `TouchingPairs` as a plain tuple.
    first, second, turning : array (shoes, ...)
        `Inertia` of every shoe.
    off : array (multipliers,)
        What constraints are off, m, rad and their rates.
    pins : array (pins, 2, ROWS, 6 + modes)
        Directions of the pins.
    drive : array (2, 6 + modes)
        Directions of drive and turn.
    work : array
        Scratch of the contact.
    rolling : tuple
        `Rolling` as a plain tuple; an empty one without a side frame.
    """

    units: FloatArray
    unit_rates: FloatArray
    touching: tuple
    first: FloatArray
    second: FloatArray
    turning: FloatArray
    off: FloatArray
    pins: FloatArray
    drive: FloatArray
    work: FloatArray
    rolling: tuple


@inlined
def named_model(values: tuple) -> Model:
    """Model of its values as plain tuples, which Python hands over in less time."""
    (
        sizes,
        rigid,
        flexible,
        row,
        reference,
        ground,
        pins,
        pulled,
        contact,
        fronts,
        places,
        side,
    ) = values
    return Model(
        Sizes(*sizes),
        Body(*rigid),
        Body(*flexible),
        row,
        reference,
        Ground(*ground),
        Pins(*pins),
        pulled,
        contact,
        Fronts(*fronts),
        Places(*places),
        side,
    )
