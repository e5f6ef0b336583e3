"""Casting defects under stress cycles: growth of a defect of any size to a crack.

The size of a defect is sqrt(area), the root of its area projected along the stress. It grows as a surface
crack from its first cycle, by the two-stage law of BS 7910 for steels in air (yield up to 700 MPa). The law's
scatter lies between its mean and its mean plus two standard deviations. A defect is dormant up to a stress
that falls with its size as in Kitagawa and Takahashi's diagram. The limit is the lesser of two: Murakami's
limit of small defects (Y. Murakami, Metal Fatigue, 2002, section 6), and the guideline's threshold of cracks,
63 to 170 N/mm^1.5. Stress intensity ranges are whole ranges, also at negative stress ratios. Values are from
secondary sources.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from fem.body.mesh import Floats
from fem.fatigue.sn_curve import SNCurve

GEOMETRY = 0.65
"""Geometry factor of a surface defect: stress intensity over stress sqrt(pi sqrt(area)) (Murakami)."""
DEPTHS = np.sqrt(0.5 * np.pi)
"""Ratio of sqrt(area) of a half disc to its depth; the growth law is in terms of the depth."""
MM15 = 1e6 * 1e-3**0.5
"""Pa m^0.5 in 1 N/mm^1.5."""
STAGES = (
    ((8.16, 1.21e-26, 4.37e-26), (2.88, 3.98e-13, 6.77e-13)),
    ((5.10, 4.80e-18, 2.10e-17), (2.88, 5.86e-13, 1.29e-12)),
)
"""Growth laws: exponent, and growth in mm per cycle at 1 N/mm^1.5, mean and with two standard deviations. The
first row holds below R = 0.5, the second from 0.5; each has two stages, and the slower one counts."""
HIGH_RATIO = 0.5
SIZES = 257  # least number of sizes between which a crack's growth is integrated


class Defect(NamedTuple):
    """Surface defect of a casting.

    Attributes
    ----------
    size : float
        sqrt(area), m.
    hardness : float
        Vickers hardness (HV).
    crack : float
        sqrt(area) above which a defect counts as a crack, m.
    """

    size: float
    hardness: float
    crack: float


def murakami_limit(size: float, hardness: float, ratio: float | Floats = -1.0) -> Floats:
    """Return the amplitude (Pa) that a surface defect of sqrt(area) `size` (m) endures at a stress ratio."""
    alpha = 0.226 + 1e-4 * hardness
    part = 0.5 * (1.0 - np.asarray(ratio))
    return 1.43e6 * (hardness + 120.0) / (1e6 * size) ** (1.0 / 6.0) * part**alpha


def threshold(ratio: float | Floats) -> Floats:
    """Return the stress intensity range (Pa m^0.5) below which cracks do not grow at a stress ratio."""
    return MM15 * np.clip(170.0 - 214.0 * np.asarray(ratio), 63.0, 170.0)


def growing_size(hardness: float, stress: Floats, ratio: Floats) -> Floats:
    """Return the sqrt(area) (m) above which a defect grows by cycles of stress (Pa) at stress ratios."""
    crack = (threshold(ratio) / (GEOMETRY * stress)) ** 2 / np.pi
    # Murakami's limit falls with the sixth root; ratios below -1 count as -1, on the safe side
    small = 1e-6 * (2.0 * murakami_limit(1e-6, hardness, np.maximum(ratio, -1.0)) / stress) ** 6
    return np.minimum(crack, small)


@lru_cache(maxsize=64)
def growth_law(of_high_ratio: bool, survival: float) -> tuple[tuple[float, float], ...]:
    """Return exponent and m per cycle at 1 Pa m^0.5 of both stages, for a survival probability."""
    return tuple(
        (exponent, 1e-3 * mean * (upper / mean) ** (0.5 * ndtri(survival)) / MM15**exponent)
        for exponent, mean, upper in STAGES[of_high_ratio]
    )


class CycleStage(NamedTuple):
    """Cycles between two stresses each (n,), Pa, with the rate of each and the duration of the stage."""

    begin: Floats
    end: Floats
    rate: Floats
    lasts: float = np.inf


def growth(
    defect: Defect, low: Floats, high: Floats, rate: Floats, survival: float, lasts: float = np.inf
) -> tuple[float, float]:
    """Return the time until a defect is a crack, at most `lasts`, and its sqrt(area) (m) at that time.

    The unit of time is that of `rate`, cycles per time. The time is `lasts`, infinite by default, if the
    defect never becomes a crack.

    Parameters
    ----------
    low, high : array (n,)
        Ends of the cycles, Pa; cycles wholly in compression have no effect.
    rate : array (n,)
        Rate of each cycle.
    survival : float
        Survival probability: fraction of the material with slower crack growth.
    """
    start = defect.size
    end = defect.crack
    opens = (high > 0.0) & (high > low) & (rate > 0.0)
    low, high, rate = (np.broadcast_to(values, opens.shape)[opens] for values in (low, high, rate))
    stress = high - low
    ratio = low / high
    wakes = growing_size(defect.hardness, stress, ratio)
    if end <= start:
        return 0.0, start
    if not (wakes <= start).any():
        return lasts, start
    stages = []  # exponent m, sizes at which cycles come or go, speeds: d size / dt over size^(m / 2)
    for of_high_ratio in set((ratio >= HIGH_RATIO).tolist()):
        group = (ratio >= HIGH_RATIO) == of_high_ratio
        (slow, at_slow), (fast, at_fast) = growth_law(of_high_ratio, survival)
        intensity = GEOMETRY * np.sqrt(np.pi) * stress[group]  # at 1 m
        turns = (at_fast / at_slow) ** (2.0 / (slow - fast)) / intensity**2
        turns = np.maximum(turns, wakes[group])
        each = DEPTHS * rate[group] * at_slow * intensity**slow
        stages.append((slow, np.concatenate((wakes[group], turns)), np.concatenate((each, -each))))
        stages.append((fast, turns, DEPTHS * rate[group] * at_fast * intensity**fast))
    changes = np.concatenate([steps for _, steps, _ in stages])
    inside = changes[(changes > start) & (changes < end)]
    edges = np.unique(np.concatenate((np.geomspace(start, end, SIZES), inside)))
    # two Gauss points of each part, in the logarithm of the size
    middle = 0.5 * np.log(edges[1:] * edges[:-1])
    half = 0.5 * np.log(edges[1:] / edges[:-1])
    sizes = np.exp(middle + np.multiply.outer((-(3.0**-0.5), 3.0**-0.5), half))
    speed = np.zeros_like(sizes)
    for exponent, steps, each in stages:
        order = np.argsort(steps, kind="stable")
        sums = np.concatenate(([0.0], np.cumsum(each[order])))
        speed += sums[steps[order].searchsorted(sizes, "right")] * sizes ** (0.5 * exponent)
    until = np.concatenate(([0.0], np.cumsum((sizes / speed).sum(axis=0) * half)))
    if until[-1] <= lasts:
        return float(until[-1]), end
    return lasts, float(np.exp(np.interp(lasts, until, np.log(edges))))


def defect_life(defect: Defect, curve: SNCurve, stages: Sequence[CycleStage], survival: float) -> float:
    """Return the time until a defect or the sound surface beside it cracks under stages of cycles.

    The surface cracks by Miner's rule with its curve, without a casting factor, the defect by growth. The
    curve's residual stress adds to both. The time is infinite if neither ever cracks.
    """
    time = 0.0
    damage = 0.0
    for begin, end, rate, lasts in stages:
        low = np.minimum(begin, end)
        high = np.maximum(begin, end)
        moves = high > low
        low = low[moves]
        high = high[moves]
        rate = np.broadcast_to(rate, moves.shape)[moves]
        speed = float(curve.damage(0.5 * (high - low), 0.5 * (high + low), (survival,))[0] @ rate)
        sound = (1.0 - damage) / speed if speed > 0.0 else np.inf
        low = low + curve.residual_stress
        high = high + curve.residual_stress
        spent, size = growth(defect, low, high, rate, survival, min(lasts, sound))
        time += spent
        if size >= defect.crack or sound <= lasts:
            break
        damage = damage + speed * spent
        defect = defect._replace(size=size)
    return time
