"""Wheels of a datasheet's side frame: sprocket and idler, lower rollers between them, carriers above.

Positions are in the axes of the side frame, from the middle between sprocket and idler at the height of the
rollers' axes. The size of the idler closes the chain at the datasheet's length.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters import assembly
from exudyn_crawler.case.parameters.closed_track import Wheel
from exudyn_crawler.machines.datasheet import rules
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.origins import Ruled

PLAY = 0.1  # least clearance between neighbouring wheels, pitches
LEAST_ROLLER = 0.3  # least radius of a roller in a dense row, pitches
IDLER_CIRCLES = 0.6, 1.5  # range of an idler's circle of pins over the sprocket's


class WheelPlaces(NamedTuple):
    """Wheels of one track, m."""

    sprocket: Wheel  # x and z of its axis
    pins: float  # radius of the pins' circle about it
    reach: float
    bush: float
    idler: Wheel
    idler_radius: float
    rollers: tuple[float, ...]
    roller_radius: float
    carriers: tuple[Wheel, ...]
    carrier_radius: float
    ruled: dict[str, Ruled]
    """Values with several possible rules, with the rule of each, by their paths."""


class Layout(NamedTuple):
    """Wheels within a closing chain, except the idler's circle of pins; m."""

    pitch: float
    on_ground: float
    rise: float  # height of the rails above the pins
    pins: float  # radius of the pins' circle on the sprocket
    root: float  # radius of the sprocket between its teeth
    lifts: tuple[float, float, float]  # lifts of sprocket, idler and carriers
    roller_radius: float
    rollers: int
    carrier_radius: float
    carriers: int
    heights: tuple[float | None, float | None] = (None, None)  # sprocket and idler above the rollers' axes
    ends: tuple[float, float] | None = None  # x of the outer rollers

    @property
    def low(self) -> float:
        """Height of the pins under the rollers."""
        return -(self.roller_radius + self.rise)

    @property
    def sprocket(self) -> Wheel:
        """Axis of the sprocket."""
        height = self.heights[0]
        return -0.5 * self.on_ground, self.low + self.lifts[0] + self.pins if height is None else height

    def idler(self, circle: float) -> Wheel:
        """Return the axis of an idler with a pins' circle of this radius."""
        height = self.heights[1]
        return 0.5 * self.on_ground, self.low + self.lifts[1] + circle if height is None else height

    def tread(self, circle: float) -> float:
        """Return the radius of the idler's treads, which rails touch between their pins."""
        return math.sqrt(circle**2 - 0.25 * self.pitch**2) - self.rise

    def roller_ends(self, circle: float) -> tuple[float, float]:
        """Return x of the first and the last roller: given, or clear of sprocket and idler."""
        if self.ends is not None:
            return self.ends
        (rear, height) = self.sprocket
        (front, other) = self.idler(circle)
        play = PLAY * self.pitch
        first = rear + rules.clear_of(self.root, self.roller_radius, height, play)
        return first, front - rules.clear_of(self.tread(circle), self.roller_radius, other, play)

    def roller_places(self, circle: float) -> tuple[float, ...]:
        """Return x of all rollers, evenly spaced."""
        return tuple(np.linspace(*self.roller_ends(circle), self.rollers).tolist())

    def carrier_places(self, circle: float) -> tuple[Wheel, ...]:
        """Return x and z of the carriers, evenly spaced and high enough to lift the upper run."""
        front = (*self.idler(circle), circle)
        angle = assembly.tangent_angle(front, (*self.sprocket, self.pins))
        half = 0.5 * self.on_ground
        places = np.linspace(-half, half, self.carriers + 2)[1:-1]
        # common tangent of both circles of pins
        above = front[0] * math.cos(angle) + front[1] * math.sin(angle) + circle
        line = (above - places * math.cos(angle)) / math.sin(angle)
        heights = line + self.lifts[2] - self.rise - self.carrier_radius
        return tuple(zip(places.tolist(), heights.tolist(), strict=True))

    def belt(self, circle: float) -> list[assembly.Piece]:
        """Return the path of the pins: sprocket, outer rollers, idler, outer carriers."""
        under = self.roller_radius + self.rise
        over = self.carrier_radius + self.rise
        lower = [(x, 0.0, under) for x in self.roller_ends(circle)]
        carriers = self.carrier_places(circle)
        ends = carriers[:: -max(1, len(carriers) - 1)]
        upper = [(x, z, over) for x, z in ends]
        return assembly.belt([(*self.sprocket, self.pins), *lower, (*self.idler(circle), circle), *upper])


def wheels_of(sheet: Datasheet, chain: Chain, rise: float) -> WheelPlaces:
    """Return wheels without overlap inside the chain; `rise` is that of the rails above the pins, m.

    Raise `DatasheetError` in the datasheet's terms if the wheels do not fit.
    """
    pitch = chain.pitch
    pins = 0.5 * rules.pin_circle(pitch, chain.built_gaps)
    bush = pitch * sheet.typical_value("bush_radius")
    reach = pitch * sheet.typical_value("tooth_reach")
    rear = -0.5 * chain.on_ground
    first = sheet.first_roller
    span = sheet.length_on_ground
    ends = None if first is None or span is None else (rear + first, rear + first + span)
    roller = _radius(sheet, "roller_diameter", pitch)
    axes = roller + rise + chain.tips
    layout = Layout(
        pitch=pitch,
        on_ground=chain.on_ground,
        rise=rise,
        pins=pins,
        root=pins - bush,
        lifts=(
            pitch * sheet.typical_value("sprocket_lift"),
            pitch * sheet.typical_value("idler_lift"),
            pitch * sheet.typical_value("carrier_lift"),
        ),
        roller_radius=roller,
        rollers=_roller_count(sheet, chain),
        carrier_radius=_radius(sheet, "carrier_diameter", pitch),
        carriers=_carrier_count(sheet, chain),
        heights=(_above(sheet.sprocket_height, axes), _above(sheet.idler_height, axes)),
        ends=ends,
    )
    if sheet.roller_diameter is None:
        layout = _with_rollers_that_fit(layout, chain)
    if sheet.idler_diameter is None:
        circle = _closing_circle(layout, chain)
    else:
        circle = math.hypot(0.5 * sheet.idler_diameter + rise, 0.5 * pitch)
    radius = layout.roller_radius
    return WheelPlaces(
        sprocket=layout.sprocket,
        pins=pins,
        reach=reach,
        bush=bush,
        idler=layout.idler(circle),
        idler_radius=layout.tread(circle),
        rollers=layout.roller_places(circle),
        roller_radius=radius,
        carriers=layout.carrier_places(circle),
        carrier_radius=layout.carrier_radius,
        ruled={"gear.roller_radius": Ruled(radius, "in a row" if radius < roller else "")},
    )


def _above(height: float | None, axes: float) -> float | None:
    """Return a height above the rollers' axes from one above the ground, m."""
    return None if height is None else height - axes


def _radius(sheet: Datasheet, name: str, pitch: float) -> float:
    """Return the radius of wheels: from their printed diameter, or typical."""
    diameter = getattr(sheet, name)
    return 0.5 * pitch * sheet.typical_value(name) if diameter is None else 0.5 * float(diameter)


def _roller_count(sheet: Datasheet, chain: Chain) -> int:
    """Return the number of lower rollers of one track: printed, or from their spacing."""
    if sheet.lower_rollers is not None:
        return sheet.lower_rollers
    spacing = chain.pitch * sheet.typical_value("roller_spacing")
    return max(2, 2 * sheet.bogies, round(chain.on_ground / spacing))


def _carrier_count(sheet: Datasheet, chain: Chain) -> int:
    """Return the number of carrier rollers of one track: printed, or from their spacing."""
    if sheet.carrier_rollers is not None:
        return sheet.carrier_rollers
    return round(chain.on_ground / (chain.pitch * sheet.typical_value("carrier_spacing")))


def _with_rollers_that_fit(layout: Layout, chain: Chain) -> Layout:
    """Return a layout with rollers side by side, smaller if there are many."""
    radius = layout.roller_radius
    least = LEAST_ROLLER * layout.pitch
    while True:
        tried = layout._replace(roller_radius=radius)
        first, last = tried.roller_ends(layout.pins)
        room = (last - first) / max(1, layout.rollers - 1) - PLAY * layout.pitch
        if 2.0 * radius <= room:
            break
        if radius <= least or room <= 0.0:
            fit = max(0, 1 + math.floor((last - first) / (2.0 * layout.roller_radius + PLAY * layout.pitch)))
            raise DatasheetError(
                f"{layout.rollers} lower rollers do not fit beside each other between sprocket and idler "
                f"on {chain.on_ground:.3g} m of ground: {fit} of {2e3 * layout.roller_radius:.0f} mm do"
            )
        radius = max(least, 0.97 * radius)
    return tried


def _closing_circle(layout: Layout, chain: Chain) -> float:
    """Return the radius of the pins' circle on the idler that closes the chain, m."""
    bounds = IDLER_CIRCLES[0] * layout.pins, IDLER_CIRCLES[1] * layout.pins
    try:
        return assembly.closed_chain(layout.belt, layout.pitch, chain.shoes, bounds, "an idler of")
    except assembly.WithinError as error:
        raise DatasheetError(f"the wheels of this datasheet do not stand in a loop: {error}") from error
    except assembly.MisfitError as error:
        raise DatasheetError(
            f"{chain.shoes} shoes of {1e3 * layout.pitch:.4g} mm do not close about a sprocket of "
            f"{chain.built_gaps:g} gaps and a length on ground of {chain.on_ground:.3g} m: {error}"
        ) from error
