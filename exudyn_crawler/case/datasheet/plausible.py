"""Ranges of figures that machines of a kind and a weight have, printed or following: `plausible.csv`."""

import csv
import math
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from exudyn_crawler.case.datasheet import rules, typical
from exudyn_crawler.case.datasheet.chain import Chain
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.ph4100c import GRAVITY

TABLE = Path(__file__).with_name("plausible.csv")
WEIGHT = "operating_weight"
HALF = "{half}"
VOWELS = "aeiou"


class Following(NamedTuple):
    """Figures that follow from a datasheet where it does not print them, in SI units."""

    pitch: float
    shoes: int
    length_on_ground: float
    sprocket_gaps: float
    ground_pressure: float
    travel_speed: float | None  # of motors and gears
    shoe_weight: float | None = None


class Plausible(NamedTuple):
    """Row of the table: least and greatest figure of a kind of machine."""

    name: str  # key of the datasheet
    of: str  # kind of machine; empty: of those that have no row
    low: float
    high: float
    by: str  # what it is measured by, of `SIZES`; empty: SI units
    typical: str  # typical value that is usual; empty for none
    question: str  # what to ask where the figure is greater; {half} of a count has to be plausible
    source: str
    known: str  # seen in a source's text, remembered, of the project, or chosen here


def following(sheet: Datasheet, chain: Chain, shoe_weight: float | None = None) -> Following:
    """Return what follows from a datasheet with its chain and the mass of a shoe (kg), if that is known."""
    on_ground = sheet.length_on_ground or chain.on_ground
    share = typical.row_of("pressure_share", sheet.kind).value
    counted = rules.ground_length(on_ground, on_ground + chain.over_shoes - chain.on_ground, share)
    speed = None
    if sheet.motor_speed is not None and sheet.gear_ratio is not None:
        speed = sheet.motor_speed / sheet.gear_ratio * chain.built_gaps * chain.pitch / (2.0 * math.pi)
    return Following(
        chain.pitch,
        chain.shoes,
        on_ground,
        chain.gaps,
        rules.ground_pressure(sheet.operating_weight, sheet.shoe_width, counted, GRAVITY),
        speed,
        shoe_weight,
    )


SIZES: dict[str, Callable[[Datasheet, Following | None], float | None]] = {
    "": lambda _sheet, _following: 1.0,
    "root": lambda sheet, _following: (1e-3 * sheet.operating_weight) ** (1.0 / 3.0),
    "mass": lambda sheet, _following: sheet.operating_weight,
    "weight": lambda sheet, _following: sheet.operating_weight * GRAVITY,
    "pitch": lambda sheet, following: sheet.pitch or (following and following.pitch),
    "length": lambda sheet, following: sheet.length_on_ground or (following and following.length_on_ground),
    "wheel": lambda sheet, _following: sheet.roller_diameter,
}
"""Sizes that measure figures: third root of the tonnes, kg, N; pitch, length on ground and wheel, m."""


@cache
def table() -> dict[tuple[str, str], Plausible]:
    """Return all rows by name and kind of machine."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [_row(texts) for texts in csv.DictReader(file)]
    return {(row.name, row.of): row for row in rows}


def _row(texts: dict[str, Any]) -> Plausible:
    """Return a row of its texts by column."""
    return Plausible(**(texts | {name: float(texts[name]) for name in ("low", "high")}))


def row_of(name: str, kind: str) -> Plausible | None:
    """Return the row of a kind of machine, else that of all machines; None if there is none."""
    rows = table()
    return rows.get((name, kind)) or rows.get((name, ""))


def odd_printed(sheet: Datasheet, following: Following | None = None) -> Iterator[tuple[str, str]]:
    """Yield key and line of each printed figure that no machine of the kind and the weight has.

    Figures measured by sizes that follow are left out where nothing is known to follow.
    """
    for entry in fields.walk(sheet):
        key = ".".join(fields.names_of(entry.place))
        numbers = entry.value if isinstance(entry.value, tuple) else (entry.value,)
        row = row_of(key, sheet.kind)
        if row is None:
            continue
        lines = (
            _line(row, float(value), fields.unit_of(entry.field), sheet, following)
            for value in numbers
            if fields.is_number(value)
        )
        if (line := next(filter(None, lines), None)) is not None:
            yield entry.path, line
            # all else is measured by a weight that is wrong
            if key == WEIGHT:
                return
    if sheet.gauge is None:
        row = row_of("gauge", sheet.kind)
        if row is not None and (line := _line(row, sheet.track_gauge, "m", sheet, following)):
            yield "width_over_shoes", f"less shoe_width gives a gauge of {line}"


def odd_following(sheet: Datasheet, following: Following) -> Iterator[str]:
    """Yield a line for each figure that follows and that no machine of the kind and the weight has."""
    weight = row_of(WEIGHT, sheet.kind)
    if weight is not None and not weight.low <= sheet.operating_weight <= weight.high:
        return
    for name, value in following._asdict().items():
        row = row_of(name, sheet.kind)
        if row is None or value is None or getattr(sheet, name) is not None:
            continue
        unit = fields.unit_of(Datasheet.model_fields[name])
        if line := _line(row, float(value), unit, sheet, following, is_printed=False):
            yield f"{name} that follows: {line}"


def _line(
    row: Plausible,
    value: float,
    unit: str,
    sheet: Datasheet,
    following: Following | None,
    is_printed: bool = True,
) -> str:
    """Return a figure with the range that it is outside of, and what could be meant; empty within it."""
    size = SIZES[row.by](sheet, following)
    if size is None:
        return ""
    least, greatest = row.low * size, row.high * size
    if least <= value <= greatest:
        return ""
    article = "an" if sheet.kind[0] in VOWELS else "a"
    of = f" of {article} {sheet.kind}"
    if row.by:
        of += f" of {fields.quantity_text(sheet.operating_weight, 'kg')}"
    span = fields.span_text(least, greatest, unit)
    usual = ""
    if row.typical and not is_printed:
        usual_value = typical.row_of(row.typical, sheet.kind).value * size
        usual = f", {fields.quantity_text(usual_value, unit)} as a rule"
    line = f"{fields.quantity_text(value, unit)} is outside of {span}{of}{usual}"
    if not is_printed and (not row.question or HALF in row.question):
        return line
    return line + _cause(row, value, unit, (least, greatest))


def _cause(row: Plausible, value: float, unit: str, span: tuple[float, float]) -> str:
    """Say what could be meant by a printed figure outside of a span; empty where nothing is likely."""
    half = 0.5 * value
    is_sum = half == int(half) and span[0] <= half <= span[1]
    if row.question and value > span[1] and (HALF not in row.question or is_sum):
        return "; " + row.question.format(value=f"{value:g}", half=f"{half:g}")
    return fields.meant(value, unit, span)
