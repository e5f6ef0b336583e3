"""Laws of wear: percent worn over the used fraction of a life.

The used fraction u is the time, or the work, since the part was new over that at which it is 100 % worn. So
the life is the only unknown of a law with a given form.
"""

from typing import NamedTuple, Protocol

import numpy as np

WORN_OUT = 100.0
"""Percent worn at the limit."""


class WearLaw(Protocol):
    """Form of the growth of wear."""

    def percent(self, used: np.ndarray) -> np.ndarray:
        """Return percent worn at used fractions of the life."""

    def used(self, percent: float) -> float:
        """Return the used fraction of the life at a percent worn."""

    @property
    def words(self) -> str:
        """Formula for reading."""


class PowerLaw(NamedTuple):
    """Komatsu's law W = a x^k, with x in hours and W = 100 % at the life."""

    exponent: float

    def percent(self, used: np.ndarray) -> np.ndarray:
        """Return percent worn, 100 u^k, at used fractions of the life."""
        return WORN_OUT * np.asarray(used, dtype=float) ** self.exponent

    def used(self, percent: float) -> float:
        """Return the used fraction of the life at a percent worn."""
        return float((max(percent, 0.0) / WORN_OUT) ** (1.0 / self.exponent))

    @property
    def words(self) -> str:
        """Formula for reading."""
        return f"W = a x^{self.exponent:.3g}"


class TwoRates(NamedTuple):
    """One rate of wear in the hardened case, and a greater one in the metal below it.

    Caterpillar's Custom Track Service Handbook has a factor of about three for an idler.
    """

    case: float
    """Percent worn at which the case ends."""
    factor: float
    """Rate below the case over that in it."""

    @property
    def _whole(self) -> float:
        """Life in units of the time in which 1 % is worn at the rate of the case."""
        return self.case + (WORN_OUT - self.case) / self.factor

    def percent(self, used: np.ndarray) -> np.ndarray:
        """Return percent worn at used fractions of the life."""
        worn = np.asarray(used, dtype=float) * self._whole
        return np.where(worn <= self.case, worn, self.case + self.factor * (worn - self.case))

    def used(self, percent: float) -> float:
        """Return the used fraction of the life at a percent worn."""
        below = max(percent - self.case, 0.0) / self.factor
        return float((min(max(percent, 0.0), self.case) + below) / self._whole)

    @property
    def words(self) -> str:
        """Formula for reading."""
        return f"two rates, {self.factor:.3g} times beyond {self.case:.3g} %"
