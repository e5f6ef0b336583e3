"""Front mass and COM of a machine from its lift chart: tipping loads over radii."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.machines.datasheet.sheet import LiftChart


class Fit(NamedTuple):
    """Fit of a lift chart."""

    front: float  # mass of boom, arm and bucket that moves out with the radius, kg
    moment: float  # moment about the tipping line with the front at the swing axis, kg m
    error: float  # greatest relative error of the loads


def fit_of(chart: LiftChart, tipping_line: float) -> Fit:
    """Fit front and moment of a chart by least squares; `tipping_line` is its distance (m) to the swing axis.

    A load T at a radius R tips the machine about the line at x: ``T (R - x) = M - m R``, since the front, of
    mass m, moves out with the radius. A chart prints a share of T (0.75 by ISO 10567, remembered).
    """
    radius = np.array([point.radius for point in chart.points])
    load = np.array([point.load for point in chart.points]) / chart.tipping_share
    turning = load * (radius - tipping_line)
    (front, moment), *_ = np.linalg.lstsq(
        np.column_stack((-radius, np.ones(len(radius)))), turning, rcond=None
    )
    fitted = (moment - front * radius) / (radius - tipping_line)
    return Fit(float(front), float(moment), float(np.abs(fitted / load - 1.0).max()))


def com_ahead(fit: Fit, mass: float, tipping_line: float, reach: float) -> float:
    """Return the COM (m) of a machine ahead of its swing axis, with its front at a reach (m).

    With the front at the axis the moment about the tipping line is ``G (x - x_0)``.
    """
    return tipping_line - fit.moment / mass + fit.front * reach / mass
