"""Contacts with the IMPACT law: slopes and energy of the law, and flanges that guide sideways."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.laws import Impact, impact_force, step

FLANGE_DEPTH = 1e-3
"""Depth (m) in a flange at which all of its damping acts."""


class Flange(NamedTuple):
    """Sideways guide: play to each side (m), stiffness (N/m), damping (N s/m)."""

    play: float
    stiffness: float
    damping: float


@inner
def law_slopes(law: Impact, depth: float, rate: float) -> tuple[float, float, float]:
    """Return the normal force (N) of a law and its derivatives by depth and by its rate."""
    force = impact_force(law, depth, rate)
    if force <= 0.0:
        return 0.0, 0.0, 0.0
    part = min(depth / law.damping_depth, 1.0)
    faded = step(depth, 0.0, 0.0, law.damping_depth, 1.0)
    by_depth = law.exponent * law.stiffness * depth ** (law.exponent - 1.0)
    by_depth += law.damping * rate * 6.0 * part * (1.0 - part) / law.damping_depth
    return force, by_depth, law.damping * faded


@inner
def stored_energy(law: Impact, depth: float) -> float:
    """Return the energy (J) in a contact of this law, zero without contact."""
    return law.stiffness / (law.exponent + 1.0) * depth ** (law.exponent + 1.0) if depth > 0.0 else 0.0


@kernel
def flange_force(flange: Flange, y: float, rate: float) -> tuple[float, float, float]:
    """Return the force (N) along y at an offset y (m) from the middle, and its stiffness and damping."""
    beyond = abs(y) - flange.play
    if beyond <= 0.0:
        return 0.0, 0.0, 0.0
    sign = 1.0 if y > 0.0 else -1.0
    # damping grows with the depth, so that it does not jump where the flange is met
    law = Impact(flange.stiffness, 1.0, flange.damping, FLANGE_DEPTH)
    force, stiffness, damping = law_slopes(law, beyond, sign * rate)
    return -sign * force, stiffness, damping
