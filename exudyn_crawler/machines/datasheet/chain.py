"""Chain of a datasheet: pitch, number of shoes, lengths and sprocket, given or derived from each other."""

import math
from typing import NamedTuple

from exudyn_crawler.case.parameters.track import MOST_SHOES
from exudyn_crawler.machines.datasheet import rules
from exudyn_crawler.machines.datasheet.sheet import (
    GREATEST_GAPS,
    LEAST_GAPS,
    Datasheet,
    DatasheetError,
    Kind,
)
from exudyn_crawler.origins import Ruled

LOOSE = 0.01  # tolerance of the lengths of a datasheet, fraction of the chain's length
PLAUSIBLE_GAPS = 8, 18  # range of sprocket gaps that supports a number of shoes, or a pitch by mass
CLOSING_CIRCLES = 0.8, 1.2
"""Range of the mean circle of sprocket and idler that may close a chain, over a printed sprocket's circle."""
LONGEST, SHORTEST = 60.0, 5.0  # range of the length on ground, pitches
HALF_PITCH: tuple[Kind, ...] = ("excavator", "dozer", "loader", "drill", "paver")
"""Kinds of machines with half-pitch sprockets: an odd number of teeth, every second gap in use."""


class Chain(NamedTuple):
    """Dimensions of one track, m."""

    pitch: float
    shoes: int
    on_ground: float  # from the sprocket's axis to the idler's
    diameter: float  # mean diameter of the pins' circles about sprocket and idler
    gaps: float  # shoes per turn of the maker's sprocket
    teeth: int  # number of teeth of the built sprocket
    gaps_per_shoe: int  # 2 for a half-pitch sprocket
    depth: float  # depth of the plate's underside below the pins
    grouser: float
    ruled: dict[str, Ruled]
    """Values with several possible rules, with the rule of each, by their paths."""

    @property
    def built_gaps(self) -> float:
        """Shoes moved by a whole turn of the built sprocket, such as 10.5."""
        return self.teeth / self.gaps_per_shoe

    @property
    def tips(self) -> float:
        """Depth of the grouser tips below the pins, m."""
        return self.depth + self.grouser

    @property
    def over_shoes(self) -> float:
        """Length over the shoes, m."""
        return self.on_ground + self.diameter + 2.0 * self.tips


def chain_of(sheet: Datasheet, gravity: float, depth: float | None = None) -> Chain:
    """Return the dimensions of a datasheet's chain; raise `DatasheetError` if they contradict each other.

    `depth` is that of the plate's underside below the pins (m), if a mesh gives it.
    """
    ruled = {"datasheet.pitch": _pitch(sheet, gravity)}
    pitch: float = ruled["datasheet.pitch"].value
    if depth is None:
        depth = pitch * sheet.typical_value("plate_depth")
    grouser = sheet.grouser_height
    if grouser is None:
        grouser = pitch * sheet.typical_value("grouser_height")
    tips = depth + grouser
    on_ground = sheet.sprocket_to_idler or sheet.length_on_ground
    over_shoes = sheet.crawler_length
    circle = _diameter(sheet, pitch, tips)
    diameter: float = circle.value
    if on_ground is None:
        ruled["datasheet.length_on_ground"] = _on_ground(sheet, pitch, diameter, tips, gravity)
        on_ground = float(ruled["datasheet.length_on_ground"].value)
    shoes = sheet.shoes or round(rules.loop_length(on_ground, diameter) / pitch)
    what = "length on ground" if sheet.sprocket_to_idler is None else "way from sprocket to idler"
    _check_lengths(on_ground, pitch, shoes, what)
    if sheet.sprocket_to_idler is None:
        _check_closing(sheet, pitch, shoes, on_ground, diameter)
    gaps = sheet.sprocket_gaps
    if gaps is None:
        gaps = rules.gaps_of(pitch, diameter)
    if not LEAST_GAPS - 0.5 < gaps < GREATEST_GAPS:
        length = f"{on_ground:.3g} m on the ground" + (
            f" and {over_shoes:.3g} m over the shoes" if over_shoes else ""
        )
        fits = f"{LEAST_GAPS:g} to {GREATEST_GAPS:g} gaps can be built"
        raise DatasheetError(
            f"{length} leave {_length(max(diameter, 0.0))} for the sprocket's circle of pins, which is "
            f"{gaps:.3g} shoes of {_length(pitch)}; {fits}: is the pitch right?"
        )
    halves = _half_teeth(sheet, gaps)
    gaps_per_shoe = 1 + halves % 2
    teeth = halves if gaps_per_shoe == 2 else halves // 2
    built = f"{gaps:.3g} shoes a turn, built with {0.5 * halves:g}"
    ruled |= {"chain.circle": circle, "datasheet.sprocket_gaps": circle._replace(value=gaps)}
    ruled["gear.tumbler.teeth"] = Ruled(teeth, "", built if abs(0.5 * halves - gaps) > 1e-9 else "")
    return Chain(pitch, shoes, on_ground, diameter, gaps, teeth, gaps_per_shoe, depth, grouser, ruled)


def _half_teeth(sheet: Datasheet, gaps: float) -> int:
    """Return twice the shoes per turn of the built sprocket, nearest to its gaps."""
    if sheet.sprocket_gaps is not None:
        return round(2.0 * gaps)
    if sheet.kind in HALF_PITCH:
        return max(2 * math.floor(gaps), 2 * int(LEAST_GAPS)) + 1
    return 2 * max(round(gaps), int(LEAST_GAPS))


def _length(value: float) -> str:
    return f"{1e3 * value:.4g} mm" if value < 1.0 else f"{value:.3g} m"


def _pitch(sheet: Datasheet, gravity: float) -> Ruled:
    """Return the pitch, m: given, from the closing of the loop, or from the machine's mass."""
    if sheet.pitch is not None:
        return Ruled(sheet.pitch, "given")
    closing = None if sheet.shoes is None else _closing_pitch(sheet, sheet.shoes, gravity)
    if closing is not None:
        return closing
    on_ground = sheet.length_on_ground
    over_shoes = sheet.crawler_length
    value = rules.pitch_by_mass(sheet.operating_weight, sheet.typical_value("pitch_by_mass"))
    if on_ground is not None and over_shoes is not None:
        depth, grouser = _tips(sheet)
        left = over_shoes - on_ground - 2.0 * (depth * value + grouser)
        least, greatest = (rules.pin_circle(value, gaps) for gaps in PLAUSIBLE_GAPS)
        if not least <= left <= greatest:
            of_ends = rules.pitch_of_ends(over_shoes - on_ground, _gaps(sheet), depth, grouser)
            return Ruled(of_ends, "ends")
    return Ruled(value, "weight")


def _closing_pitch(sheet: Datasheet, shoes: int, gravity: float) -> Ruled | None:
    """Return the pitch (m) at which this number of shoes closes about the lengths; None without a length."""
    ground = sheet.length_on_ground
    crawler = sheet.crawler_length
    depth, grouser = _tips(sheet)
    gaps = _gaps(sheet)

    def beyond(pitch: float) -> float:
        """Return twice the depth of the grouser tips below the pins, m."""
        return 2.0 * (depth * pitch + grouser)

    def circle(pitch: float) -> float:
        return rules.pin_circle(pitch, gaps)

    if ground is not None and crawler is not None:
        pitch = rules.closing_pitch(shoes, lambda p: (ground, crawler - ground - beyond(p)))
        if pitch > 0.0:
            return Ruled(pitch, "lengths")
    if ground is not None:
        return Ruled(rules.closing_pitch(shoes, lambda p: (ground, circle(p))), "length on ground")
    if crawler is not None:
        pitch = rules.closing_pitch(shoes, lambda p: (crawler - circle(p) - beyond(p), circle(p)))
        return Ruled(pitch, "crawler length")
    counted = sheet.counted_length(gravity)
    if counted is None:
        return None
    counts: float = counted.value
    share = sheet.typical_value("pressure_share")
    pitch = rules.closing_pitch(shoes, lambda p: (counts - share * (circle(p) + beyond(p)), circle(p)))
    return counted._replace(value=pitch)


def _tips(sheet: Datasheet) -> tuple[float, float]:
    """Return the depth of grouser tips below the pins: a depth in pitches, and a printed height, m."""
    depth = sheet.typical_value("plate_depth")
    if sheet.grouser_height is not None:
        return depth, sheet.grouser_height
    return depth + sheet.typical_value("grouser_height"), 0.0


def _gaps(sheet: Datasheet) -> float:
    """Return the gaps of the sprocket: printed, or typical."""
    return sheet.sprocket_gaps or sheet.typical_value("sprocket_gaps")


def _diameter(sheet: Datasheet, pitch: float, tips: float) -> Ruled:
    """Return the mean diameter of the pins' circles about sprocket and idler, m."""
    on_ground = sheet.length_on_ground
    over_shoes = sheet.crawler_length
    shoes = sheet.shoes
    usual = Ruled(rules.pin_circle(pitch, _gaps(sheet)), "typical")
    if sheet.sprocket_to_idler is not None:
        return usual
    if on_ground is not None and over_shoes is not None:
        return Ruled(over_shoes - on_ground - 2.0 * tips, "lengths")
    if shoes is not None and on_ground is not None:
        left = Ruled((shoes * pitch - 2.0 * on_ground) / math.pi, "length on ground")
    elif shoes is not None and over_shoes is not None:
        of_loop = (shoes * pitch - 2.0 * (over_shoes - 2.0 * tips)) / (math.pi - 2.0)
        left = Ruled(of_loop, "crawler length")
    else:
        return usual
    if sheet.sprocket_gaps is not None:
        bounds = CLOSING_CIRCLES[0] * usual.value, CLOSING_CIRCLES[1] * usual.value
    else:
        bounds = rules.pin_circle(pitch, PLAUSIBLE_GAPS[0]), rules.pin_circle(pitch, PLAUSIBLE_GAPS[1])
    return left if bounds[0] <= left.value <= bounds[1] else usual


def _on_ground(sheet: Datasheet, pitch: float, diameter: float, tips: float, gravity: float) -> Ruled:
    """Return the length on ground, m, for a datasheet without one."""
    over_shoes = sheet.crawler_length
    shoes = sheet.shoes
    counted = sheet.counted_length(gravity)
    if over_shoes is not None:
        return Ruled(over_shoes - diameter - 2.0 * tips, "crawler length")
    if shoes is not None:
        return Ruled(0.5 * (shoes * pitch - math.pi * diameter), "chain")
    assert counted is not None
    share = sheet.typical_value("pressure_share")
    return counted._replace(value=counted.value - share * (diameter + 2.0 * tips))


def _check_lengths(on_ground: float, pitch: float, shoes: int, what: str) -> None:
    """Raise `DatasheetError` for lengths that no track of this pitch has."""
    if on_ground <= 0.0:
        raise DatasheetError(
            f"no {what} is left: shoes of {_length(pitch)} about sprocket and idler take "
            f"{_length(-on_ground)} more than weight, width, pressure and lengths give"
        )
    if not SHORTEST * pitch <= on_ground <= LONGEST * pitch:
        least, most = (_length(on_ground / bound) for bound in (LONGEST, SHORTEST))
        raise DatasheetError(
            f"a {what} of {on_ground:.3g} m is {on_ground / pitch:.3g} shoes of {_length(pitch)}; "
            f"{SHORTEST:g} to {LONGEST:g} can be built, with a pitch of {least} to {most}"
        )
    if not 10 <= shoes <= MOST_SHOES // 2:
        raise DatasheetError(f"a track of {shoes} shoes cannot be built; 10 to {MOST_SHOES // 2} can")


def _check_closing(sheet: Datasheet, pitch: float, shoes: int, on_ground: float, diameter: float) -> None:
    """Raise `DatasheetError` for a number of shoes that does not close about the lengths."""
    loop = rules.loop_length(on_ground, diameter)
    missing = loop - shoes * pitch
    if abs(missing) <= max(LOOSE * loop, 0.5 * pitch):
        return
    fit = round(loop / pitch)
    other = loop / shoes
    how = "short" if missing > 0.0 else "long"
    length = f"a length on ground of {on_ground:.3g} m"
    if sheet.length_on_ground is None and sheet.crawler_length is not None:
        length = f"a crawler of {sheet.crawler_length:.3g} m"
    if sheet.crawler_length is not None and sheet.length_on_ground is not None:
        length += f" and {sheet.crawler_length:.3g} m over the shoes"
    raise DatasheetError(
        f"{shoes} shoes of {_length(pitch)} are {abs(missing):.2g} m too {how} for {length}; "
        f"{fit} fit, or a pitch of {_length(other)}"
    )
