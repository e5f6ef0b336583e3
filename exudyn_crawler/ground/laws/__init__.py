"""Laws of contact, one file each, and which of them a contact has.

Pure functions of numbers, compiled so that the contact of a whole track costs microseconds; every function
can be called from plain Python as well. Functions handed over as arguments would be compiled anew in every
process: a second law is one more file, one more field of `Law` for its parameters, and a number there that
chooses it in the functions below.
"""

from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled, inlined
from exudyn_crawler.ground.laws.coulomb import Coulomb, equal_area_radius, friction_per_slip, friction_torque
from exudyn_crawler.ground.laws.impact import Impact, impact_force


class Law(NamedTuple):
    """Parameters of the normal and of the friction law."""

    impact: Impact
    coulomb: Coulomb


@inlined
def normal_force(law: Law, depth: float, rate: float) -> float:
    """Normal force (N) at a penetration (m) and its rate (m/s)."""
    return impact_force(law.impact, depth, rate)


@compiled
def drag_ratio(law: Law, slip_speed: float) -> float:
    """Friction over normal force and slip speed (s/m), finite at rest."""
    return friction_per_slip(law.coulomb, slip_speed)


@inlined
def spin_torque(law: Law, spin: float, area: float, friction: float) -> float:
    """Torque (N m) about the normal against a spin (rad/s) of a contact of an area (m2) and friction (N)."""
    return friction_torque(law.coulomb, spin, equal_area_radius(area), friction)


@inlined
def named_law(values: tuple) -> Law:
    """Law of its values as plain tuples."""
    impact, coulomb = values
    return Law(Impact(*impact), Coulomb(*coulomb))
