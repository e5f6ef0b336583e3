"""Life of a wearing part from readings by least squares, with an interval.

The scatter of readings (percent worn) counts as independent, normal and alike. The interval of a life has all
lives whose sum of squares, with the best other parameters, is at most S (1 + t^2 / f): S is the least sum, f
the number of readings less that of parameters, t Student's. For one coefficient of a power law this is the
exact interval of linear least squares.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize, stats

from exudyn_crawler.results.wear.laws import WORN_OUT, PowerLaw, WearLaw

CONFIDENCE = 0.9
"""Confidence of all intervals."""
EXPONENTS = 0.5, 4.0
"""Range of a fitted exponent. Chosen here."""
FEWEST_FREE = 4
"""Least number of inspections for a fitted exponent. Chosen here."""
LIVES = 1e-3, 1e4
"""Range of lives, in greatest times of readings. Chosen here."""
TRIED = 150
"""Number of lives of the first search."""
DISTINCT = 0.05
"""Least ratio of singular values of the hours in different runs that tells their coefficients apart. Chosen
here."""


@dataclass(frozen=True)
class LifeFit:
    """Life of a part: time, or work, from new to 100 % worn."""

    law: WearLaw
    life: float
    low: float
    """Lower end of the interval; NaN if the readings give none."""
    high: float
    """Upper end; infinite if the readings exclude no long life."""
    scatter: float
    """Standard deviation of the readings about the law, percent worn; NaN if unknown."""
    readings: int

    def percent(self, used: np.ndarray, life: float | None = None) -> np.ndarray:
        """Return percent worn at times or works, by the law with the fitted life or another one."""
        return self.law.percent(np.asarray(used, dtype=float) / (self.life if life is None else life))

    def scaled(self, factor: float) -> "LifeFit":
        """Return the fit with times in another unit, such as work in place of hours."""
        return replace(self, life=factor * self.life, low=factor * self.low, high=factor * self.high)


def fit_life(
    used: np.ndarray,
    percent: np.ndarray,
    law: WearLaw | None,
    error: float | None = None,
) -> LifeFit:
    """Fit the life of a part to readings.

    Parameters
    ----------
    used : ndarray
        Times or works since the part was new, positive: array (readings,).
    percent : ndarray
        Percent worn: array (readings,).
    law : WearLaw, optional
        Form of the law; None: power law with a fitted exponent.
    error : float, optional
        Known standard deviation of a reading, percent worn. Default: from the scatter of the readings.

    Raises
    ------
    ValueError
        If no wear was measured, or if there are too few inspections to fit an exponent.
    """
    if not np.sum(percent * used) > 0.0:
        raise ValueError("readings must show wear, got none: hours cannot be forecast yet")
    times = len(np.unique(used))
    if law is None and times < FEWEST_FREE:
        raise ValueError(
            f"a fitted exponent needs at least {FEWEST_FREE} inspections at different hours, got {times}"
        )
    best = _best_law(used, percent) if law is None else lambda _life: law

    def squares(log: float) -> float:
        life = math.exp(log)
        return float(np.sum((percent - best(life).percent(used / life)) ** 2))

    middle = _least(squares, *(math.log(limit * float(used.max())) for limit in LIVES))
    life = math.exp(middle)
    parameters = 2 if law is None else 1
    freedom = len(used) - parameters
    scatter = math.sqrt(squares(middle) / freedom) if freedom > 0 else math.nan
    if error is not None:
        excess = (error * float(stats.norm.ppf(0.5 + 0.5 * CONFIDENCE))) ** 2
    elif freedom > 0:
        excess = (scatter * float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom))) ** 2
    else:
        return LifeFit(best(life), life, math.nan, math.nan, math.nan, len(used))
    most = squares(middle) + excess
    ends = (_crossing(squares, middle, most, step) for step in (-1.0, 1.0))
    low, high = (math.exp(end) if math.isfinite(end) else math.inf for end in ends)
    return LifeFit(best(life), life, low, high, scatter if error is None else error, len(used))


def _best_law(used: np.ndarray, percent: np.ndarray) -> Callable[[float], WearLaw]:
    """Return the function from a life to the power law that fits best with it."""

    def best(life: float) -> WearLaw:
        def squares(exponent: float) -> float:
            return float(np.sum((percent - PowerLaw(exponent).percent(used / life)) ** 2))

        return PowerLaw(float(optimize.minimize_scalar(squares, bounds=EXPONENTS, method="bounded").x))

    return best


def _least(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the place of the least value between two places: the best of a row of places, refined."""
    places = np.linspace(low, high, TRIED)
    best = int(np.argmin([function(place) for place in places]))
    ends = float(places[max(best - 1, 0)]), float(places[min(best + 1, TRIED - 1)])
    found = optimize.minimize_scalar(function, bounds=ends, method="bounded", options={"xatol": 1e-10})
    return float(found.x)


def _crossing(function: Callable[[float], float], middle: float, level: float, step: float) -> float:
    """Return the place beyond `middle` in the sense of a step at which a function rises above a level.

    Infinite if it does not.
    """
    if level <= function(middle):
        return middle
    far = middle + step
    while function(far) < level:
        far += step
        if abs(far - middle) > -math.log(LIVES[0]) + math.log(LIVES[1]):
            return math.inf
    return float(optimize.brentq(lambda place: function(place) - level, far - step, far))


@dataclass(frozen=True)
class MixedFit:
    """Lives of a part in different runs of a duty, each as if it were alone."""

    runs: tuple[str, ...]
    law: WearLaw
    rates: np.ndarray
    """Reciprocals of the lives, (runs,), 1/h."""
    covariance: np.ndarray
    """(runs, runs), 1/h2."""
    freedom: float
    """Degrees of freedom of the scatter; infinite if the error of a reading is known."""
    readings: int
    scatter: float
    """Standard deviation of the readings about the law, or their known error, percent worn."""

    def life(self, shares: Sequence[float]) -> LifeFit:
        """Return the life in a mix of the runs, by their shares of the hours."""
        mix = np.array(shares, dtype=float)
        rate = float(mix @ self.rates)
        half = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, self.freedom)) * math.sqrt(
            mix @ self.covariance @ mix
        )
        high = 1.0 / (rate - half) if rate > half else math.inf
        return LifeFit(self.law, 1.0 / rate, 1.0 / (rate + half), high, self.scatter, self.readings)


def fit_by_run(
    hours: np.ndarray, percent: np.ndarray, law: WearLaw, runs: Sequence[str], error: float | None = None
) -> MixedFit:
    """Fit a coefficient for each run of a duty to readings.

    Wear adds up by the used fractions of the life in each run.

    Parameters
    ----------
    hours : ndarray
        Hours in each run since the part was new: array (readings, runs).
    percent : ndarray
        Percent worn: array (readings,).
    law : WearLaw
        Form of the law.
    runs : sequence of str
        Names of the runs.
    error : float, optional
        Known standard deviation of a reading, percent worn. Default: from the scatter of the readings.

    Raises
    ------
    ValueError
        If there are not more readings than runs, or if the shares of the runs hardly vary between
        inspections.
    """
    count = len(runs)
    named = " and ".join(runs)
    if len(percent) <= count:
        raise ValueError(
            f"coefficients of {named} need more than {count} readings at different hours, got {len(percent)}"
        )
    sizes = np.linalg.svd(hours / np.linalg.norm(hours, axis=1)[:, None], compute_uv=False)
    if sizes[-1] < DISTINCT * sizes[0]:
        shares = hours / hours.sum(axis=1)[:, None]
        spans = ", ".join(
            f"{name} {column.min():.3g} to {column.max():.3g}"
            for name, column in zip(runs, shares.T, strict=True)
        )
        raise ValueError(
            f"coefficients of {named} cannot be told apart: their shares of the hours hardly vary between "
            f"inspections, got {spans}; fit one coefficient for the mix"
        )

    def worn(_place: np.ndarray, *logs: float) -> np.ndarray:
        return law.percent(hours @ np.exp(logs))

    alike = fit_life(hours.sum(axis=1), percent, law)
    start = np.full(count, -math.log(alike.life))
    places = np.arange(len(percent))
    known = None if error is None else np.full(len(percent), error)
    logs, covariance = optimize.curve_fit(
        worn, places, percent, start, sigma=known, absolute_sigma=known is not None
    )
    rates = np.exp(logs)
    freedom: float = math.inf
    if error is None:
        freedom = len(percent) - count
        error = math.sqrt(float(np.sum((percent - law.percent(hours @ rates)) ** 2)) / freedom)
    spread = covariance * np.outer(rates, rates)
    return MixedFit(tuple(runs), law, rates, spread, freedom, len(percent), error)


def wear_coefficient(fit: LifeFit) -> float:
    """Return Komatsu's coefficient a of W = a x^k, %/h^k; NaN for another law."""
    return WORN_OUT / fit.life**fit.law.exponent if isinstance(fit.law, PowerLaw) else math.nan
