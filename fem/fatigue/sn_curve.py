"""Fatigue strength of a point: S-N curve, mean stress, Miner's rule.

All formulas are those of pyLife. Values needed thousands of times are cached.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np
import pandas as pd

from fem.body.mesh import Floats

if TYPE_CHECKING:
    from pylife.materiallaws import WoehlerCurve

Miner = Literal["elementary", "haibach", "original"]
MINERS: tuple[Miner, ...] = ("elementary", "haibach", "original")
"""Miner rules for cycles below the knee: damage by the slope k, by the slope 2 k - 1, or none."""
HAIGH_CORNERS = np.array([-2.0, -1.0, 1.0, 3.0, 4.0])
"""Corners of the Haigh diagram, mean stress over amplitude: R > 1, R = -inf, R = 0, R = 0.5 and beyond."""


@dataclass(frozen=True)
class SNCurve:
    """S-N curve of stress amplitudes at R = -1, with the effects of mean stress and survival.

    Parameters
    ----------
    strength : float
        Amplitude in Pa at the knee.
    slope : float
        Exponent k of ``N = knee (amplitude / strength)^-k``.
    knee : float
        Cycles at the knee.
    mean_sensitivity : float
        M of the FKM guideline, in [0, 1). Between R = -inf and 0 a mean stress counts as M times an
        amplitude; up to R = 0.5 a third of that; beyond nothing more.
    scatter : float
        Ratio of the strength at 10 % survival to that at 90 %, at least 1.
    survival : float
        Survival probability of the curve, inside (0, 1).
    miner : str
        One of `MINERS`.
    residual_stress : float
        Residual stress, Pa; it adds to the mean of every cycle.

    Raises
    ------
    ValueError
        If a value is out of its range.
    """

    strength: float
    slope: float
    knee: float
    mean_sensitivity: float = 0.0
    scatter: float = 1.0
    survival: float = 0.5
    miner: Miner = "elementary"
    residual_stress: float = 0.0

    def __post_init__(self) -> None:
        for name in ("strength", "knee"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        for name in ("slope", "scatter"):
            if not getattr(self, name) >= 1.0:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)}")
        if not 0.0 <= self.mean_sensitivity < 1.0:
            raise ValueError(f"mean_sensitivity must lie in [0, 1), got {self.mean_sensitivity}")
        check_survivals((self.survival,))
        if self.miner not in MINERS:
            raise ValueError(f"miner must be one of {MINERS}, got {self.miner!r}")

    def strength_at(self, survival: float) -> float:
        """Return the amplitude in Pa at the knee for another survival; the knee's cycles stay the same."""
        return _strength_at(self, survival)

    @property
    def steepest(self) -> float:
        """Greatest slope of the curve: a stress error of x changes the life by at most (1 + x)^slope.

        This neglects stress that crosses the knee: the original rule counts nothing below it.
        """
        return 2.0 * self.slope - 1.0 if self.miner == "haibach" else self.slope

    @property
    def _woehler(self) -> "WoehlerCurve":
        """S-N curve in pyLife, without residual stress."""
        return _woehler_of(replace(self, residual_stress=0.0))

    def equivalent(self, amplitude: Floats, mean: Floats) -> Floats:
        """Return amplitudes at R = -1 with the same damage as cycles of positive amplitudes and their means.

        The transform is linear in both between the corners of the Haigh diagram. Interpolation between
        pyLife's values at the corners is therefore exact.
        """
        return amplitude * np.interp(mean / amplitude, HAIGH_CORNERS, self._mean_factors)

    @property
    def _mean_factors(self) -> Floats:
        """Factors of an amplitude at the corners of the Haigh diagram."""
        return _mean_factors_of(self.mean_sensitivity)

    def damage(self, amplitude: Floats, mean: Floats, survivals: Sequence[float]) -> Floats:
        """Return the damage (s, n) of cycles of positive amplitudes (n,) and their means, by survival."""
        equivalent = self.equivalent(amplitude, mean + self.residual_stress)
        scales = [self.strength / self.strength_at(survival) for survival in survivals]
        over = np.multiply.outer(scales, equivalent) / self.strength
        slopes = np.where(over < 1.0, _slope_below(self), self.slope)
        return over**slopes / self.knee

    def harmless(self, damage: float, survival: float) -> float:
        """Return the amplitude in Pa below which no cycle of any mean exceeds a positive damage."""
        scale = self.strength_at(survival) / self.strength
        load = float(self._woehler.load(np.array(1.0 / damage)))
        return scale * load / float(self._mean_factors.max())


@lru_cache(maxsize=64)
def _woehler_of(curve: SNCurve) -> "WoehlerCurve":
    # imported here, since pyLife takes 20 MB and runs without a life do not need it
    from pylife.materiallaws import WoehlerCurve

    values = {"k_1": curve.slope, "ND": curve.knee, "SD": curve.strength, "TS": curve.scatter}
    woehler = WoehlerCurve(pd.Series(values | {"failure_probability": 1.0 - curve.survival}))
    return getattr(woehler, f"miner_{curve.miner}")()


@lru_cache(maxsize=64)
def _slope_below(curve: SNCurve) -> float:
    return float(curve._woehler.k_2)


@lru_cache(maxsize=64)
def _mean_factors_of(sensitivity: float) -> Floats:
    from pylife.strength.meanstress import HaighDiagram

    slopes = {"M0": sensitivity, "M1": sensitivity / 3.0, "M2": 0.0, "M3": 0.0, "M4": 0.0}
    diagram = HaighDiagram.five_segment(pd.Series(slopes | {"R12": 0.5, "R23": 0.9}))
    cycles = pd.DataFrame({"range": np.full(len(HAIGH_CORNERS), 2.0), "mean": HAIGH_CORNERS})
    return 0.5 * diagram.transform(cycles, -1.0)["range"].to_numpy()


@lru_cache(maxsize=64)
def _strength_at(curve: SNCurve, survival: float) -> float:
    return float(curve._woehler.transform_to_failure_probability(1.0 - survival).SD)


def check_survivals(survivals: Sequence[float]) -> None:
    """Check that survival probabilities are given and that all lie inside (0, 1).

    Raises
    ------
    ValueError
    """
    if not survivals or not all(0.0 < survival < 1.0 for survival in survivals):
        raise ValueError(f"survival must be inside (0, 1), got {list(survivals)}")
