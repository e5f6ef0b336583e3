"""Settings of the time integration."""

from typing import Self

from pydantic import model_validator

from exudyn_crawler.case.parameters.base import Parameters, quantity


class Solver(Parameters):
    """Implicit generalized-alpha integration; `docs/validation.md` shows what the defaults cost."""

    step: float = quantity("s", "time step", plausible=(1e-5, 0.02), ge=1e-9, le=10, default=2.0e-3)
    quiet_step: float = quantity(
        "s", "longer step, 1 s after the drive went off", plausible=(1e-5, 0.1), ge=1e-9, le=10, default=0.01
    )
    minimum_step: float = quantity("s", "least step tried before giving up", ge=1e-15, le=10, default=1.0e-6)
    residual: float = quantity(
        "N", "rms that ends Newton's method", plausible=(1e-6, 50.0), ge=1e-12, le=1e9, default=0.2
    )
    maximum_iterations: int = quantity(
        "1", "iterations before the step is halved", ge=2, le=10_000, default=40
    )
    spectral_radius: float = quantity(
        "1", "of the integration at infinite frequency: less damps more", gt=0, lt=1, default=0.6
    )
    output_interval: float = quantity(
        "s",
        "time between stored states; every step where it is not longer than one",
        ge=1e-9,
        le=1e9,
        default=2.0e-3,
    )

    checkpoint_interval: float = quantity(
        "s",
        "the integration starts anew from its state at every multiple of this, where a killed run goes on",
        ge=1e-3,
        le=1e9,
        default=1.0,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.minimum_step > self.step:
            raise ValueError(f"minimum_step must not exceed step = {self.step}, got {self.minimum_step}")
        return self
