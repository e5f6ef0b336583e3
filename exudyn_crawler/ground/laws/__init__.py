"""Laws of contact, one file each; a law's numbers choose its functions.

Pure functions of numbers, compiled so that the contact of a whole track costs microseconds; every function
can be called from plain Python as well. A law is chosen by a number, since functions handed over as
arguments would be compiled anew in every process. A new law is one more file, one more number and one more
field of `Law` for its parameters; with the fields of the others it keeps the type that the kernels were
compiled for.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled, inlined
from exudyn_crawler.ground.laws.coulomb import Coulomb, equal_area_radius, friction_per_slip, friction_torque
from exudyn_crawler.ground.laws.impact import Impact, impact_force
from exudyn_crawler.ground.laws.linear import Linear, linear_force, linear_friction_per_slip

IMPACT, LINEAR = 0, 1
"""Normal laws: `impact`, `linear`."""

COULOMB, PROPORTIONAL = 0, 1
"""Friction laws: `coulomb`, `linear`."""

_NO = math.nan


class Law(NamedTuple):
    """Numbers of the normal and the friction law, and the parameters of those that they choose."""

    normal: int
    friction: int
    impact: Impact = Impact(_NO, _NO, _NO, _NO)
    coulomb: Coulomb = Coulomb(_NO, _NO, _NO, _NO)
    linear: Linear = Linear(_NO, _NO, _NO, _NO)


@inlined
def normal_force(law: Law, depth: float, rate: float) -> float:
    """Normal force (N) at a penetration (m) and its rate (m/s)."""
    if law.normal == LINEAR:
        return linear_force(law.linear, depth, rate)
    return impact_force(law.impact, depth, rate)


@compiled
def drag_ratio(law: Law, slip_speed: float) -> float:
    """Friction over normal force and slip speed (s/m), finite at rest."""
    if law.friction == PROPORTIONAL:
        return linear_friction_per_slip(law.linear, slip_speed)
    return friction_per_slip(law.coulomb, slip_speed)


@inlined
def spin_torque(law: Law, spin: float, area: float, friction: float) -> float:
    """Torque (N m) about the normal against a spin (rad/s) of a contact of this area (m2) and friction (N).

    None by the proportional law, which is one of points.
    """
    if law.friction == PROPORTIONAL:
        return 0.0
    return friction_torque(law.coulomb, spin, equal_area_radius(area), friction)


@inlined
def named_law(values: tuple) -> Law:
    """Law of its values as plain tuples."""
    normal, friction, impact, coulomb, linear = values
    return Law(normal, friction, Impact(*impact), Coulomb(*coulomb), Linear(*linear))
