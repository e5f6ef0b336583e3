"""Texts with a number and a unit: "20 MN/m" in a case, and makers' spellings such as 8' 6".

Such a text becomes a number in the field's unit. Angles have a dimension here: revolutions per second are
not hertz, and degrees are not a slope.
"""

import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any

from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields

PARTING = "[ '\u00a0\u202f]"
"""Thousands separators that no country uses as a decimal mark."""
NUMBER = rf"[+-]?(?:\d{{1,3}}(?:{PARTING}\d{{3}})+(?:\.\d*)?|\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
NAME = r"[a-zµ°%_]+(?:\^?-?\d(?:\.\d+)?)?"
UNIT = rf"(?:1/)?{NAME}(?:\s*[*/ ]\s*{NAME})*"
TEXT = re.compile(rf"\s*({NUMBER})(?:\s*(?=[a-zµ°%])|\s+(?=1/))({UNIT})\s*", re.IGNORECASE)
POWER = re.compile(r"(?<=[A-Za-zµ°])\^?(-?\d)")  # with or without a caret: m^3, m3
OPEN_POWER = re.compile(r"\^\(?exponent(?:\+(\d)\))?")  # power in a modulus's unit, set by an exponent
DEFINITIONS = """
centi- = 1/100 = c-
milli- = 1/1000 = m-
micro- = 1/1000000 = µ- = u-
kilo- = 1000 = k-
mega- = 1000000 = M-
giga- = 1000000000 = G-
metre = [length] = m = meter
second = [time] = s = sec
gram = [mass] = g
radian = [angle] = rad
percent = 1/100 = %
minute = 60 * second = min
hour = 3600 * second = h = hr
day = 24 * hour = d
tonne = 1000000 * gram = t
degree = 0.017453292519943295 * radian = deg = °
revolution = 360 * degree = rev
rpm = revolution / minute
hertz = 1 / second = Hz
newton = 1000 * gram * metre / second ** 2 = N
newton_metre = newton * metre = Nm
pascal = newton / metre ** 2 = Pa
watt = newton * metre / second = W
horsepower = 745.6998715822702 * watt = hp
metric_horsepower = 735.49875 * watt = PS
kilogram_force = 9.80665 * newton = kgf
short_ton = 907184.74 * gram
long_ton = 1016046.9088 * gram
bar = 100000 * pascal
inch = 0.0254 * metre = in
foot = 12 * inch = ft = feet
mile = 5280 * foot = mi
mph = mile / hour
kph = 1000 * metre / hour = _ = kmh
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
kip = 1000 * pound_force
psi = pound_force / inch ** 2
"""
SIGNS = str.maketrans(
    dict(zip("\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079", "0123456789", strict=True))
    | dict.fromkeys("\u207b\u2212\u2013", "-")
    | dict.fromkeys("\u00b7\u22c5\u2022", "*")
    | dict.fromkeys("\u2019\u2032", "'")
    | dict.fromkeys("\u2033\u201c\u201d", '"')
    | {"\u03bc": "\u00b5"}
)
"""Typographic characters and their keyboard equivalents."""
TONS = {"short": "short_ton", "long": "long_ton", "metric": "t"}
TON = re.compile(rf"\b({'|'.join(TONS)}) tons?\b", re.IGNORECASE)
BARE_TON = re.compile(r"\btons?\b", re.IGNORECASE)
FOOT, INCH = r"(?:ft|feet|foot|')", r"(?:inch(?:es)?|in|''|\")"
NUMBER_OF_INCHES = r"(?P<inches>\d+(?:\.\d+)?)(?:[- ](?P<part>\d+)/(?P<whole>2|4|8|16|32|64))?"
FEET = re.compile(rf"\s*(?P<feet>\d+(?:\.\d+)?)\s*{FOOT}(?:\s*[- ]?\s*{NUMBER_OF_INCHES}\s*{INCH})?\s*")
INCHES = re.compile(rf"\s*{NUMBER_OF_INCHES}\s*{INCH}\s*")
"""Lengths in feet and inches, or in inches: 8' 6", 11 ft 6 in, 15'-8 1/2"."""
INCHES_OF_A_FOOT = 12
COMMA = re.compile(r"\s*([+-]?\d+),(\d+)([^,]*)")
POINTS = re.compile(r"\s*([+-]?\d{1,3}(?:\.\d{3})+),(\d+)(.*)")
COMMAS = re.compile(r"\s*([+-]?\d{1,3}(?:,\d{3}){2,})(.*)")
THOUSANDS = 3
"""Number of digits behind a comma that may separate thousands."""
OF_FORCE = {"kg": "kgf", "lb": "lbf", "lbs": "lbf"}
CASED = {
    name.lower(): name
    for name in ("kg", "t", "km", "h", "m", "mm", "cm", "s", "N", "kN", "kPa", "hp", "kW", "W", "PS")
}
"""Units by their names in lower case, without those that differ by case alone (mega and milli)."""


@cache
def _registry() -> Any:
    # the import takes half a second; only files with units need it
    import pint

    registry: Any = pint.UnitRegistry(None, non_int_type=Fraction)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


@cache
def is_unit(text: str) -> bool:
    """Return whether a text is a unit."""
    if not re.fullmatch(UNIT, text, re.IGNORECASE):
        return False
    # a wrong unit raises errors of many classes
    try:
        return bool(_registry().parse_units(POWER.sub(r"^\1", text)))
    except Exception:
        return False


@cache
def _size(unit: str, unit_here: str) -> Fraction:
    """Return the size of a unit in the field's unit; raises an error of pint for a wrong or other unit."""
    there, here = (_registry().parse_units(POWER.sub(r"^\1", text)) for text in (unit, unit_here))
    return Fraction((Fraction(1) * there).to(here).magnitude)


def number_of(value: object, unit: str) -> object:
    """Return the number, in the field's unit, of a text with a number and a unit; other values unchanged.

    The conversion is exact up to one rounding. Raises `ParameterError` for a list with units on some of its
    numbers only.
    """
    if isinstance(value, list | tuple):
        refuse_mixed(value, unit)
        return [number_of(element, unit) for element in value]
    if not isinstance(value, str):
        return value
    match = TEXT.fullmatch(_typed(value))
    if match is None:
        return value
    # a wrong unit raises errors of many classes
    try:
        return float(Fraction(re.sub(PARTING, "", match[1])) * _size(match[2], unit))
    except Exception:
        return value


def _typed(text: str) -> str:
    """Return a text with keyboard characters, feet and inches as inches, and tons by their unit names."""
    plain = text.translate(SIGNS)
    if (match := FEET.fullmatch(plain) or INCHES.fullmatch(plain)) is None:
        return TON.sub(lambda found: TONS[found[1].lower()], plain)
    parts = match.groupdict()
    inches = Fraction(parts["inches"] or 0) + Fraction(int(parts["part"] or 0), int(parts["whole"] or 1))
    if "feet" in parts:
        if inches >= INCHES_OF_A_FOOT or "000" in plain:  # the apostrophe separates thousands
            return plain
        inches += INCHES_OF_A_FOOT * Fraction(parts["feet"])
    # binary fractions of an inch have finite decimals
    return f"{Decimal(inches.numerator) / Decimal(inches.denominator)} inch"


def refuse_mixed(values: Sequence[object], unit: str, names: Sequence[str] = ()) -> None:
    """Raise `ParameterError` for a number without a unit beside texts with one; zero needs none.

    `names` holds the names of the values, if they have any.
    """
    texts = [value for value in values if isinstance(value, str) and fields.is_number(number_of(value, unit))]
    if not texts:
        return
    match = TEXT.fullmatch(_typed(texts[0]))
    assert match is not None  # it is a number
    for place, value in enumerate(values):
        if fields.is_number(value) and value != 0:
            name = f"{names[place]} = " if names else ""
            meant = " or ".join(f"'{value:g} {one}'" for one in dict.fromkeys((match[2], unit)) if one)
            raise ParameterError(f"{name}{value:g} must have a unit as {texts[0]!r} has, such as {meant}")


def hint(text: str, unit: str) -> str:
    """Describe the likely meaning of a text that is not a number with a unit; empty if none is likely."""
    plain = text.translate(SIGNS)
    if re.fullmatch(rf"\s*{NUMBER}\s*", plain, re.IGNORECASE):
        of_unit = f"{text.strip()} {unit}".rstrip()
        return (
            f"; without quotes it is {of_unit}, within them it needs a unit"
            if unit
            else "; it stands without quotes"
        )
    if BARE_TON.search(plain) and fields.is_number(number_of(BARE_TON.sub("t", plain), unit)):
        return "; a ton is 't' (1000 kg), 'short_ton' (907.2 kg) or 'long_ton' (1016 kg)"
    likely = [meant for meant in candidate_texts(plain) if fields.is_number(number_of(meant, unit))]
    if likely:
        return f"; did you mean {likely[0]!r}?"
    return _comma(plain)


def candidate_texts(text: str) -> Iterator[str]:
    """Yield the text with likely units: force for mass, the right letter case, and both."""
    for names in (OF_FORCE, CASED, {name.lower(): OF_FORCE.get(unit, unit) for name, unit in CASED.items()}):
        words = re.split(r"([A-Za-z]+)", text)
        yield "".join(names.get(word if names is OF_FORCE else word.lower(), word) for word in words)


def _comma(text: str) -> str:
    """Describe the right spelling of a number with commas; empty if it has none."""
    if match := COMMAS.fullmatch(text):
        return f"; numbers have no commas: '{match[1].replace(',', '')}{match[2]}'"
    if match := POINTS.fullmatch(text):
        return f"; numbers have a point: '{match[1].replace('.', '')}.{match[2]}{match[3]}'"
    if match := COMMA.fullmatch(text):
        point = f"'{match[1]}.{match[2]}{match[3]}'"
        if len(match[2]) == THOUSANDS:
            return f"; numbers have no commas: '{match[1]}{match[2]}{match[3]}', or {point}"
        return f"; numbers have a point: {point}"
    return ""
