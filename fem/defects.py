"""Casting defects against cycles of stress: fatigue limit of small ones, growth of larger ones to a crack.

A defect counts by sqrt(area), the root of its area seen along the stress. Up to about 1 mm its fatigue limit
is Murakami's (Y. Murakami, Metal Fatigue, 2002, section 6). Beyond, it grows as a surface crack by the
simplified law of BS 7910 for steels in air (yield up to 700 MPa; mean plus two standard deviations, 97.7 %
survive), da/dN = 5.21e-13 mm (dK in N/mm^1.5)^3 above a threshold of 63 to 170 N/mm^1.5, which the IIW
recommendations have too; dK is the whole range, also with negative stress ratios. Both as others quote them.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fem.fatigue import SNCurve
from fem.mesh import Floats

SMALL = 1e-3
"""m, sqrt(area) up to which Murakami's limit holds."""
GEOMETRY = 0.65
"""Of a surface defect: stress intensity over stress sqrt(pi sqrt(area)) (Murakami)."""
DEPTHS = np.sqrt(0.5 * np.pi)
"""sqrt(area) of a half disc over its depth, of which the law is."""
MM15 = 1e6 * 1e-3**0.5
"""Pa m^0.5 in 1 N/mm^1.5."""
RATE, EXPONENT = 5.21e-13 * 1e-3 / MM15**3, 3.0
"""m a cycle over (Pa m^0.5)^3."""


class Defect(NamedTuple):
    """Surface defect of a casting.

    Attributes
    ----------
    size : float
        sqrt(area), m.
    hardness : float
        Vickers (HV).
    crack : float
        sqrt(area) of what counts as a crack, m.
    """

    size: float
    hardness: float
    crack: float


def murakami_limit(size: float, hardness: float, ratio: float | Floats = -1.0) -> float | Floats:
    """Amplitude (Pa) that a surface defect of sqrt(area) `size` (m) bears for ever at a stress ratio."""
    alpha = 0.226 + 1e-4 * hardness
    return 1.43e6 * (hardness + 120.0) / (1e6 * size) ** (1.0 / 6.0) * (0.5 * (1.0 - ratio)) ** alpha


def equivalent_amplitude(hardness: float, amplitude: Floats, mean: Floats) -> Floats:
    """Amplitudes at R = -1 that a defect bears like those with these means.

    Means below zero count by the tangent at R = -1 down to R = -inf, which is on the safe side.
    """
    alpha, part = 0.226 + 1e-4 * hardness, np.maximum(mean / amplitude, -1.0)
    return amplitude * np.where(part > 0.0, (1.0 + np.maximum(part, 0.0)) ** alpha, 1.0 + alpha * part)


def threshold(ratio: float | Floats) -> Floats:
    """Range of stress intensity (Pa m^0.5) up to which cracks do not grow at a stress ratio."""
    return MM15 * np.clip(170.0 - 214.0 * np.asarray(ratio), 63.0, 170.0)


class CycleStage(NamedTuple):
    """Cycles between two stresses each (n,), Pa, how often each happens, and for how long."""

    begin: Floats
    end: Floats
    rate: Floats
    lasts: float = np.inf


def growth(
    low: Floats, high: Floats, rate: Floats, start: float, end: float, lasts: float = np.inf
) -> tuple[float, float]:
    """Time that a crack takes to grow, at most `lasts`, and its sqrt(area) (m) then.

    Infinite if it never grows so far; in the unit of time of which `rate` are cycles.

    Parameters
    ----------
    low, high : array (n,)
        Ends of the cycles, Pa; those that stay in compression do nothing.
    rate : array (n,)
        How often each happens.
    start, end : float
        sqrt(area), m.
    """
    opens = (high > 0.0) & (high > low)
    low, high, rate = (np.broadcast_to(one, opens.shape)[opens] for one in (low, high, rate))
    stress = high - low
    grows_from = (threshold(low / high) / (GEOMETRY * stress)) ** 2 / np.pi
    order = np.argsort(grows_from)
    sizes, sums = grows_from[order], np.cumsum((rate * stress**EXPONENT)[order])
    if not len(sizes) or sizes[0] > start or end <= start:
        return (lasts, start) if end > start else (0.0, start)
    edges = np.concatenate(([start], sizes[(sizes > start) & (sizes < end)], [end]))
    each = DEPTHS * RATE * (GEOMETRY * np.sqrt(np.pi)) ** EXPONENT
    speed = each * sums[sizes.searchsorted(edges[:-1], "right") - 1]
    # of d size / dt = speed size^1.5, exactly
    until = np.cumsum(2.0 / speed * (edges[:-1] ** -0.5 - edges[1:] ** -0.5))
    if until[-1] <= lasts:
        return float(until[-1]), end
    k = int(until.searchsorted(lasts, "right"))
    rest = lasts - (until[k - 1] if k else 0.0)
    return lasts, float((edges[k] ** -0.5 - 0.5 * speed[k] * rest) ** -2)


def defect_life(defect: Defect, curve: SNCurve, stages: Sequence[CycleStage], survival: float) -> float:
    """Time until a defect is a crack under cycles of stages, one after the other; infinite if it never is.

    Up to `SMALL` by Miner's rule with the curve, without a casting factor, whose strength is Murakami's limit
    if that is less; beyond by growth, whatever the survival. The curve's residual stress adds to both.
    """
    limit = float(murakami_limit(defect.size, defect.hardness))
    own = replace(curve, strength=min(curve.strength, limit), residual_stress=0.0)
    time, size, damage = 0.0, defect.size, 0.0
    for begin, end, rate, lasts in stages:
        low = np.minimum(begin, end) + curve.residual_stress
        high = np.maximum(begin, end) + curve.residual_stress
        if defect.size > SMALL:
            spent, size = growth(low, high, rate, size, defect.crack, lasts)
        else:
            moves = high > low
            amplitude, mean = 0.5 * (high - low)[moves], 0.5 * (high + low)[moves]
            equal = equivalent_amplitude(defect.hardness, amplitude, mean)
            each = own.damage(equal, np.zeros_like(equal), (survival,))[0]
            speed = float(each @ np.broadcast_to(rate, moves.shape)[moves])
            spent = min(lasts, (1.0 - damage) / speed) if speed > 0.0 else lasts
            damage = 1.0 if spent < lasts else damage + speed * spent
        time += spent
        if size >= defect.crack or damage >= 1.0:
            break
    return time
