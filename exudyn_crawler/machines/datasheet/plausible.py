"""Plausible ranges of printed and derived figures for kinds and weights of machines: `plausible.csv`."""

import math
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.machines.datasheet import rules, typical
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.rows import read_rows

TABLE = Path(__file__).with_name("plausible.csv")
WEIGHT = "operating_weight"
HALF = "{half}"
VOWELS = "aeiou"


class Following(NamedTuple):
    """Figures derived from a datasheet that does not print them, in SI units."""

    pitch: float
    shoes: int
    length_on_ground: float
    sprocket_gaps: float
    ground_pressure: float
    travel_speed: float | None  # from motors and gears
    shoe_weight: float | None = None


class Plausible(NamedTuple):
    """Row of the table: least and greatest figure of a kind of machine."""

    name: str  # key of the datasheet
    of: str  # kind of machine; empty: all kinds without a row
    low: float
    high: float
    by: str  # reference size, a key of `SIZES`; empty: SI units
    typical: str  # name of the typical value; empty for none
    question: str  # question for a greater figure; {half} of a count has to be plausible
    source: str
    known: str  # "seen" in a source's text, "remembered", of the "project", or "chosen" here


def following(sheet: Datasheet, chain: Chain, shoe_weight: float | None = None) -> Following:
    """Return the figures derived from a datasheet with its chain and a shoe's mass (kg), if known."""
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


class Sizes(NamedTuple):
    """Reference sizes of a machine for its figures; None if unknown."""

    mass: float  # kg
    pitch: float | None = None  # m
    length: float | None = None  # on ground, m
    wheel: float | None = None  # diameter of the road wheels, m


SIZES: dict[str, Callable[[Sizes], float | None]] = {
    "": lambda _sizes: 1.0,
    "root": lambda sizes: (1e-3 * sizes.mass) ** (1.0 / 3.0),
    "mass": lambda sizes: sizes.mass,
    "weight": lambda sizes: sizes.mass * GRAVITY,
    "pitch": lambda sizes: sizes.pitch,
    "length": lambda sizes: sizes.length,
    "wheel": lambda sizes: sizes.wheel,
}
"""Values of the column `by`: third root of the mass in tonnes, kg, N; pitch, length on ground and wheel,
m."""


def sizes_of(sheet: Datasheet, follows: Following | None = None) -> Sizes:
    """Return the sizes of a datasheet's machine, printed or, if known, derived."""
    pitch = sheet.pitch or (follows and follows.pitch)
    length = sheet.length_on_ground or (follows and follows.length_on_ground)
    return Sizes(sheet.operating_weight, pitch, length, sheet.roller_diameter)


@cache
def table() -> dict[tuple[str, str], Plausible]:
    """Return all rows by name and kind of machine."""
    return {(row.name, row.of): row for row in read_rows(TABLE, Plausible)}


def row_of(name: str, kind: str | None) -> Plausible | None:
    """Return the row of a kind of machine, else that of all machines; None without a row.

    Without a kind it is the widest range over all kinds.
    """
    rows = table()
    general = rows.get((name, ""))
    if kind is not None or general is None:
        return rows.get((name, kind or "")) or general
    same = [row for row in rows.values() if row.name == name and row.by == general.by]
    return general._replace(low=min(row.low for row in same), high=max(row.high for row in same), typical="")


def implausible_printed(sheet: Datasheet, follows: Following | None = None) -> Iterator[tuple[str, str]]:
    """Yield key and line of each printed figure implausible for the machine's kind and weight.

    Figures that need derived sizes are left out if no derived sizes are known.
    """
    sizes = sizes_of(sheet, follows)
    for entry in fields.walk(sheet):
        key = ".".join(fields.names_of(entry.place))
        line = implausible_number(key, entry.value, fields.unit_of(entry.field), sheet.kind, sizes)
        if line:
            yield entry.path, line
            # all other ranges depend on the wrong weight
            if key == WEIGHT:
                return
    if sheet.gauge is None and (
        line := implausible_number("gauge", sheet.track_gauge, "m", sheet.kind, sizes)
    ):
        yield "width_over_shoes", f"less shoe_width gives a gauge of {line}"


def implausible_derived(sheet: Datasheet, follows: Following) -> Iterator[str]:
    """Yield a line for each derived figure implausible for the machine's kind and weight."""
    sizes = sizes_of(sheet, follows)
    if implausible_number(WEIGHT, sheet.operating_weight, "kg", sheet.kind, sizes):
        return
    for name, value in follows._asdict().items():
        if getattr(sheet, name) is None:
            unit = fields.unit_of(Datasheet.model_fields[name])
            if line := implausible_number(name, value, unit, sheet.kind, sizes, is_printed=False):
                yield f"{name} that follows: {line}"


def implausible_number(
    name: str, value: object, unit: str, kind: str | None, sizes: Sizes, is_printed: bool = True
) -> str:
    """Return the first implausible number of a figure for a kind of machine, with its range; else empty."""
    row = row_of(name, kind)
    size = None if row is None else SIZES[row.by](sizes)
    if row is None or size is None:
        return ""
    span = row.low * size, row.high * size
    numbers = filter(fields.is_number, value if isinstance(value, tuple) else (value,))
    number = next((float(number) for number in numbers if not span[0] <= number <= span[1]), None)
    if number is None:
        return ""
    of = f" of {'an' if kind and kind[0] in VOWELS else 'a'} {kind or 'machine'}"
    if row.by:
        of += f" of {fields.quantity_text(sizes.mass, 'kg')}"
    usual = ""
    if row.typical and kind is not None and not is_printed:
        usual_value = typical.row_of(row.typical, kind).value * size
        usual = f", {fields.quantity_text(usual_value, unit)} as a rule"
    line = f"{fields.quantity_text(number, unit)} is outside of {fields.span_text(*span, unit)}{of}{usual}"
    if not is_printed and (not row.question or HALF in row.question):
        return line
    return line + _cause(row, number, unit, span)


def _cause(row: Plausible, value: float, unit: str, span: tuple[float, float]) -> str:
    """Return the likely meaning of a printed figure outside a range; empty without a likely one."""
    half = 0.5 * value
    is_sum = half == int(half) and span[0] <= half <= span[1]
    if row.question and value > span[1] and (HALF not in row.question or is_sum):
        return "; " + row.question.format(value=f"{value:g}", half=f"{half:g}")
    return fields.meant(value, unit, span)
