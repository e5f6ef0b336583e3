"""Chain of a datasheet: pitch, number of shoes, lengths, sprocket, each given or derived from the others."""

import math
from typing import NamedTuple

from exudyn_crawler.case.datasheet import rules
from exudyn_crawler.case.datasheet.notes import Notes
from exudyn_crawler.case.datasheet.sheet import GREATEST_GAPS, LEAST_GAPS, Datasheet, DatasheetError, Kind
from exudyn_crawler.case.parameters.track import MOST_SHOES

SHOES = "track.shoe_count of one track"
"""Key of a note."""
LOOSE = 0.01  # of a chain's length, by which lengths of a datasheet may disagree
PLAUSIBLE_GAPS = 8, 18  # of sprockets for which a number of shoes, or a pitch by mass, is taken
IDLER_SIZES = 0.8, 1.2
"""Times a printed sprocket's circle: mean of sprocket and idler with which it closes a chain."""
LONGEST, SHORTEST = 60.0, 5.0  # pitches of a length on ground
HALF_PITCH: tuple[Kind, ...] = ("excavator", "dozer", "loader", "drill", "paver")
"""Kinds of machines whose sprockets have an odd number of teeth, of which a chain uses every second gap."""


class Chain(NamedTuple):
    """Dimensions of one track, m."""

    pitch: float
    shoes: int
    on_ground: float  # from the sprocket's axis to the idler's
    diameter: float  # of the pins' circle about sprocket and idler, their mean
    gaps: float  # of the sprocket, that its maker has
    teeth: int  # of the sprocket as it is built
    gaps_per_shoe: int  # 2 of a half-pitch sprocket
    depth: float  # of the plate's underside below the pins
    grouser: float

    @property
    def built_gaps(self) -> float:
        """Shoes that a whole turn of the sprocket moves as it is built, such as 10.5."""
        return self.teeth / self.gaps_per_shoe

    @property
    def tips(self) -> float:
        """Tips of the grousers below the pins, m."""
        return self.depth + self.grouser

    @property
    def over_shoes(self) -> float:
        """Length over the shoes, m."""
        return self.on_ground + self.diameter + 2.0 * self.tips


def chain_of(sheet: Datasheet, notes: Notes, gravity: float, depth: float | None = None) -> Chain:
    """Dimensions of a datasheet's chain; a DatasheetError where they contradict each other.

    `depth` is that of the plate's underside below the pins (m) where a mesh has it.
    """
    pitch = _pitch(sheet, notes, gravity)
    if depth is None:
        depth = pitch * notes.typical("plate_depth")
    grouser = sheet.grouser_height
    if grouser is None:
        grouser = pitch * notes.typical("grouser_height")
    tips = depth + grouser
    on_ground = sheet.sprocket_to_idler or sheet.length_on_ground
    over_shoes = sheet.crawler_length
    diameter = _diameter(sheet, notes, pitch, tips)
    if on_ground is None:
        on_ground = _on_ground(sheet, notes, pitch, diameter, tips, gravity)
    shoes = sheet.shoes
    if shoes is None:
        shoes = notes.note(
            SHOES,
            round(rules.loop_length(on_ground, diameter) / pitch),
            "",
            "derived",
            "length of the loop, 2 C + pi d, over the pitch",
        )
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
    teeth, gaps_per_shoe = _teeth(sheet, gaps, notes)
    return Chain(pitch, shoes, on_ground, diameter, gaps, teeth, gaps_per_shoe, depth, grouser)


def _teeth(sheet: Datasheet, gaps: float, notes: Notes) -> tuple[int, int]:
    """Teeth of the sprocket, and its gaps from pin to pin, nearest to shoes that a turn moves."""
    if sheet.sprocket_gaps is not None:
        halves = round(2.0 * gaps)
        how = f"{gaps:g} of the datasheet"
    elif sheet.kind in HALF_PITCH:
        halves = max(2 * math.floor(gaps), 2 * int(LEAST_GAPS)) + 1
        how = (
            "pins' circle p / sin(pi / z) of the length that loop and shoes leave, to the nearest odd number"
        )
    else:
        halves = 2 * max(round(gaps), int(LEAST_GAPS))
        how = "pins' circle p / sin(pi / z) of the length that loop and shoes leave"
    if abs(0.5 * halves - gaps) > 1e-9:
        how += f": {gaps:.3g} shoes a turn, built with {0.5 * halves:g}"
    gaps_per_shoe = 1 + halves % 2
    teeth = halves if gaps_per_shoe == 2 else halves // 2
    notes.note("gear.tumbler.teeth", teeth, "", "derived", how)
    notes.note(
        "gear.tumbler.gaps_per_shoe",
        gaps_per_shoe,
        "",
        "derived",
        "2 where half of the teeth is no whole number of shoes: a half-pitch sprocket",
    )
    return teeth, gaps_per_shoe


def _length(value: float) -> str:
    return f"{1e3 * value:.4g} mm" if value < 1.0 else f"{value:.3g} m"


def _pitch(sheet: Datasheet, notes: Notes, gravity: float) -> float:
    """Pitch, m: given, of the loop's closing, or by the machine's mass."""
    if sheet.pitch is not None:
        return sheet.pitch
    closing = None if sheet.shoes is None else _closing_pitch(sheet, sheet.shoes, notes, gravity)
    if closing is not None:
        return float(notes.note("track.pitch", closing[0], "m", "derived", closing[1]))
    on_ground = sheet.length_on_ground
    over_shoes = sheet.crawler_length
    value = rules.pitch_by_mass(sheet.operating_weight, notes.typical("pitch_by_mass"))
    how = "0.066 m (weight / t)^(1/3), within 15 % [remembered]"
    if on_ground is not None and over_shoes is not None:
        depth, grouser = _tips(sheet, notes)
        left = over_shoes - on_ground - 2.0 * (depth * value + grouser)
        least, greatest = (rules.pin_circle(value, gaps) for gaps in PLAUSIBLE_GAPS)
        if not least <= left <= greatest:
            value = rules.pitch_of_ends(over_shoes - on_ground, _gaps(sheet, notes), depth, grouser)
            how = "sprocket and idler of typical size fill what the crawler is longer than on ground"
    return float(notes.note("track.pitch", value, "m", "assumed", how))


def _closing_pitch(sheet: Datasheet, shoes: int, notes: Notes, gravity: float) -> tuple[float, str] | None:
    """Pitch (m) with which so many shoes close about the lengths, and its rule; None without a length."""
    on_ground = sheet.length_on_ground
    over_shoes = sheet.crawler_length
    depth, grouser = _tips(sheet, notes)
    if on_ground is not None and over_shoes is not None:
        pitch = rules.pitch_of_loop(on_ground, over_shoes, shoes, depth, grouser)
        if pitch > 0.0:
            how = "the chain of N shoes closes: (2 C + pi (L - C - 2 grouser)) / (N + 2 pi depth)"
            return pitch, how
    wheels = "the chain of N shoes closes about wheels of a sprocket's size"
    gaps = _gaps(sheet, notes)
    if on_ground is not None:
        return rules.pitch_of_gaps(on_ground, shoes, gaps), f"{wheels}: 2 C / (N - pi / sin(pi / z))"
    if over_shoes is not None:
        pitch = rules.pitch_of_crawler(over_shoes, shoes, gaps, depth, grouser)
        return pitch, f"{wheels}: 2 (L - 2 grouser) / (N + 4 depth - (pi - 2) / sin(pi / z))"
    counted = sheet.counted_length(gravity)
    if counted is not None:
        whole, how = counted
        share = notes.typical("pressure_share")
        return rules.pitch_of_whole(whole, shoes, gaps, (depth, grouser), share), f"{wheels}, on the {how}"
    return None


def _tips(sheet: Datasheet, notes: Notes) -> tuple[float, float]:
    """Tips of the grousers below the pins: a depth in pitches, and a printed height beside it, m."""
    depth = notes.typical("plate_depth")
    if sheet.grouser_height is not None:
        return depth, sheet.grouser_height
    return depth + notes.typical("grouser_height"), 0.0


def _gaps(sheet: Datasheet, notes: Notes) -> float:
    """Gaps of the sprocket: printed, or typical."""
    return sheet.sprocket_gaps or notes.typical("sprocket_gaps")


def _diameter(sheet: Datasheet, notes: Notes, pitch: float, tips: float) -> float:
    """Mean diameter of the pins' circles about sprocket and idler, m."""
    on_ground = sheet.length_on_ground
    over_shoes = sheet.crawler_length
    shoes = sheet.shoes
    usual = rules.pin_circle(pitch, _gaps(sheet, notes))
    if sheet.sprocket_to_idler is not None:
        return usual
    if on_ground is not None and over_shoes is not None:
        return over_shoes - on_ground - 2.0 * tips
    left = None
    if shoes is not None and on_ground is not None:
        left = (shoes * pitch - 2.0 * on_ground) / math.pi
    elif shoes is not None and over_shoes is not None:
        left = (shoes * pitch - 2.0 * (over_shoes - 2.0 * tips)) / (math.pi - 2.0)
    if left is None:
        return usual
    if sheet.sprocket_gaps is not None:
        bounds = IDLER_SIZES[0] * usual, IDLER_SIZES[1] * usual
    else:
        bounds = rules.pin_circle(pitch, PLAUSIBLE_GAPS[0]), rules.pin_circle(pitch, PLAUSIBLE_GAPS[1])
    return left if bounds[0] <= left <= bounds[1] else usual


def _on_ground(
    sheet: Datasheet, notes: Notes, pitch: float, diameter: float, tips: float, gravity: float
) -> float:
    """Length on ground, m, where the datasheet has none."""
    over_shoes = sheet.crawler_length
    shoes = sheet.shoes
    counted = sheet.counted_length(gravity)
    if over_shoes is not None:
        how = "length over the shoes less circle and shoes: L - d - 2 e"
        value = over_shoes - diameter - 2.0 * tips
    elif shoes is not None:
        how = "what the chain leaves: (N p - pi d) / 2"
        value = 0.5 * (shoes * pitch - math.pi * diameter)
    else:
        assert counted is not None
        whole, how = counted
        share = notes.typical("pressure_share")
        how += ", less what counts of the ends"
        value = whole - share * (diameter + 2.0 * tips)
    return float(notes.note("length on ground", value, "m", "derived", how))


def _check_lengths(on_ground: float, pitch: float, shoes: int, what: str) -> None:
    """Refuse lengths that no track of this pitch has."""
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
    """Refuse a number of shoes that does not close about the lengths."""
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
