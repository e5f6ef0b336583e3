"""Whether a side frame fits the track that it rolls over."""

import math

import numpy as np

from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.shoe import Shoe
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.case.parameters.undercarriage import Undercarriage

MARGIN = 4.0
"""m of ground ahead of the track."""
FEWEST_SHOES = 4
"""Two links that the tumbler pulls lie between them."""


def ground_below(track: Track, terrain: Terrain) -> Terrain:
    """Terrain with as many units along x as a track of any length needs."""
    end = track.first_com[0] + track.shoe_count * track.pitch + MARGIN
    return terrain.with_(columns=math.ceil((end - terrain.origin[0]) / terrain.unit_length))


def check_rolled(frame: Undercarriage, shoe: Shoe, track: Track, drive: Drive, loads: LoadCycle) -> None:
    """Refuse what does not go with a side frame.

    Raises
    ------
    ValueError
        Naming the field and what is allowed.
    """
    rails = shoe.rails
    if rails is None:
        raise ValueError("shoe.rails must be given with an undercarriage, which rolls on them")
    if frame.tread_width > rails.width:
        raise ValueError(
            f"undercarriage.tread_width must not exceed the rails' width {rails.width} m, "
            f"got {frame.tread_width}"
        )
    gap = track.pitch - (rails.front - rails.rear)
    if not 0.0 <= gap < 2.0 * frame.radius:
        raise ValueError(
            f"shoe.rails must leave a gap from shoe to shoe that rollers cross: none below 0 and less than "
            f"their diameter {2.0 * frame.radius:g} m, got {gap:.4g} m with the pitch {track.pitch}"
        )
    if track.shoe_count < FEWEST_SHOES:
        raise ValueError(
            f"track.shoe_count must be at least {FEWEST_SHOES} with an undercarriage, got {track.shoe_count}"
        )
    if drive.turn_rate is not None:
        raise ValueError("drive.turn_rate must be None with an undercarriage, whose yaw is held")
    if drive.on is not None:
        raise ValueError(
            "drive.on must be None with an undercarriage, which the drive moves or holds at all times; "
            "a speed of zero is a brake"
        )
    if any(load != 0.0 for phase in loads.phases for load in phase.loads):
        raise ValueError(
            "loads must be zero on every shoe with an undercarriage, whose rollers carry the machine"
        )


def check_length(frame: Undercarriage, track: Track, drive: Drive, duration: float) -> None:
    """Refuse a drive that takes rollers or tumbler off the track within `duration` (s).

    Raises
    ------
    ValueError
        With the time, the place and the track's extent.
    """
    first, last = track.first_com[0], track.first_com[0] + (track.shoe_count - 1) * track.pitch
    pins = first + track.pin_ahead, last - track.pitch + track.pin_ahead
    parts = (
        ("rear roller", frame.rollers[0], (first, last)),
        ("front roller", frame.rollers[-1], (first, last)),
        ("tumbler", frame.tumbler, pins),
    )
    for time in np.linspace(0.0, duration, 101 if duration > 0.0 else 1):
        travel = drive.travel(time)
        for name, place, (least, greatest) in parts:
            x = frame.start + travel + place
            if not least <= x <= greatest:
                raise ValueError(
                    f"track must be long enough for the drive: at t = {time:.3g} s the {name} is at "
                    f"x = {x:.4g} m, the shoes reach from {least:.4g} to {greatest:.4g} m; "
                    f"more shoes (track.shoe_count) or another undercarriage.start give it way"
                )
