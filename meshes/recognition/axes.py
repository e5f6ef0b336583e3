"""Unit and axes of a shoe from its pins: x from the rear to the front pin, y to the left along them, z up.

A `Question` holds each choice that geometry leaves open, the choice made, and the flag that decides it.
"""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from fem.body.mesh import Floats
from meshes.recognition.bands import level_parts, two_rails
from meshes.recognition.pins import CLOSE, PinLine, PinPair
from meshes.recognition.triangles import Triangles

Unit = Literal["mm", "m", "inch", "cm"]
Sole = Literal["plate", "tips"]

UNITS: dict[Unit, float] = {"mm": 1e-3, "m": 1.0, "inch": 0.0254, "cm": 1e-2}
"""Units of length in m, the likeliest unit of a file first."""
LEAST_PITCH = 0.05
GREATEST_PITCH = 1.5
"""Range of shoe pitches of any machine, m."""
LEAST_MASS = 1.0
GREATEST_MASS = 2e4
"""Range of shoe masses of any machine, kg."""
STEEL_DENSITY = 7850.0
"""Density, kg/m3, for the plausibility of a unit."""
KILO = 1e3
RANGE = (
    f"a pitch of {LEAST_PITCH:g} to {GREATEST_PITCH:g} m and a mass of {LEAST_MASS:g} kg to "
    f"{GREATEST_MASS / KILO:g} t"
)
SAME_REACH = 0.02
"""Tolerance of equal reach of both ends' outer lugs, fraction of the reach."""
WEAK = 0.25
OPPOSED = -0.04
"""Limits of an unsure up: magnitude of the sum of its two signs, and their product."""
OUTER = 0.4
"""Greatest depth below the outline of a plane that counts for up, fraction of the height."""
RAIL = 0.02
"""Least area of a rail, fraction of the largest level part that faces the same way."""
PIN_LIFT = 4.0
"""Factor on the pin height above the COM over the shoe's height: a sign of up of 1 at a quarter."""
LEVEL = np.radians(2.0)
"""Greatest angle of a possible underside to the axes from the bores, rad."""
ALIGNED = np.radians(0.6)
"""Greatest turn of the axes that levels this plane, rad: the error of axes of coarse bores."""
SAME_PLANE = np.radians(0.1)
"""Angle between neighbouring faces of one plane, rad."""


class Question(NamedTuple):
    """Choice that geometry leaves open.

    Attributes
    ----------
    flag : str
        Flag of the command that decides the choice.
    words : str
        Description of the open choice and of the one made.
    """

    flag: str
    words: str

    def __str__(self) -> str:
        return f"{self.words}; {self.flag} decides"


class NodesUnit(NamedTuple):
    """Unit of the nodes of a solid if its file names a unit.

    Attributes
    ----------
    of_nodes : str
        Unit of the coordinates after conversion.
    name : str
        Unit named by the file.
    metres : float
        Unit named by the file in m.
    """

    of_nodes: Unit
    name: str
    metres: float


class Choices(NamedTuple):
    """User's decisions on open choices; None leaves a choice to the geometry."""

    unit: Unit | None = None
    flip_front: bool = False
    flip_up: bool = False
    footprint: Sole | None = None
    body: str | None = None
    pins: int = 1


@dataclass(frozen=True, eq=False)
class ShoeAxes:
    """Axes of a shoe in the axes of its file.

    Attributes
    ----------
    rows : array (3, 3)
        Unit vectors x, y and z of the shoe.
    origin : array (3,)
        Centre of mass, in the file's unit.
    unit : str
    pins : PinPair
        Rear and front pins, in the file's unit.
    questions : tuple of Question
    """

    rows: Floats
    origin: Floats
    unit: Unit
    pins: PinPair
    questions: tuple[Question, ...]

    @property
    def scale(self) -> float:
        """Unit of the file in m."""
        return UNITS[self.unit]

    def place_of(self, line: PinLine) -> Floats:
        """Return the point of a pin's axis at the y of the COM, in the shoe's axes, m."""
        point = self.scale * self.rows @ (line.point - self.origin)
        axis = self.rows @ line.axis
        return np.asarray(point - axis * point[1] / axis[1])


def find_axes(
    triangles: Triangles, pairs: list[PinPair], choices: Choices, named: NodesUnit | None = None
) -> ShoeAxes:
    """Find unit and axes of a shoe from its pins, and the open choices.

    `choices` do not change the unit if the file has `named` one.

    Raises
    ------
    ValueError
        If no unit gives a plausible shoe, or the unit of the file or the user does not.
    """
    questions = []
    pair = pairs[0]
    if len(pairs) > 1 and choices.pins == 1 and pairs[1].score > CLOSE * pair.score:
        words = (
            f"another pair of bores, {pairs[1].pitch / pair.pitch:.3g} times as far apart, could be the pins"
        )
        questions.append(Question("--pins 2", words))
    unit, asked = _unit(pair.pitch, triangles.volume, choices.unit, named)
    questions += asked
    ordered, asked = _front(pair, choices)
    axes = ShoeAxes(_rows(ordered), triangles.center, unit, ordered, ())
    turned, more = _upright(triangles, axes, choices)
    questions += asked + more
    return replace(_levelled(triangles, turned), questions=tuple(questions))


def _unit(
    pitch: float, volume: float, chosen: Unit | None, named: NodesUnit | None
) -> tuple[Unit, list[Question]]:
    """Return the unit of a solid's coordinates with plausible pitch and mass of a shoe."""
    if named is not None:
        size = UNITS[named.of_nodes]
        if not _is_shoe(pitch * size, volume * size**3):
            # numbers of the file
            numbers = pitch * size / named.metres, volume * (size / named.metres) ** 3
            raise ValueError(
                f"is the unit wrong? The file names {named.name}, with which "
                f"{_implausible(*numbers, named.metres)}; {_likely(*numbers)}: "
                "export the shoe again in its correct unit"
            )
        return named.of_nodes, []
    if chosen is not None:
        if not _is_shoe(pitch * UNITS[chosen], volume * UNITS[chosen] ** 3):
            raise ValueError(
                f"with --unit {chosen} {_implausible(pitch, volume, UNITS[chosen])}; {_likely(pitch, volume)}"
            )
        return chosen, []
    fits = _fitting_units(pitch, volume)
    if not fits:
        raise ValueError(
            f"the shoe must have {RANGE} in mm, m, inch or cm; with a pitch of {pitch:.4g} and a volume of "
            f"{volume:.4g} in its unit it has neither"
        )
    if len(fits) == 1:
        return fits[0], []
    sizes = ", ".join(f"{unit}: pitch {pitch * UNITS[unit]:.4g} m" for unit in fits)
    return fits[0], [Question("--unit", f"the unit may be {sizes}; {fits[0]} was taken")]


def _is_shoe(pitch: float, volume: float) -> bool:
    """Return True if pitch (m) and volume (m3) are those of a steel shoe of any machine."""
    return LEAST_PITCH <= pitch <= GREATEST_PITCH and LEAST_MASS <= volume * STEEL_DENSITY <= GREATEST_MASS


def _fitting_units(pitch: float, volume: float) -> list[Unit]:
    """Return the units with plausible pitch and volume of a shoe, the likeliest first."""
    return [unit for unit, size in UNITS.items() if _is_shoe(pitch * size, volume * size**3)]


def _sizes(pitch: float, volume: float, size: float) -> str:
    """Describe pitch and mass of a steel shoe, from numbers in a unit of `size` m."""
    mass = volume * size**3 * STEEL_DENSITY
    weight = f"{mass:.4g} kg" if mass < KILO else f"{mass / KILO:.4g} t"
    return f"a pitch of {pitch * size:.4g} m and {weight}"


def _implausible(pitch: float, volume: float, size: float) -> str:
    """Describe a shoe of implausible size, from its pitch and volume in a unit of `size` m."""
    return f"the shoe would have {_sizes(pitch, volume, size)} of steel; shoes have {RANGE}"


def _likely(pitch: float, volume: float) -> str:
    """Describe the shoe in the units that make it plausible."""
    fits = _fitting_units(pitch, volume)
    shown = " or ".join(f"{_sizes(pitch, volume, UNITS[unit])} in {unit}" for unit in fits)
    return f"it would have {shown}" if fits else "no unit of mm, m, inch and cm makes it one"


def _front(pair: PinPair, choices: Choices) -> tuple[PinPair, list[Question]]:
    """Return the pair with the rear line first: the front has the outer lugs (fork), as on the ready shoe."""
    reaches = [float(np.ptp(line.spans(pair.axis))) for line in pair.lines]
    counts = [len(line.bores) for line in pair.lines]
    asked: list[Question] = []
    same = abs(reaches[0] - reaches[1]) <= SAME_REACH * max(reaches)
    first_is_front = counts[0] > counts[1] if same else reaches[0] > reaches[1]
    if same and counts[0] == counts[1]:
        # for equal ends the larger coordinate decides, so that all files of a shoe give the same front
        asked = [Question("--flip-front", "both ends have equal lugs: either may lead")]
    if first_is_front != choices.flip_front:
        rear = pair.lines[1]
        front = pair.lines[0]
        return replace(pair, lines=(rear, front), ahead=-pair.ahead), asked
    return pair, asked


def _rows(pair: PinPair) -> Floats:
    """Return the axes without a decision on up."""
    return np.array([pair.ahead, pair.axis, np.cross(pair.ahead, pair.axis)])


def _upright(triangles: Triangles, axes: ShoeAxes, choices: Choices) -> tuple[ShoeAxes, list[Question]]:
    """Return the axes with z up: pins are above the COM, and the largest plane near the outline faces down.

    If these signs are weak, two rails on only one side mark the top.
    """
    local = triangles.moved(axes.origin, axes.rows, axes.scale)
    low = local.points[:, 2].min()
    high = local.points[:, 2].max()
    pins = np.mean([axes.place_of(line)[2] for line in axes.pins.lines])
    lift = float(np.clip(PIN_LIFT * pins / (high - low), -1.0, 1.0))
    planes = [_outer_plane(local, sign) for sign in (-1.0, 1.0)]
    larger = (planes[0] - planes[1]) / max(sum(planes), 1e-300)
    total = lift + larger
    asked = []
    if abs(total) < WEAK or lift * larger < OPPOSED:
        rails = rails_up(local, axes.pins.pitch * axes.scale)
        total = rails if rails and abs(total) < WEAK else total
        # in the chosen axes
        sense = -1.0 if total < 0.0 else 1.0
        below, above = planes if sense > 0.0 else planes[::-1]
        words = (
            f"up is not sure: taken so, pins are {1e3 * sense * pins:.3g} mm above the COM, and level planes "
            f"of {below:.3g} m2 look down, of {above:.3g} m2 up"
        )
        if rails:
            words += f"; two equal bands such as rails look {'up' if rails * sense > 0.0 else 'down'}"
        asked.append(Question("--flip-up", words))
    if (total < 0.0) != choices.flip_up:
        return replace(axes, rows=axes.rows * np.array([[1.0], [-1.0], [-1.0]])), asked
    return axes, asked


def rails_up(local: Triangles, pitch: float) -> float:
    """Return 1 if two rails are the highest part of a shoe and none the lowest, -1 for the opposite."""
    found = []
    for sign in (1.0, -1.0):
        parts = level_parts(local, sign)
        least = RAIL * max((float(local.areas[part].sum()) for part in parts), default=0.0)
        large = [part for part in parts if local.areas[part].sum() > least]
        found.append(bool(large) and two_rails(local, large, pitch, sign)[0] is not None)
    return float(found[0]) - float(found[1])


def _outer_plane(local: Triangles, sign: float) -> float:
    """Return the greatest area at one height, near the outline, of faces that face up or down."""
    low = local.points[:, 2].min()
    high = local.points[:, 2].max()
    height = high - low
    depth = (high - local.middles[:, 2]) if sign > 0.0 else (local.middles[:, 2] - low)
    chosen = (sign * local.normals[:, 2] > np.cos(LEVEL)) & (depth < OUTER * height)
    levels = np.round(depth[chosen] / (0.01 * height)).astype(int)
    return float(np.bincount(levels, local.areas[chosen]).max()) if len(levels) else 0.0


def _levelled(triangles: Triangles, axes: ShoeAxes) -> ShoeAxes:
    """Return the axes after a small turn that makes the largest plane of the lower side level.

    Both pins of a level shoe have one height; the plane therefore gives z better than coarse bores.
    """
    local = triangles.moved(np.zeros(3), axes.rows, 1.0)
    down = local.normals[:, 2] < -np.cos(LEVEL)
    flat = local.labels((np.abs(local.bends) < SAME_PLANE) & down[local.pairs].all(axis=1))
    sizes = np.bincount(flat, np.where(down, local.areas, 0.0))
    members = (flat == int(np.argmax(sizes))) & down
    if not members.any():
        return axes
    normal = -(local.areas[members] @ local.normals[members])
    normal /= np.linalg.norm(normal)
    if np.arccos(min(normal[2], 1.0)) > ALIGNED:
        return axes
    z = normal @ axes.rows
    x = axes.rows[0] - z * (z @ axes.rows[0])
    x /= np.linalg.norm(x)
    return replace(axes, rows=np.array([x, np.cross(z, x), z]))
