"""Contact of a shoe with a terrain unit."""

from typing import Literal, Self

from pydantic import Field, model_validator

from exudyn_crawler.case.base import Parameters, quantity


class ContactLaw(Parameters):
    """ADAMS IMPACT normal law with Coulomb friction; formulas in `exudyn_crawler.ground.laws`."""

    stiffness: float = quantity("N/m^exponent", "contact stiffness k", gt=0)
    exponent: float = quantity("1", "exponent e of the penetration", ge=1)
    damping: float = quantity("N s/m", "greatest damping coefficient c_max", ge=0)
    damping_depth: float = quantity("m", "penetration d at which the damping is full", gt=0)
    static_friction: float = quantity("1", "coefficient mu_s at the stiction speed", ge=0)
    dynamic_friction: float = quantity("1", "coefficient mu_d beyond the friction speed", ge=0)
    stiction_speed: float = quantity("m/s", "V_st", gt=0)
    friction_speed: float = quantity("m/s", "V_d", gt=0)
    sharing: Literal["pair", "area"] = Field(
        description="what of the law a pair of shoe and unit has: all of it, however little they overlap, or "
        "the part of the shoe's underside that is on the unit",
    )
    edge_width: float = quantity(
        "m",
        "overlap width at which a pair has all of the law; with sharing 'pair' the force grows with STEP "
        "from zero, since that law knows no area and would jump when a shoe reaches a unit's edge",
        gt=0,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.dynamic_friction > self.static_friction:
            raise ValueError(
                f"dynamic_friction must not exceed static_friction = {self.static_friction}, "
                f"got {self.dynamic_friction}"
            )
        if self.friction_speed <= self.stiction_speed:
            raise ValueError(
                f"friction_speed must exceed stiction_speed = {self.stiction_speed}, "
                f"got {self.friction_speed}"
            )
        return self

    @classmethod
    def oil_sand(cls, sharing: Literal["pair", "area"] = "pair") -> Self:
        """Steel shoe on oil sand (all papers, contact table); sharing and edge width are chosen here."""
        return cls(
            stiffness=1.0e8,
            exponent=2.0,
            damping=1.0e4,
            damping_depth=1.0e-4,
            static_friction=0.4,
            dynamic_friction=0.3,
            stiction_speed=0.01,
            friction_speed=0.1,
            sharing=sharing,
            edge_width=0.01,
        )
