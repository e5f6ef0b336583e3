"""Scales of pictures: round ones that make things visible and that all pictures of a run share."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.placement import greatest_shoe_force, instant, unloaded_level
from exudyn_crawler.views.undercarriage import acting

MEGA = 1e6
LONGEST_OF_SHOE, LONGEST_OF_PAIR = 0.7, 0.4
"""m, lengths at which the greatest contact force on a shoe and of a single contact or tread are drawn."""
DEEPEST = 0.25
"""m that the greatest displacement of the ground is drawn at most."""
BENT = 0.04
"""m, length at which the greatest elastic displacement is drawn at most."""

MARGIN = 0.6
"""m that are drawn before and behind the track."""


def round_down(value: float) -> float:
    """Greatest of 1, 2, 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12)))


def round_up(value: float) -> float:
    """Least of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(power * min(step for step in steps if step * power >= value * (1.0 - 1e-12)))


def drawn_scale(values: ArrayLike, length: float) -> float:
    """Round factor that draws the greatest magnitude of `values` at most `length` long; 1 if all are zero."""
    greatest = float(np.abs(values).max(initial=0.0))
    return round_down(length / greatest) if greatest > 0.0 else 1.0


def ground_scale(history: History) -> float:
    """Round magnification that makes the ground's displacements visible."""
    return max(1.0, drawn_scale(history.unit_heave.values - unloaded_level(history.case), DEEPEST))


def shown_length(history: History) -> tuple[float, float]:
    """Least and greatest x to be drawn, m: what shoes reach over the run, and a margin."""
    x = history.position.sel(axis="x")
    low, high = history.case.shoe.footprint[:2]
    return float(x.min()) + low - MARGIN, float(x.max()) + high + MARGIN


def shoe_force_scale(history: History) -> float:
    """M that are drawn for 1 N of the contact force on a shoe; 0 if there is none in the whole run."""
    return _length_a_newton(LONGEST_OF_SHOE, greatest_shoe_force(history))


@dataclass(frozen=True)
class Scales:
    """What all stress pictures of a run have in common.

    Attributes
    ----------
    stress : float
        Stress at the end of the colours, Pa.
    displacement : float
        Magnification of the elastic displacement.
    pair_force, shoe_force : float
        m that are drawn for 1 N of a single contact or tread, and of all contacts of a shoe.
    """

    stress: float
    displacement: float
    pair_force: float
    shoe_force: float

    @classmethod
    def of(cls, stress: xr.Dataset, history: History) -> Self:
        """Scales that fit all chosen times of a stress dataset."""
        surface = np.unique(stress.triangle.values)
        greatest = float(stress.frame_von_mises.isel(node=surface).max())
        pairs = [acting(instant(history, float(time)))[1] for time in stress.frame]
        longest = max(
            (float(np.linalg.norm(forces, axis=1).max(initial=0.0)) for forces in pairs), default=0.0
        )
        return cls(
            stress=round_up(greatest) if greatest > 0.0 else MEGA,
            displacement=drawn_scale(stress.frame_displacement.values, BENT),
            pair_force=_length_a_newton(LONGEST_OF_PAIR, longest),
            shoe_force=shoe_force_scale(history),
        )


def _length_a_newton(length: float, force: float) -> float:
    return length / force if force > 0.0 else 0.0
