"""Soil that yields: Bekker's pressure-sinkage law, Wong's unloading and reloading, Janosi's shear.

Bekker, Introduction to Terrain-Vehicle Systems (1969); Wong, Theory of Ground Vehicles, chapter 2; Janosi and
Hanamoto, 1st Int. Conf. on the Mechanics of Soil-Vehicle Systems (1961).
"""

import math
from typing import ClassVar, Literal, NamedTuple, Self

from exudyn_crawler.ground.cells.law import CellLaw, LawKernel, Memory, Probe, Response
from exudyn_crawler.ground.cells.shear import NOTHING, Strength, answer, lifted, shear_strength
from exudyn_crawler.ground.compiled import inlined, kernel
from exudyn_crawler.settings.parameters import quantity

ROUNDING = 1e-3
"""Sinkage (m) below which the curve is a parabola with the same value and slope there: a power below 1 has no
finite slope at the surface. Chosen here."""
SMALL = 1e-2
"""Largest relative increase of a sinkage for which the series of its power is exact to rounding."""


Unloading = Literal["wong", "chrono"]
"""Law of unloading of a named soil, see `BekkerSoil.lete_sand`."""


class Bekker(NamedTuple):
    """Constants: ``p = k z**n`` with k = k_c / b + k_phi (N/m^(n+2)); the rest as in `BekkerSoil`, SI."""

    k: float
    exponent: float
    reload: float
    reload_growth: float
    damping: float
    cohesion: float
    friction: float
    deformation: float
    viscosity: float


@kernel
def backbone(law: Bekker, z: float) -> tuple[float, float]:
    """Return the pressure (Pa) of first loading at a sinkage (m), and its slope."""
    if z <= 0.0:
        return 0.0, 0.0
    if z >= ROUNDING:
        p = law.k * z**law.exponent
        return p, law.exponent * p / z
    p = law.k * ROUNDING**law.exponent
    s = z / ROUNDING
    n = law.exponent
    return p * s * ((2.0 - n) + (n - 1.0) * s), p / ROUNDING * ((2.0 - n) + 2.0 * (n - 1.0) * s)


@inlined
def deeper(law: Bekker, z: float, memory: Memory, nearby: bool) -> tuple[float, float]:
    """Return `backbone` slightly beyond the deepest sinkage, by a series from the pressure there.

    A power takes long to compute.
    """
    s = z / memory.deepest - 1.0 if memory.deepest >= ROUNDING else 1.0
    if s > SMALL:
        return (math.nan, math.nan) if nearby else backbone(law, z)
    n = law.exponent
    rest = 1.0 + s * (n - 3.0) / 4.0 * (1.0 + s * (n - 4.0) / 5.0)
    p = memory.pressure * (1.0 + s * n * (1.0 + s * (n - 1.0) / 2.0 * (1.0 + s * (n - 2.0) / 3.0 * rest)))
    return p, n * p / z


@kernel
def prepare(law: Bekker, deepest: float, pressure: float) -> tuple[float, float]:
    """Return the modulus of unloading, and the shear stiffness at the greatest pressure.

    The modulus is Wong's ``k_0 + A_u z``, but at least the secant to the start of unloading and at least the
    curve's slope there. Unloading then never returns more energy than loading took.
    """
    modulus = 0.0
    if deepest > 0.0:
        modulus = max(law.reload + law.reload_growth * deepest, max(1.0, law.exponent) * pressure / deepest)
    strength = Strength(law.cohesion, law.friction, law.deformation, law.viscosity)
    return modulus, shear_strength(strength, pressure)[0] / law.deformation


@inlined
def respond(law: Bekker, probe: Probe, tangents: bool, nearby: bool) -> Response:
    """Return the response of a cell: on the curve at and beyond the deepest sinkage, elastic above it."""
    memory = probe.memory
    deepest = memory.deepest
    greatest = memory.pressure
    if probe.depth >= deepest:
        p, slope = deeper(law, probe.depth, memory, nearby)
        deepest = max(deepest, probe.depth)
        greatest = max(p, greatest)
    else:
        slope = probe.prepared[0]
        p = greatest - slope * (deepest - probe.depth)
    if p <= 0.0:
        return lifted(Memory(deepest, greatest, NOTHING, 0.0))
    strength = Strength(law.cohesion, law.friction, law.deformation, law.viscosity)
    after = Memory(deepest, greatest, NOTHING, 0.0)
    return answer(strength, law.damping, probe, (p, slope), after, tangents, nearby)


class BekkerSoil(CellLaw):
    """Soil by Bekker, Wong, Janosi and Hanamoto: it keeps ruts, and is stiffer when it is loaded again."""

    model: Literal["bekker"] = "bekker"
    k_c: float = quantity("N/m^(exponent+1)", "cohesive modulus k_c", plausible=(0.0, 1e6), ge=0, le=1e12)
    k_phi: float = quantity(
        "N/m^(exponent+2)", "frictional modulus k_phi", plausible=(1e4, 1e8), gt=0, le=1e15
    )
    exponent: float = quantity("1", "exponent n of the sinkage", plausible=(0.3, 1.5), gt=0, lt=2)
    reload_stiffness: float = quantity(
        "Pa/m", "modulus k_0 of unloading and reloading", plausible=(0.0, 1e10), ge=0, le=1e15
    )
    reload_growth: float = quantity(
        "Pa/m2", "growth A_u of this modulus with the sinkage", plausible=(0.0, 1e12), ge=0, le=1e18
    )
    cohesion: float = quantity("Pa", "cohesion c", plausible=(0.0, 1e5), ge=0, le=1e9)
    friction_angle: float = quantity(
        "deg", "angle phi of internal friction", plausible=(5.0, 50.0), ge=0, lt=80
    )
    kernel: ClassVar[LawKernel] = LawKernel(Bekker, prepare, respond, fresh=0.0, forgets=False)

    @classmethod
    def lete_sand(cls, unloading: Unloading = "wong") -> Self:
        """Return dry LETE sand: pressure and shear as in Chrono (`demo_VEH_SCMTerrain_RigidTire.cpp`).

        Unloading decides the pull of a track, because pressure between rollers keeps the mobilized shear of
        the ground. The default is `"wong"`, ``A_u`` = 503e6 N/m4 of Wong's repeated plate tests on this sand
        (Terramechanics and Off-Road Vehicle Engineering, chapter 4; recalled, not confirmed at the source).
        Below a sinkage of 24 mm this line is softer than first loading, and the law springs back wholly: no
        rut stays, and no work of compaction. `"chrono"`, 4e8 Pa/m, does not come from a test. Chrono requires
        a value above ``k_phi`` and gives this one to a soil of 2 MN/m3.1, too. It leaves nearly all of the
        sinkage as a rut, and the pressure between rollers falls to zero. Shear then starts again below each
        roller, as in Wong's repeated shear tests (recalled); Chrono's own soil never forgets it.
        """
        steep, growth = (0.0, 503e6) if unloading == "wong" else (4e8, 0.0)
        return cls(
            k_c=102e3,
            k_phi=5301e3,
            exponent=0.793,
            reload_stiffness=steep,
            reload_growth=growth,
            cohesion=1.3e3,
            friction_angle=31.1,
            shear_deformation=0.012,
        )

    @classmethod
    def oil_sand_low(cls, unloading: Unloading = "wong") -> Self:
        """Return McMurray oil sand, the soft and weak end of the known range.

        Shear strength: CIM 1960, 1741 to 1754 kg/m3, c of 2.6 to 5.9 kPa and phi of 30 to 40 deg; less when
        loose or warm. Open: sinkage; no source gives k_c, k_phi and n. Here a shoe sinks 66 mm under 191 kPa,
        its share of the machine, as on the papers' ground; n, K and unloading are those of LETE sand.
        """
        sand = cls.lete_sand(unloading)
        return sand.with_(k_c=0.0, k_phi=1.65e6, cohesion=2.6e3, friction_angle=30.0)

    @classmethod
    def oil_sand_high(cls, unloading: Unloading = "wong") -> Self:
        """Return McMurray oil sand, the stiff and strong end of the known range.

        Its sinkage is that of LETE sand; strength as in `oil_sand_low`.
        """
        return cls.lete_sand(unloading).with_(cohesion=5.9e3, friction_angle=40.0)

    def constants(self, width: float) -> Bekker:
        """Return the constants for shoes whose shorter side is `width` (m)."""
        return Bekker(
            self.k_c / width + self.k_phi,
            self.exponent,
            self.reload_stiffness,
            self.reload_growth,
            self.damping,
            self.cohesion,
            math.tan(math.radians(self.friction_angle)),
            self.shear_deformation,
            self.shear_viscosity,
        )
