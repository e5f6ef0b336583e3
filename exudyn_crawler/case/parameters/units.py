"""Units in words: "20 MN/m" in a file is the number of the field's own unit; numbers in units for reading.

Within the program all is in SI units. A file may have a text with a number and a unit in place of a number,
which becomes one where the file's values become parameters. Angles are no plain numbers here: revolutions a
second are no hertz, and degrees no slope.
"""

import re
from fractions import Fraction
from functools import cache, partial
from typing import Any

from pydantic import BaseModel

from exudyn_crawler.case.parameters import fields

NUMBER, NAME = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", r"[a-zµ°%_]+(?:\^?-?\d(?:\.\d+)?)?"
UNIT = rf"(?:1/)?{NAME}(?:\s*[*/ ]\s*{NAME})*"
TEXT = re.compile(rf"\s*({NUMBER})(?:\s*(?=[a-zµ°%])|\s+(?=1/))({UNIT})\s*", re.IGNORECASE)
POWER = re.compile(r"(?<=[A-Za-zµ°])\^?(-?\d)")  # m3 and s2, as units are written here, too
OPEN_POWER = re.compile(r"\^\(?exponent(?:\+(\d)\))?")  # of a law's modulus, by its exponent
DEFINITIONS = """
centi- = 1/100 = c-
milli- = 1/1000 = m-
micro- = 1/1000000 = µ- = u-
kilo- = 1000 = k-
mega- = 1000000 = M-
giga- = 1000000000 = G-
metre = [length] = m
second = [time] = s
gram = [mass] = g
radian = [angle] = rad
percent = 1/100 = %
minute = 60 * second = min
hour = 3600 * second = h
day = 24 * hour = d
tonne = 1000000 * gram = t
degree = 0.017453292519943295 * radian = deg = °
revolution = 360 * degree = rev
rpm = revolution / minute
hertz = 1 / second = Hz
newton = 1000 * gram * metre / second ** 2 = N
pascal = newton / metre ** 2 = Pa
bar = 100000 * pascal
inch = 0.0254 * metre = in
foot = 12 * inch = ft
mile = 5280 * foot = mi
mph = mile / hour
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
"""
EXAMPLES = {"N": "450 kN", "N m": "30 kN m", "N/m": "20 MN/m", "N s/m": "120 kN s/m", "Pa": "800 MPa"}
EXAMPLES |= {"m": "8 mm", "m/s": "9 km/h", "rad/s": "1 deg/s", "kg": "4.7 t", "kg/m3": "1.6 t/m3"}
EXAMPLES |= {"s": "5 min", "": "3 %"}


@cache
def _registry() -> Any:
    # half a second, for files alone that have units
    import pint

    registry: Any = pint.UnitRegistry(None, non_int_type=Fraction)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


@cache
def _size(unit: str, own: str) -> Fraction:
    """Size of a unit in a field's own; ValueError if there is no such unit, or it is of something else."""
    there, here = (_registry().parse_units(POWER.sub(r"^\1", one)) for one in (unit, own))
    return Fraction((Fraction(1) * there).to(here).magnitude)


def number_of(value: object, unit: str) -> object:
    """Number in a field's unit of a text with a number and a unit, as exact as may be; all else as it is."""
    if isinstance(value, list | tuple):
        return [number_of(one, unit) for one in value]
    match = TEXT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    # what is wrong with a unit raises all kinds of errors
    try:
        return float(Fraction(match[1]) * _size(match[2], unit))
    except Exception:
        return value


def is_measured(value: object) -> bool:
    """Whether a value is a text with a number and a unit."""
    return isinstance(value, str) and TEXT.fullmatch(value) is not None


def wanted(unit: str) -> str:
    """What a field of a unit takes."""
    example = f", or such as {EXAMPLES[unit]!r}" if unit in EXAMPLES else ""
    return f"must be a number{f' in {unit}' if unit else ''}{example}"


def in_si(content: Any, *kinds: type[BaseModel], unit: str = "") -> Any:
    """Copy of the content of a table of one of some classes with numbers for texts that have units."""
    if not isinstance(content, dict):
        return content
    tag = content.get(fields.TAG)
    kind = next((one for one in kinds if len(kinds) > 1 and fields.tag_of(one) == tag), kinds[0])
    made, power = dict(content), content.get("exponent")
    power = power if fields.is_number(power) else 1.0
    for name, value in content.items():
        field = kind.model_fields.get(name)
        if field is None:
            continue
        parts, own = fields.models_of(field.annotation), fields.unit_of(field)
        own = OPEN_POWER.sub(lambda found: f"^{power + int(found[1] or 0)}", own)
        if getattr(kind, "is_value", False):
            made[name] = number_of(value, "s" if name == "times" else unit)
        elif parts:
            below = partial(in_si, unit=own)
            of_list = isinstance(value, list)
            made[name] = [below(one, *parts) for one in value] if of_list else below(value, *parts)
        elif isinstance(field.json_schema_extra, dict) and "unit" in field.json_schema_extra:
            made[name] = number_of(value, own)
    return made
