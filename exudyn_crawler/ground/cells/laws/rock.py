"""Rock and frozen or hard floor: stiff, without memory of depth, Coulomb friction with sticking."""

import math
from typing import ClassVar, Literal, NamedTuple, Self

from exudyn_crawler.ground.cells.law import CellLaw, LawKernel, Memory, Probe, Response
from exudyn_crawler.ground.cells.shear import NOTHING, Strength, answer, lifted, shear_strength
from exudyn_crawler.ground.compiled import inlined, kernel
from exudyn_crawler.settings.parameters import quantity


class Rock(NamedTuple):
    """Constants, as in `RockFloor`."""

    stiffness: float
    exponent: float
    damping: float
    friction: float
    deformation: float
    viscosity: float


@kernel
def prepare(law: Rock, _deepest: float, pressure: float) -> tuple[float, float]:
    """Return zero modulus of unloading, and the shear stiffness at the greatest pressure."""
    strength = Strength(0.0, law.friction, law.deformation, law.viscosity)
    return 0.0, shear_strength(strength, pressure)[0] / law.deformation


@inlined
def respond(law: Rock, probe: Probe, tangents: bool, nearby: bool) -> Response:
    """Return the response of a cell: the same curve for loading and unloading."""
    if probe.depth <= 0.0:
        return lifted(Memory(0.0, 0.0, NOTHING, 1.0))
    if law.exponent == 1.0:
        p = law.stiffness * probe.depth
        slope = law.stiffness
    elif nearby:
        p = slope = math.nan
    else:
        p = law.stiffness * probe.depth**law.exponent
        slope = law.exponent * p / probe.depth
    strength = Strength(0.0, law.friction, law.deformation, law.viscosity)
    deepest = max(probe.depth, probe.memory.deepest)
    greatest = max(p, probe.memory.pressure)
    after = Memory(deepest, greatest, NOTHING, 1.0)
    return answer(strength, law.damping, probe, (p, slope), after, tangents, nearby)


class RockFloor(CellLaw):
    """Stiff floor: the pressure is ``stiffness depth**exponent``, loading and unloading alike."""

    model: Literal["rock"] = "rock"
    stiffness: float = quantity(
        "Pa/m^exponent", "contact stiffness of a unit area", plausible=(1e7, 1e11), ge=1e3, le=1e15
    )
    exponent: float = quantity(
        "1", "exponent of the penetration", plausible=(1.0, 2.0), ge=1, le=3, default=1.0
    )
    friction: float = quantity("1", "coefficient of friction", plausible=(0.05, 1.0), gt=0, le=10)
    kernel: ClassVar[LawKernel] = LawKernel(Rock, prepare, respond, fresh=1.0, forgets=True)

    @classmethod
    def hard_floor(cls) -> Self:
        """Return frozen or rock floor: 0.2 mm under 200 kPa, less than the links and shoes above yield.

        Stiffness, friction of steel on rock, and elastic slip are all chosen here.
        """
        return cls(stiffness=1e9, friction=0.6, shear_deformation=1e-3, damping=0.1)

    def constants(self, width: float) -> Rock:
        """Return the constants, the same for shoes of any width."""
        return Rock(
            self.stiffness,
            self.exponent,
            self.damping,
            self.friction,
            self.shear_deformation,
            self.shear_viscosity,
        )
