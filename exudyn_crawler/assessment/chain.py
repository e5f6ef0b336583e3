"""Chain tension at rest by sag or pretension, chain tension in travel, and the load on end rollers."""

from typing import NamedTuple

import numpy as np


def tension_of_sag(weight: float, span: float, sag: float, lying: float = 0.0) -> float:
    """Return the tension (N) of a chain span that sags: H = w l^2 / (8 f), a parabola.

    `weight` of the chain in N/m, `span` and `sag` in m. Half a rail lies on its support at either end, so
    that the hanging length l is the span less one rail, `lying` (m; derived).
    """
    return weight * (span - lying) ** 2 / (8.0 * sag)


class ChainTension(NamedTuple):
    """Tension of the chain runs when the tumbler pulls, N."""

    rest: float
    """Tension at rest."""
    taut: float
    """Tension of the run that the tumbler pulls."""
    slack: float
    """Tension of the run that leaves the tumbler."""


def travel_tension(rest: float, pull: float, mass: float = 0.0, speed: float = 0.0) -> ChainTension:
    """Return the tension of both runs when the tumbler pulls with a force (N).

    The taut run has the tension at rest plus the pull. Both runs add the centrifugal tension m v^2 (m the
    `mass` of the chain, kg/m, v its speed, m/s). An idler on shims or on a preloaded spring keeps the slack
    run near its tension at rest. If the idler gives way, both runs lose the same tension (statics of a belt;
    derived).
    """
    thrown = mass * speed**2
    return ChainTension(rest, rest + abs(pull) + thrown, rest + thrown)


def end_roller_push(tension: float, rise: float, run: float) -> float:
    """Return the force (N) of a run, rising to an end wheel, on its last roller; it unloads the wheel.

    The force is T sin(atan(rise / run)) for a run that rises by `rise` over `run`, m (statics).
    """
    return tension * float(np.sin(np.arctan2(rise, run)))
