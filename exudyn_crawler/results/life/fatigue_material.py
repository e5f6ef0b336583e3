"""Fatigue strength of a shoe's material by local stresses of the FKM guideline, whose formulas are pyLife's.

FKM is "Analytical Strength Assessment of Components", Forschungskuratorium Maschinenbau, 6th ed., 2012.
"""

from typing import Literal, Self

import pandas as pd
from pydantic import Field, model_validator

from exudyn_crawler.case.parameters.base import Name, Parameters, quantity
from fem.fatigue import Miner, SNCurve

FKMClass = Literal["steel", "forged steel", "case-hardened steel", "stainless steel", "cast steel"]
PYLIFE_CLASSES = {
    "steel": "Steel",
    "forged steel": "Forg_Steel",
    "case-hardened steel": "CaseHard_Steel",
    "stainless steel": "Stainless_Steel",
    "cast steel": "GS",
}
MEGA, MICRO, MILLI = 1e6, 1e-6, 1e-3


class FatigueMaterial(Parameters):
    """Material of the shoes against cyclic stress."""

    name: Name = Field(description="of the material")
    source: str = Field(default="", max_length=1000, description="where the values are from, what is assumed")
    tensile_strength: float = quantity(
        "Pa", "R_m, of the standard or of a specimen", plausible=(2e8, 2.5e9), ge=1e7, le=1e10
    )
    yield_strength: float = quantity("Pa", "R_e or R_p0.2", plausible=(1e8, 2e9), ge=1e7, le=1e10)
    fkm_class: FKMClass = Field(description="material class of the FKM guideline, whose constants it takes")
    size_factor: float = quantity(
        "1",
        "tensile strength in the part over that of the specimen (FKM: K_d K_A)",
        plausible=(0.6, 1.0),
        gt=0.1,
        le=1,
        default=1.0,
    )
    roughness: float = quantity(
        "m",
        "R_z; 200 micrometres stand for the skin of casting and rolling (FKM 4.3.1.4)",
        plausible=(1e-6, 5e-4),
        ge=1e-6,
        le=1e-2,
        default=2e-4,
    )
    stress_gradient: float = quantity(
        "1/m",
        "related stress gradient at the notches, for the support number (FKM 4.3.1.3.1, Stieler); 0: none",
        plausible=(0.0, 2e3),
        ge=0,
        le=1e5,
        default=0.0,
    )
    casting_factor: float = quantity(
        "1",
        "by which casting defects divide the strength (FKM: 1.25 of tested, 1.4 of untested castings)",
        plausible=(1.0, 2.0),
        ge=1,
        le=10,
        default=1.0,
    )
    slope: float = quantity(
        "1", "k of the S-N curve (FKM: 5 for normal stress)", plausible=(3.0, 15.0), ge=1, le=50, default=5.0
    )
    knee: float = quantity(
        "1", "cycles at its knee (FKM: 1e6)", plausible=(1e5, 1e7), ge=1e3, le=1e10, default=1e6
    )
    scatter: float = quantity(
        "1",
        "strength that 10 % survive over that which 90 % survive",
        plausible=(1.0, 2.0),
        ge=1,
        le=10,
        default=1.25,
    )
    survival: float = quantity("1", "part that survives the strength (FKM: 0.975)", gt=0, lt=1, default=0.975)
    fatigue_strength: float | None = quantity(
        "Pa",
        "amplitude at R = -1 at the knee, of a polished specimen; none: FKM's part of R_m",
        plausible=(5e7, 1e9),
        ge=1e6,
        le=1e10,
        default=None,
    )
    mean_sensitivity: float | None = quantity(
        "1", "M of mean stresses; none: FKM 4.4.2.1.2", plausible=(0.0, 0.8), ge=0, lt=1, default=None
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.yield_strength > self.tensile_strength:
            raise ValueError(
                f"yield_strength must not exceed tensile_strength = {self.tensile_strength:g} Pa, "
                f"got {self.yield_strength:g} Pa"
            )
        return self

    @classmethod
    def a36(cls) -> Self:
        """Structural steel ASTM A36, which the papers' shoe is said to be of; rolled, not cast."""
        return cls(
            name="A36",
            source="ASTM A36: least yield and tensile strength; scatter and rolling skin assumed",
            tensile_strength=400e6,
            yield_strength=250e6,
            fkm_class="steel",
        )

    @classmethod
    def cast_nicrmo(cls) -> Self:
        """Quenched and tempered NiCrMo cast steel, what shoes are made of; its hardened layer left out."""
        return cls(
            name="cast NiCrMo",
            source="yield as makers of shoes give it; tensile strength in the ratio of ASTM A148 120-95, "
            "tested castings, skin and scatter assumed; the hardened roller path counts as its core",
            tensile_strength=860e6,
            yield_strength=690e6,
            fkm_class="cast steel",
            casting_factor=1.25,
            scatter=1.4,
        )

    @classmethod
    def cast_manganese(cls) -> Self:
        """Austenitic manganese steel (Hadfield), as quenched in water; its hardening in service left out."""
        return cls(
            name="austenitic manganese",
            source="ASTM A128, typical strengths of thick castings assumed; FKM has no such class, that of "
            "cast steel stands for it; tested castings, skin and scatter assumed",
            tensile_strength=760e6,
            yield_strength=350e6,
            fkm_class="cast steel",
            casting_factor=1.25,
            scatter=1.4,
        )

    def provenance(self) -> str:
        """Source of the values; of a ready material that was changed, which values are not of that source."""
        for ready in (self.a36(), self.cast_nicrmo(), self.cast_manganese()):
            changed = [
                name
                for name in type(self).model_fields
                if name != "name" and getattr(self, name) != getattr(ready, name)
            ]
            if self.source == ready.source and changed:
                return f"{', '.join(changed)} as the duty gives; all else: {self.source}"
        return self.source

    def factors(self) -> dict[str, float]:
        """What makes the strength: fatigue_strength (Pa), roughness, support, design, mean_sensitivity.

        The strength at the knee is fatigue_strength over design and casting_factor.
        """
        from pylife.strength.fkm_linear.fkm_functions import FkmLinearFunctions

        fkm, normal = FkmLinearFunctions(), pd.Series(["normal"])
        kind = pd.Series([PYLIFE_CLASSES[self.fkm_class]])
        strength = pd.Series([self.size_factor * self.tensile_strength / MEGA])
        constants, shear = fkm.get_material_constants(kind, normal)
        reversed_strength = MEGA * fkm.reversed_mat_strength_chap4(strength, constants, shear, normal)
        roughness = fkm.rough_factor(
            strength, pd.Series([self.roughness / MICRO]), constants, shear, normal, pd.Series(["rough"])
        )
        gradient = pd.Series([MILLI * self.stress_gradient])
        support = fkm.stieler_support(constants, shear, normal, gradient, strength)
        notch, one = fkm.kf_constant(kind), pd.Series([1.0])
        design = fkm.design_factor(support, notch, roughness, one, one, one)
        mean = fkm.sm_sensitivity_chap4(strength, constants, shear, normal)
        found = {
            "fatigue_strength": reversed_strength,
            "roughness": roughness,
            "support": support,
            "design": design,
            "mean_sensitivity": mean,
        }
        single = {name: float(pd.Series(values).iloc[0]) for name, values in found.items()}
        single["mean_sensitivity"] = max(0.0, single["mean_sensitivity"])
        own = {name: getattr(self, name) for name in ("fatigue_strength", "mean_sensitivity")}
        return single | {name: value for name, value in own.items() if value is not None}

    def curve(self, miner: Miner = "elementary") -> SNCurve:
        """S-N curve of the part's surface by local stresses."""
        factors = self.factors()
        return SNCurve(
            strength=factors["fatigue_strength"] / factors["design"] / self.casting_factor,
            slope=self.slope,
            knee=self.knee,
            mean_sensitivity=factors["mean_sensitivity"],
            scatter=self.scatter,
            survival=self.survival,
            miner=miner,
        )
