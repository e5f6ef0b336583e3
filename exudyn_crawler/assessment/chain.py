"""Tension of a chain: at rest by sag or push, in travel, and what it does to end rollers."""

from typing import NamedTuple

import numpy as np


def tension_of_sag(weight: float, span: float, sag: float, lying: float = 0.0) -> float:
    """Pull (N) of a chain that hangs in a span with a sag: H = w l^2 / (8 f), a parabola.

    `weight` of the chain in N/m, `span` and `sag` in m. At either end half of a rail lies on its support, so
    that the length l that hangs is less than the span by a rail, `lying` (m; derived).
    """
    return weight * (span - lying) ** 2 / (8.0 * sag)


class ChainTension(NamedTuple):
    """Tension of the runs of a chain whose tumbler pulls, N."""

    rest: float
    """At rest."""
    taut: float
    """Of the run that the tumbler pulls on."""
    slack: float
    """Of the run that leaves the tumbler."""


def travel_tension(rest: float, pull: float, mass: float = 0.0, speed: float = 0.0) -> ChainTension:
    """Tension of both runs where the tumbler pulls with a force (N).

    The taut run has the tension at rest and the pull, m v^2 of centrifugal tension in either run (m the
    `mass` of the chain, kg/m, v its speed, m/s). An idler on shims or on a preloaded spring keeps the slack
    run about at rest; where it gives way, the slack run has less and the taut one as much more than that
    (statics of a belt; derived).
    """
    thrown = mass * speed**2
    return ChainTension(rest, rest + abs(pull) + thrown, rest + thrown)


def end_roller_push(tension: float, rise: float, run: float) -> float:
    """Force (N) by which a run that rises to an end wheel presses its last roller and unloads its wheel.

    T sin(atan(rise / run)), the run rising by `rise` over `run`, m (statics).
    """
    return tension * float(np.sin(np.arctan2(rise, run)))
