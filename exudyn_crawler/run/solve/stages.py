"""Stages of a run, each of which the solver starts anew."""

import math

from exudyn_crawler.case import Case

TIME_TOLERANCE = 1e-9
"""Relative difference below which two times are the same."""
SETTLING = 1.0
"""s after the drive goes off until the track is quiet; its shoes swing at 8 Hz and more."""


def stage_times(case: Case, duration: float) -> list[float]:
    """Ends of the stages of a run, from 0 to its duration, s.

    The integration starts anew from its state at every multiple of the solver's checkpoint interval and
    where the drive goes on or off.
    """
    interval = case.solver.checkpoint_interval
    times = {0.0, duration} | {k * interval for k in range(1, math.ceil(duration / interval))}
    for time in case.drive.switch_times:
        times |= {other for other in (time, time + SETTLING) if other < duration}
    kept: list[float] = []
    for time in sorted(times):
        if not kept or time - kept[-1] > TIME_TOLERANCE * duration:
            kept.append(time)
    kept[-1] = duration
    return kept


def is_quiet(case: Case, start: float) -> bool:
    """Whether the track is quiet in the stage that starts at a time, s."""
    return case.drive.off_since(start) >= SETTLING * (1.0 - TIME_TOLERANCE)
