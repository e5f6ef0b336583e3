"""Units of makers: kilograms-force in pulls and pressures, grades as angles."""

import math
import re
from typing import Annotated

from pydantic import BeforeValidator

from exudyn_crawler.settings.units import number_of

KILOGRAM = re.compile(r"\bkg\b")


def _with_kilograms_of(unit: str) -> BeforeValidator:
    """Return a validator that reads the kg of a text as kgf."""

    def number(value: object) -> object:
        force = number_of(KILOGRAM.sub("kgf", value), unit) if isinstance(value, str) else value
        return value if isinstance(force, str) else force

    return BeforeValidator(number)


def _slope(value: object) -> object:
    """Return rise over run for a text with an angle; return any other value unchanged."""
    angle = number_of(value, "rad")
    return math.tan(angle) if isinstance(value, str) and isinstance(angle, float) else value


Force = Annotated[float, _with_kilograms_of("N")]
"""Force in N, or a text such as '20570 kg'."""
Pressure = Annotated[float, _with_kilograms_of("Pa")]
"""Pressure in Pa, or a text such as '0.43 kg/cm2'."""
Slope = Annotated[float, BeforeValidator(_slope)]
"""Rise over run, or an angle as a text such as '35 deg'."""
