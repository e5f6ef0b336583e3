"""What laws of the cells share: elastic-plastic shear by Janosi and Hanamoto, damping, their answer.

The constants of a law have for it: `cohesion` c (Pa); `friction`, the tangent of the friction angle;
`shear_deformation` K (m); `shear_viscosity` (s), which acts where shear sticks and lets a stuck shoe come to
rest; and `damping` (s/m).
"""

import math
from typing import Any

from exudyn_crawler.ground.cells.law import Memory, Probe, Response
from exudyn_crawler.ground.frames import along, compiled, dot, inlined, scaled

COHESION_PRESSURE = 1e3
"""Pa, pressure at which half of the cohesion acts: strength then falls to nothing with the pressure, without
a jump where a shoe lifts off. Chosen here; it takes 0.5 % off the cohesion at 200 kPa."""

NOTHING = (0.0, 0.0, 0.0)
HALF, SIXTH = 0.5, 1.0 / 6.0
SMALL = 0.02
"""Plastic slip, in shear deformations, up to which a series has the exponential of it."""


@compiled
def shear_strength(law: Any, pressure: float) -> tuple[float, float]:
    """Shear strength T (Pa) at a pressure, and its derivative: ``p (tan phi + c / (p + p_c))``."""
    share = 1.0 / (pressure + COHESION_PRESSURE)
    derivative = law.friction + law.cohesion * COHESION_PRESSURE * share * share
    return pressure * (law.friction + law.cohesion * share), derivative


@inlined
def _decay(x: float, nearby: bool) -> float:
    """``exp(-x)``: where x is small by its series, exact to rounding, else NaN if it is for `nearby`."""
    if x > SMALL:
        return math.nan if nearby else math.exp(-x)
    return 1.0 - x * (
        1.0 - x * (HALF - x * (SIXTH - x * (SIXTH / 4.0 - x * (SIXTH / 20.0 - x * SIXTH / 120.0))))
    )


@inlined
def answer(
    law: Any, probe: Probe, normal: tuple[float, float], after: Memory, tangents: bool, nearby: bool
) -> Response:
    """Response of ground in contact, of its pressure (Pa) and the derivative of that by depth.

    Shear is elastic with the stiffness ``T / K`` of the greatest pressure that the cell has had; where that
    exceeds the mobilized share r of the strength T, r grows to ``1 - (1 - r) exp(-e / K)`` with the plastic
    slip e, and the stress is turned back to ``T r``. From fresh ground (r = 0) this is the curve of Janosi
    and Hanamoto, ``T (1 - exp(-j / K))``, for steps of any size; from r = 1 it is Coulomb friction with
    sticking. The stiffness never falls while a cell is in contact, so that no cycle of pressure and slip
    makes energy.

    Damping makes ``p (1 + damping rate)`` of the pressure p, never a pull. Strength is that of p alone: an
    impact lends none. `after` is the memory on trial, but for the shear.
    """
    pressure, slope = normal
    T, T_p = shear_strength(law, pressure)
    memory, slip, per = probe.memory, probe.slip, 1.0 / law.shear_deformation
    k, k_p = probe.prepared[1], 0.0
    if pressure > memory.pressure:
        k, k_p = per * T, per * T_p
    # viscous where it sticks, nothing where the committed shear is all of the strength
    used = dot(memory.shear, memory.shear) / (T * T)
    drag = drag_p = 0.0
    if used < 1.0:
        drag = law.shear_viscosity * per * T * (1.0 - used)
        drag_p = law.shear_viscosity * per * T_p * (1.0 + used)
    shear, mobilized = along(memory.shear, k, slip), memory.mobilized
    square, bound = dot(shear, shear), T * mobilized
    by_pressure, direction, forward, across = NOTHING, NOTHING, k, k
    if square <= max(bound * bound, 1e-18 * T * T):
        if square > bound * bound:
            forward = across = per * T
        if tangents:
            by_pressure = scaled(k_p, slip)
    else:
        size = math.sqrt(square)
        plastic, before = (size - bound) / k, mobilized
        mobilized = 1.0
        if before < 1.0:
            mobilized -= (1.0 - before) * _decay(per * plastic, nearby)
        scale = T * mobilized / size
        across, forward = scale * k, 0.0
        if tangents:
            direction = scaled(1.0 / size, shear)
            forward = per * T * (1.0 - mobilized)
            slid = dot(direction, slip)
            grow = T_p * mobilized + forward * (slid * k_p - T_p * before - plastic * k_p) / k
            by_pressure = along(scaled(grow, direction), scale * k_p, along(slip, -slid, direction))
        shear = scaled(scale, shear)
    if tangents:
        by_pressure = along(by_pressure, drag_p, probe.slip_velocity)
    factor = max(0.0, 1.0 + law.damping * probe.rate)
    return Response(
        pressure * factor if mobilized == mobilized else math.nan,
        slope * factor,
        pressure * law.damping if factor > 0.0 else 0.0,
        shear,
        scaled(slope, by_pressure),
        forward,
        across,
        direction,
        drag,
        Memory(after.deepest, after.pressure, shear, mobilized),
    )


@inlined
def lifted(after: Memory) -> Response:
    """Response of ground without contact, with this memory on trial."""
    return Response(0.0, 0.0, 0.0, NOTHING, NOTHING, 0.0, 0.0, NOTHING, 0.0, after)
