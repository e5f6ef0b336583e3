"""Units of values, and the one that a value beyond what is plausible likely is in."""

import math

from pydantic.fields import FieldInfo

MISTAKEN: dict[str, dict[str, float]] = {
    "": {"per cent": 0.01},
    "m": {"mm": 1e-3, "inch": 0.0254},
    "m/s": {"km/h": 1.0 / 3.6, "mm/s": 1e-3},
    "m/s2": {"mm/s2": 1e-3},
    "rad/s": {"deg/s": math.pi / 180.0},
    "s": {"ms": 1e-3},
    "kg": {"t": 1e3, "g": 1e-3},
    "kg/m3": {"t/m3": 1e3, "t/mm3": 1e12},
    "N": {"kN": 1e3},
    "N/m": {"kN/m": 1e3, "MN/m": 1e6},
    "N s/m": {"kN s/m": 1e3},
    "Pa": {"MPa": 1e6, "GPa": 1e9, "kPa": 1e3},
    "Hz": {"kHz": 1e3},
}
"""Units that numbers come in by mistake, with their size in that of the case."""


def plausible_range(field: FieldInfo) -> tuple[float, float] | None:
    """Least and greatest plausible value of a field; None for one that has none."""
    match field.json_schema_extra:
        case {"plausible": [int() | float() as least, int() | float() as greatest]}:
            return least, greatest
    return None


def unit_of(field: FieldInfo) -> str:
    """Unit of a field after a number: with a space before it, or nothing."""
    extra = field.json_schema_extra
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    return "" if unit in ("", "1") else f" {unit}"


def likely_cause(value: float, field: FieldInfo) -> str:
    """Hint at the unit in which a value would be plausible; empty if there is none."""
    plausible = plausible_range(field)
    if plausible is None or not value:
        return ""
    own = unit_of(field).strip()
    for unit, size in MISTAKEN.get(own, {}).items():
        if plausible[0] <= value * size <= plausible[1]:
            return f"; is it in {unit}? It has to be {f'in {own}' if own else 'a fraction of 1'}"
    return ""
