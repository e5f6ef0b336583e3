"""Running gear of vehicles for datasheets without one: sprocket and idler beyond the road wheels."""

import math
from typing import NamedTuple

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import assembly
from exudyn_crawler.machines.datasheet import rules
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.origins import Ruled

ROAD_WHEELS = "road wheels"
"""Name of the rules of a vehicle's running gear."""
WIDEST = 1.6
"""Greatest distances from the outer road wheels to sprocket and idler, over the typical ones."""
SIZES = 1.0, 0.95, 0.9, 0.85, 0.8
"""Tried diameters of road wheels over the typical one, for datasheets without a printed one."""
CLEAR = 0.95
"""Greatest diameter of road wheels over their spacing, for datasheets without a printed one."""
PLAY = 0.1
"""Least clearance between neighbouring wheels, pitches."""


class RoadWheels(NamedTuple):
    """Running gear of a vehicle, m."""

    pitch: float
    on_ground: float
    wheel: float  # radius of the road wheels' treads
    sprocket: float  # radius of the pins' circle
    idler: float  # radius of its treads
    axes: float  # height of the road wheels' axes above ground
    above: tuple[float, float]  # heights of the axes of sprocket and idler above ground
    ways: tuple[float, float]  # typical distances from the outer road wheels to both
    rise: float  # height of the rails above the pins

    @property
    def heights(self) -> tuple[float, float]:
        """Heights of the axes of sprocket and idler above those of the road wheels."""
        return self.above[0] - self.axes, self.above[1] - self.axes

    def distances(self, share: float) -> tuple[float, float]:
        """Return the distances from outer road wheels to sprocket and idler: a typical share, or clear."""
        play = PLAY * self.pitch
        first, last = (share * way for way in self.ways)
        return (
            max(first, rules.clear_of(self.sprocket, self.wheel, self.heights[0], play)),
            max(last, rules.clear_of(self.idler, self.wheel, self.heights[1], play)),
        )

    def belt(self, share: float) -> list[assembly.Piece]:
        """Return the path of the pins with sprocket and idler at a share of the typical distances."""
        first, last = self.distances(share)
        under = self.wheel + self.rise
        around = math.hypot(self.idler + self.rise, 0.5 * self.pitch)
        return assembly.belt(
            [
                (-first, self.heights[0], self.sprocket),
                (0.0, 0.0, under),
                (self.on_ground, 0.0, under),
                (self.on_ground + last, self.heights[1], around),
            ]
        )

    def shoes(self, share: float) -> int:
        """Return the number of shoes of a chain on this path."""
        return round(sum(piece.length for piece in self.belt(share)) / self.pitch)


def with_running_gear(sheet: Datasheet) -> tuple[Datasheet, dict[str, Ruled]]:
    """Return a vehicle's datasheet completed by its missing running gear, and the rules of that.

    The distances of sprocket and idler from the outer road wheels close the chain. If no distance closes it,
    a `DatasheetError` gives the possible numbers of shoes. A datasheet stays unchanged if it gives sprocket
    and idler, or if its machine has no road wheels on arms.
    """
    if not sheet.has_road_wheels or sheet.sprocket_to_idler is not None:
        return sheet, {}
    span = _on_ground(sheet)
    if span is None:
        return sheet, {}
    on_ground: float = span.value
    of_chain = _pitch(sheet, on_ground)
    pitch: float = of_chain.value
    wheels = sheet.lower_rollers
    if wheels is None:
        wheels = 1 + max(1, round(on_ground / (pitch * sheet.typical_value("wheel_spacing"))))
    gaps = sheet.sprocket_gaps or float(round(sheet.typical_value("sprocket_gaps")))
    filled = sheet.with_(length_on_ground=on_ground, pitch=pitch, lower_rollers=wheels, sprocket_gaps=gaps)
    if sheet.roller_diameter is not None:
        sizes = [sheet.roller_diameter]
    else:
        usual = min(pitch * sheet.typical_value("wheel_diameter"), CLEAR * on_ground / max(1, wheels - 1))
        sizes = [size * usual for size in SIZES]
    tried = [_running(sheet, pitch, on_ground, gaps, size) for size in sizes]
    shoes = sheet.shoes or tried[0].shoes(1.0)
    for diameter, running in zip(sizes, tried, strict=True):
        try:
            share = assembly.closed_chain(running.belt, pitch, shoes, (0.0, WIDEST), "")
        except assembly.MisfitError:
            continue
        whole = _filled(filled, running, share, diameter, shoes)
        ruled = {
            f"datasheet.{name}": Ruled(getattr(whole, name), ROAD_WHEELS)
            for name in type(whole).model_fields
            if getattr(whole, name) != getattr(sheet, name)
        }
        return whole, ruled | {"datasheet.length_on_ground": span, "datasheet.pitch": of_chain}
    least = tried[-1].shoes(0.0)
    most = tried[0].shoes(WIDEST)
    raise DatasheetError(
        f"{shoes} shoes of {1e3 * pitch:.4g} mm do not close about {wheels} road wheels on {on_ground:.3g} m "
        f"of ground with sprocket and idler beyond them: {least} to {most} do, or sprocket_to_idler says "
        "where these are"
    )


def _on_ground(sheet: Datasheet) -> Ruled | None:
    """Return the length between the outer road wheels, m: printed, from area, pressure or chain, or None."""
    if sheet.length_on_ground is not None:
        return Ruled(sheet.length_on_ground, "given")
    counted = sheet.counted_length(ph4100c.GRAVITY)
    if counted is not None:
        return counted._replace(rule=f"{counted.rule} of road wheels")
    if sheet.shoes is None or sheet.pitch is None:
        return None
    return Ruled(sheet.shoes * sheet.pitch / sheet.typical_value("loop"), ROAD_WHEELS)


def _pitch(sheet: Datasheet, on_ground: float) -> Ruled:
    """Return the pitch, m: printed, from the number of shoes, or from the vehicle's mass."""
    if sheet.pitch is not None:
        return Ruled(sheet.pitch, "given")
    if sheet.shoes is not None:
        return Ruled(on_ground * sheet.typical_value("loop") / sheet.shoes, ROAD_WHEELS)
    by_mass = rules.pitch_by_mass(sheet.operating_weight, sheet.typical_value("pitch_by_mass"))
    return Ruled(by_mass, "weight")


def _running(sheet: Datasheet, pitch: float, on_ground: float, gaps: float, diameter: float) -> RoadWheels:
    """Return the running gear for a diameter of road wheels, m; values not printed scale with it."""
    depth = sheet.typical_value("plate_depth")
    rise = pitch * (sheet.typical_value("plate_thickness") + sheet.typical_value("link_height") - depth)
    grouser = sheet.grouser_height
    if grouser is None:
        grouser = pitch * sheet.typical_value("grouser_height")

    def size(printed: float | None, name: str) -> float:
        return diameter * sheet.typical_value(name) if printed is None else printed

    return RoadWheels(
        pitch=pitch,
        on_ground=on_ground,
        wheel=0.5 * diameter,
        sprocket=0.5 * rules.pin_circle(pitch, gaps),
        idler=0.5 * size(sheet.idler_diameter, "idler_diameter"),
        axes=0.5 * diameter + rise + pitch * depth + grouser,
        above=(size(sheet.sprocket_height, "sprocket_axis"), size(sheet.idler_height, "idler_axis")),
        ways=(size(sheet.first_roller, "first_wheel"), size(None, "last_wheel")),
        rise=rise,
    )


def _filled(sheet: Datasheet, running: RoadWheels, share: float, diameter: float, shoes: int) -> Datasheet:
    """Return a datasheet with a running gear whose chain closes at a share of the typical distances."""
    first, last = running.distances(share)
    values = {
        "roller_diameter": diameter,
        "idler_diameter": 2.0 * running.idler,
        "sprocket_height": running.above[0],
        "idler_height": running.above[1],
        "first_roller": first,
        "sprocket_to_idler": first + running.on_ground + last,
    }
    return sheet.with_(shoes=shoes, **values)
