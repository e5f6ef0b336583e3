"""Units as makers print them: kilograms of force in pulls and pressures, grades as angles."""

import math
import re
from typing import Annotated

from pydantic import BeforeValidator

from exudyn_crawler.settings.units import number_of

KILOGRAM = re.compile(r"\bkg\b")


def _with_kilograms_of(unit: str) -> BeforeValidator:
    """Let the kg of a text be those of force."""

    def number(value: object) -> object:
        force = number_of(KILOGRAM.sub("kgf", value), unit) if isinstance(value, str) else value
        return value if isinstance(force, str) else force

    return BeforeValidator(number)


def _slope(value: object) -> object:
    """Rise over run of a text with an angle; all else as it is."""
    angle = number_of(value, "rad")
    return math.tan(angle) if isinstance(value, str) and isinstance(angle, float) else value


Force = Annotated[float, _with_kilograms_of("N")]
"""N, or a text such as '20570 kg'."""
Pressure = Annotated[float, _with_kilograms_of("Pa")]
"""Pa, or a text such as '0.43 kg/cm2'."""
Slope = Annotated[float, BeforeValidator(_slope)]
"""Rise over run, or an angle as a text such as '35 deg'."""
