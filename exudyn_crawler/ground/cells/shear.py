"""Shared parts of the laws of the cells: elastic-plastic shear by Janosi and Hanamoto, damping, response."""

import math
from typing import NamedTuple

from exudyn_crawler.ground.cells.law import Memory, Probe, Response
from exudyn_crawler.ground.compiled import inlined, kernel
from exudyn_crawler.ground.frames import Vector, along, dot, scaled

COHESION_PRESSURE = 1e3
"""Pressure (Pa) at which half of the cohesion acts: strength then falls to zero with the pressure, without a
jump where a shoe lifts off. Chosen here; it takes 0.5 % off the cohesion at 200 kPa."""

NOTHING = (0.0, 0.0, 0.0)
HALF = 0.5
SIXTH = 1.0 / 6.0
SMALL = 0.02
"""Plastic slip, in shear deformations, up to which a series gives its exponential."""


class Strength(NamedTuple):
    """Cohesion c (Pa), tangent of the friction angle, shear deformation K (m), viscosity of shear (s).

    The viscosity acts where shear sticks, and brings a stuck shoe to rest.
    """

    cohesion: float
    friction: float
    deformation: float
    viscosity: float


class Shear(NamedTuple):
    """Shear and viscous part of a `Response`; their `by_pressure` is that of `shear` and of ``drag v``."""

    shear: Vector
    by_pressure: Vector
    along: float
    across: float
    direction: Vector
    drag: float
    mobilized: float


@kernel
def shear_strength(law: Strength, pressure: float) -> tuple[float, float]:
    """Return the shear strength T (Pa) at a pressure, ``p (tan phi + c / (p + p_c))``, and its derivative."""
    share = 1.0 / (pressure + COHESION_PRESSURE)
    derivative = law.friction + law.cohesion * COHESION_PRESSURE * share * share
    return pressure * (law.friction + law.cohesion * share), derivative


@inlined
def _decay(x: float, nearby: bool) -> float:
    """Return ``exp(-x)``, by a series exact to rounding for a small x; otherwise NaN if `nearby`."""
    if x > SMALL:
        return math.nan if nearby else math.exp(-x)
    return 1.0 - x * (
        1.0 - x * (HALF - x * (SIXTH - x * (SIXTH / 4.0 - x * (SIXTH / 20.0 - x * SIXTH / 120.0))))
    )


@inlined
def sheared(law: Strength, probe: Probe, pressure: float, tangents: bool, nearby: bool) -> Shear:
    """Return the shear stress after the slip of a step.

    The stress is elastic with the stiffness ``T / K`` of the greatest pressure so far. If it exceeds the
    mobilized share r of the strength T, r grows to ``1 - (1 - r) exp(-e / K)`` with the plastic slip e, and
    the stress returns to ``T r``. From fresh ground (r = 0) this is the curve of Janosi and Hanamoto,
    ``T (1 - exp(-j / K))``, for steps of any size. From r = 1 it is Coulomb friction with sticking. The
    stiffness never falls while a cell is in contact, so that no cycle of pressure and slip makes energy.
    """
    T, T_p = shear_strength(law, pressure)
    memory = probe.memory
    slip = probe.slip
    per = 1.0 / law.deformation
    k = probe.prepared[1]
    k_p = 0.0
    if pressure > memory.pressure:
        k = per * T
        k_p = per * T_p
    # viscous where it sticks, nothing where the committed shear is all of the strength
    used = dot(memory.shear, memory.shear) / (T * T)
    drag = drag_p = 0.0
    if used < 1.0:
        drag = law.viscosity * per * T * (1.0 - used)
        drag_p = law.viscosity * per * T_p * (1.0 + used)
    trial = along(memory.shear, k, slip)
    square = dot(trial, trial)
    bound = T * memory.mobilized
    by_pressure = NOTHING
    if tangents:
        by_pressure = along(scaled(k_p, slip), drag_p, probe.slip_velocity)
    if square <= max(bound * bound, 1e-18 * T * T):
        if square > bound * bound:
            k = per * T
        return Shear(trial, by_pressure, k, k, NOTHING, drag, memory.mobilized)
    size = math.sqrt(square)
    plastic = (size - bound) / k
    mobilized = 1.0
    if memory.mobilized < 1.0:
        mobilized -= (1.0 - memory.mobilized) * _decay(per * plastic, nearby)
    scale = T * mobilized / size
    tangential = 0.0
    direction = NOTHING
    if tangents:
        direction = scaled(1.0 / size, trial)
        tangential = per * T * (1.0 - mobilized)
        forward = dot(direction, slip)
        grow = T_p * mobilized + tangential * (forward * k_p - T_p * memory.mobilized - plastic * k_p) / k
        sideways = along(slip, -forward, direction)
        by_pressure = along(scaled(grow, direction), scale * k_p, sideways)
        by_pressure = along(by_pressure, drag_p, probe.slip_velocity)
    return Shear(scaled(scale, trial), by_pressure, tangential, scale * k, direction, drag, mobilized)


@inlined
def answer(
    law: Strength,
    damping: float,
    probe: Probe,
    normal: tuple[float, float],
    after: Memory,
    tangents: bool,
    nearby: bool = False,
) -> Response:
    """Return the response of ground in contact.

    Parameters
    ----------
    damping : float
        s/m; the pressure p becomes ``p (1 + damping rate)``, never a pull. The strength is that of p alone:
        an impact adds none.
    normal : tuple
        Pressure (Pa) and its derivative by depth.
    after : Memory
        Trial memory except for the shear.
    nearby : bool
        Ask for a response near the committed memory, see `LawKernel`.
    """
    pressure, slope = normal
    shear = sheared(law, probe, pressure, tangents, nearby)
    factor = max(0.0, 1.0 + damping * probe.rate)
    return Response(
        pressure * factor if shear.mobilized == shear.mobilized else math.nan,
        slope * factor,
        pressure * damping if factor > 0.0 else 0.0,
        shear.shear,
        scaled(slope, shear.by_pressure),
        shear.along,
        shear.across,
        shear.direction,
        shear.drag,
        Memory(after.deepest, after.pressure, shear.shear, shear.mobilized),
    )


@inlined
def lifted(after: Memory) -> Response:
    """Return the response of ground without contact, with `after` as trial memory."""
    return Response(0.0, 0.0, 0.0, NOTHING, NOTHING, 0.0, 0.0, NOTHING, 0.0, after)
