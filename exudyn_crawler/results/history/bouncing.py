"""Bouncing of the shoes, as it shows in the spectrum of their contact forces."""

from typing import NamedTuple

import numpy as np
from scipy.signal import welch

from exudyn_crawler.results.history.contacts import contacts_of
from exudyn_crawler.results.history.history import History

BAND = (3.0, 30.0)
"""Hz, between what loads and drive do and what the elastic shoes do."""
WINDOW = 2.0
"""s, length of the pieces whose spectra are averaged: it resolves 0.5 Hz."""
WIDTH = 0.25
"""Of the peak's frequency: how far to either side counts as the same oscillation."""
LEAST_SHARE = 0.3
"""Of the variance above the band's begin that the peak has to hold; noise spreads over all frequencies."""
LEAST_SIZE = 0.01
"""Of the mean force: what varies by less is not worth a line."""


class Bouncing(NamedTuple):
    """Oscillation of the contact forces.

    Attributes
    ----------
    frequency : float
        Hz, of the highest peak of the mean spectrum over the shoes.
    size : float
        Root mean square of the vertical force on a shoe about the peak, over the mean force.
    share : float
        Part of the variance above `BAND`'s begin that it holds.
    """

    frequency: float
    size: float
    share: float


def bouncing(history: History) -> Bouncing | None:
    """Bouncing of the shoes over a run; None where none stands out of the contact forces' spectrum.

    The vertical contact force of every shoe is taken at equal times; spectra by Welch's method. Runs shorter
    than `WINDOW` tell nothing.
    """
    force = contacts_of(history.dataset).contact_force.sel(axis="z").transpose("shoe", "time").values
    time = history.time.values
    if time[-1] - time[0] < WINDOW:
        return None
    step = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1], step)
    sampled = np.stack([np.interp(even, time, one) for one in force])
    pieces = min(len(even), round(WINDOW / step))
    frequency, density = welch(sampled, 1.0 / step, nperseg=pieces, detrend="linear")
    spectrum = density.mean(axis=0)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    if not inside.any():
        return None
    peak = float(frequency[inside][spectrum[inside].argmax()])
    about = np.abs(frequency - peak) <= WIDTH * peak
    variance = float(spectrum[about].sum() * frequency[1])
    above = float(spectrum[frequency >= BAND[0]].sum() * frequency[1])
    mean = abs(float(force.mean()))
    if not (above > 0.0 and mean > 0.0):
        return None
    found = Bouncing(peak, float(np.sqrt(variance)) / mean, variance / above)
    return found if found.size >= LEAST_SIZE and found.share >= LEAST_SHARE else None
