"""Loads and drive over time, for compiled code."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters.base import StepProfile
from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.laws.impact import step
from exudyn_crawler.ground.rotations import FloatArray


class Profiles(NamedTuple):
    """Quantities over time, joined by cubic STEPs: times (q, k), last ones repeated, and values (q, k)."""

    times: FloatArray
    values: FloatArray


def profiles_of(profiles: Sequence[StepProfile]) -> Profiles:
    """Profiles as arrays."""
    width = max(len(profile.times) for profile in profiles)
    times, values = np.zeros((2, len(profiles), width))
    for row, profile in enumerate(profiles):
        missing = width - len(profile.times)
        times[row] = [*profile.times, *[profile.times[-1]] * missing]
        values[row] = [*profile.values, *[profile.values[-1]] * missing]
    return Profiles(times, values)


@compiled
def values_at(profiles: tuple, time: float, out: FloatArray) -> None:
    """Write the values (q,) of `Profiles` as a plain tuple at a time, s."""
    all_times, all_values = profiles
    for row in range(out.shape[0]):
        times, values = all_times[row], all_values[row]
        k = np.searchsorted(times, time)
        if k == 0 or k == times.shape[0]:
            out[row] = values[min(k, times.shape[0] - 1)]
        else:
            out[row] = step(time, times[k - 1], values[k - 1], times[k], values[k])
