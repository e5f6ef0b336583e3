"""Flexible shoes of a track."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from exudyn_crawler.parameters.base import Parameters, quantity
from exudyn_crawler.parameters.profile import StepProfile


class FlexibleShoes(Parameters):
    """Which shoes are flexible, and the finite-element model that all of them share."""

    shoes: Annotated[tuple[int, ...], Field(min_length=1, description="numbers of the flexible shoes")]
    mesh: str = Field(description="coarse, study or fine, or the path of a mesh with the same surfaces")
    youngs_modulus: float = quantity("Pa", "E", gt=0)
    poissons_ratio: float = quantity("1", "nu", gt=-1, lt=0.5)
    density: float = quantity("kg/m3", "density", gt=0)
    fixed_modes: int = quantity("1", "fixed-interface modes that answer dynamically", ge=0)
    damping: StepProfile = quantity("1", "modal damping ratio over frequency (Hz, in place of times)")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.shoes)) != len(self.shoes) or list(self.shoes) != sorted(self.shoes):
            raise ValueError(f"shoes must be different numbers in rising order, got {self.shoes}")
        if min(self.damping.values) < 0.0:
            raise ValueError(f"damping ratios must not be negative, got {self.damping.values}")
        return self

    @classmethod
    def ph4100c(cls, mesh: str = "study") -> Self:
        """Middle and front shoes of the S-paper: steel, modal damping 0.5 % up to 1 kHz.

        The damping ratio follows the paper's curve: 0.005 up to 1000 Hz, a STEP to 1 at 10 kHz.
        """
        return cls(
            shoes=(6, 7, 8, 11, 12, 13),
            mesh=mesh,
            youngs_modulus=200e9,
            poissons_ratio=0.3,
            density=7847.25,
            fixed_modes=10,
            damping=StepProfile(times=(1000.0, 10000.0), values=(0.005, 1.0)),
        )
