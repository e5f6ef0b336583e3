"""Flexible shoes of a track."""

from typing import Self

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Density, Errors, Parameters, Three, option, quantity
from exudyn_crawler.case.parameters.drive import StepProfile

PAPER_DAMPING = StepProfile(times=ph4100c.DAMPING_FREQUENCIES, values=ph4100c.DAMPING_RATIOS)
"""Modal damping ratio over frequency of the S-paper: 0.005 up to 1000 Hz, a STEP to 1 at 10 kHz."""
ADAMS_DAMPING = StepProfile(times=(99.0, 101.0, 990.0, 1010.0), values=(0.01, 0.1, 0.1, 1.0))
"""ADAMS' own default: 1 % below 100 Hz, 10 % up to 1000 Hz, critical above; its jumps are 2 % wide here."""

CONSTRAINT_MODES = 24  # six of each of the four joint centres
RIGID_MODES = 6


class FlexibleShoes(Parameters):
    """Which shoes are flexible, and the finite-element model that all of them share."""

    shoes: tuple[int, ...] = option("numbers of the flexible shoes", min_length=1)
    mesh: str = option("coarse, study or fine, or the path of a mesh with the same surfaces")
    youngs_modulus: float = quantity("Pa", "E", (5e10, 5e11), ge=1.0, le=1e15)
    poissons_ratio: float = quantity("1", "nu", (0.0, 0.45), gt=-1, lt=0.5)
    density: Density = quantity("kg/m3", "density", (1000.0, 2e4))
    fixed_modes: int = quantity("1", "fixed-interface modes of the basis that is integrated", ge=0, le=10_000)
    recovered_modes: int = quantity("1", "fixed-interface modes that stress is made of", ge=0, le=10_000)
    load_surface: str = option(
        "that bears the machine load: whole top, plateau (no wings), rails, or one of the mesh", "whole top"
    )
    com_node: Three = quantity(
        "m", "place in the shoe's frame whose nearest mesh node a drive may move", default=(0.0, 0.0, 0.0)
    )
    load_mode: bool = option(
        "whether both bases have the static answer to the machine load, which modes lack else", False
    )
    static_fields: bool = option(
        "whether stress has static answers to all loads: left-out modes lack their inertia alone", True
    )
    highest_frequency: float | None = quantity(
        "Hz", "above which integrated modes are left out", (50.0, 1e6), gt=0, le=1e12, default=None
    )
    modes: tuple[int, ...] | None = option("numbers (from 1) of the modes that are integrated", None)
    damping: StepProfile = quantity("1", "modal damping ratio over frequency (Hz, as times)", (0.0, 2.0))

    def _errors(self) -> Errors:
        if list(self.shoes) != sorted(set(self.shoes)):
            yield f"shoes must be different numbers in rising order, got {self.shoes}"
        if min(self.damping.values) < 0.0:
            yield f"damping ratios must not be negative, got {self.damping.values}"
        most = self.recovered_modes
        if self.fixed_modes > most:
            yield f"fixed_modes must not exceed recovered_modes = {most}, got {self.fixed_modes}"
        if self.modes is None:
            return
        if self.highest_frequency is not None:
            yield "choose modes by number or by highest_frequency, not by both"
        if not self.modes or list(self.modes) != sorted(set(self.modes)):
            yield f"modes must be different numbers in rising order, got {self.modes}"
        if self.modes[0] < 1 or self.modes[-1] > self.mode_count:
            yield f"modes must be in 1..{self.mode_count}, got {self.modes}"

    @property
    def mode_count(self) -> int:
        """Modes of the integrated basis: 24 constraint modes and the fixed-interface ones, less 6 rigid."""
        return CONSTRAINT_MODES - RIGID_MODES + self.fixed_modes + int(self.load_mode)

    @classmethod
    def ph4100c(cls, mesh: str = "study") -> Self:
        """Middle and front shoes of the S-paper: steel, with its modal damping."""
        return cls(**ph4100c.FLEXIBLE_SHOES, mesh=mesh, damping=PAPER_DAMPING)
