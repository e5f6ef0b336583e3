"""Unit of length named in the header of a STEP file."""

import re
from pathlib import Path
from typing import NamedTuple

from meshes.recognition.axes import UNITS

ASSIGNED = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
NUMBER = re.compile(rb"#\s*(\d+)")
INSTANCE = re.compile(rb"#\s*(\d+)\s*=\s*((?:'[^']*'|[^;'])*);")
LENGTH = re.compile(rb"\bLENGTH_UNIT\s*\(")
SI_METRE = re.compile(rb"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$|\*)\s*,\s*\.METRE\.\s*\)")
CONVERTED = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'([^']*)'\s*,\s*#\s*(\d+)\s*\)")
MEASURE = re.compile(rb"LENGTH_MEASURE_WITH_UNIT\s*\(\s*LENGTH_MEASURE\s*\(\s*([^)\s]+)\s*\)\s*,\s*#\s*(\d+)")
PREFIXES = {"": 1.0, "KILO": 1e3, "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9}
SAME = 1e-6
"""Relative difference below which two units are equal."""


class StepUnit(NamedTuple):
    """Unit of length of a STEP file.

    Attributes
    ----------
    name : str
        "mm", "inch" or the file's own name.
    metres : float
    """

    name: str
    metres: float

    def is_same(self, metres: float) -> bool:
        """Return True if the unit has this size in metres."""
        return abs(self.metres / metres - 1.0) < SAME


def units_of(path: Path) -> list[StepUnit]:
    """Return the different units of length of a STEP file's geometry; empty if the file names none."""
    content = path.read_bytes()
    assigned = {int(number) for group in ASSIGNED.findall(content) for number in NUMBER.findall(group)}
    if not assigned:
        return []
    # a file has few units among up to a million instances
    texts = {int(number): text for number, text in INSTANCE.findall(content) if b"UNIT" in text}
    found: list[StepUnit] = []
    for number in sorted(assigned):
        unit = _unit_of(texts, number)
        if unit is not None and not any(one.is_same(unit.metres) for one in found):
            found.append(unit)
    return found


def _unit_of(texts: dict[int, bytes], number: int, depth: int = 0) -> StepUnit | None:
    """Return the unit of an instance; None if it is no length or cannot be traced."""
    text = texts.get(number, b"")
    if depth > 4 or not LENGTH.search(text):
        return None
    if prefixed := SI_METRE.search(text):
        prefix = (prefixed[1] or b"").decode()
        return _named(prefix.lower() + "metre", PREFIXES[prefix]) if prefix in PREFIXES else None
    converted = CONVERTED.search(text)
    measure = MEASURE.search(texts.get(int(converted[2]), b"")) if converted else None
    if converted is None or measure is None:
        return None
    of_measure = _unit_of(texts, int(measure[2]), depth + 1)
    try:
        metres = float(measure[1]) * (of_measure.metres if of_measure else 0.0)
    except ValueError:
        return None
    return _named(converted[1].decode(errors="replace").lower(), metres) if metres > 0.0 else None


def _named(name: str, metres: float) -> StepUnit:
    """Return a unit under its usual name, if it has one."""
    unit = StepUnit(name, metres)
    return next((StepUnit(usual, size) for usual, size in UNITS.items() if unit.is_same(size)), unit)
