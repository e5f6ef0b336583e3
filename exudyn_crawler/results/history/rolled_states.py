"""From states of a track under a side frame to the variables of frame and rollers in a history."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.ground.rotations import angular_acceleration, angular_velocity
from exudyn_crawler.model.state import RATES, StateLayout
from exudyn_crawler.results.history.quantities import Variable, variable

NEIGHBOURS = ("behind", "ahead")
"""Shoes that a roller may be on at once: the last one whose COM its axis has passed, and the next."""

Treads = Callable[[float, NDArray, NDArray], tuple[NDArray, NDArray, NDArray]]
"""Gives at a time (s), coordinates and rates: forces on the shoes and their places, both (rollers, strips of
both rails, 2, 3), global, N and m; and the index of the shoe behind every roller's axis, (rollers,)."""


def frame_motion(case: Case, layout: StateLayout, rows: NDArray) -> dict[str, NDArray]:
    """Motion of the side frame's origin and axes, each (times, 3), by the names of their variables.

    Parameters
    ----------
    rows : array (times, layout.size)
        Stored states.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        raise ValueError("the case has no undercarriage")
    time = layout.part(rows, "time")
    speed = case.drive.speed
    travels = (speed.integral(time), speed.value(time), speed.rate(time))
    start = (frame.start, case.track.first_com[1], case.shoe.com_height + rails.height + frame.radius)
    places, angles = [], []
    for rate, travel in zip(RATES, travels, strict=True):
        own = layout.part(rows, f"frame{rate}")
        places.append(np.column_stack((travel, np.zeros_like(time), own[:, 0])))
        angles.append(np.column_stack((own[:, 1], own[:, 2], np.zeros_like(time))))
    return {
        "side_frame_position": places[0] + start,
        "side_frame_velocity": places[1],
        "side_frame_acceleration": places[2],
        "side_frame_angles": angles[0],
        "side_frame_angular_velocity": angular_velocity(angles[0], angles[1]),
        "side_frame_angular_acceleration": angular_acceleration(*angles),
    }


def rolled_variables(case: Case, layout: StateLayout, rows: NDArray, treads: Treads) -> dict[str, Variable]:
    """Variables of side frame, rollers and pull.

    Parameters
    ----------
    rows : array (times, layout.size)
        Stored states.
    """
    frame = case.undercarriage
    strips = 1 if frame is None else frame.strips
    parts = (layout.part(rows, name) for name in ("time", "coordinates", "coordinates rate"))
    found = [treads(*state) for state in zip(*parts, strict=True)]
    force, foot, behind = (np.array(one) for one in zip(*found, strict=True))
    split = (len(rows), force.shape[1], len(SIDES), strips, len(NEIGHBOURS), 3)
    named = frame_motion(case, layout, rows) | {
        "drive_pull": layout.part(rows, "drive")[:, 0],
        "roller_shoe": behind + 1,
        "roller_force": force.reshape(split).sum(axis=(3, 4)),
        "tread_force": force.reshape(split),
        "tread_foot": foot.reshape(split),
    }
    return {name: variable(name, values) for name, values in named.items()}


def rolled_coordinates(case: Case) -> dict[str, object]:
    """Coordinates of the dimensions of these variables."""
    frame = case.undercarriage
    if frame is None:
        return {}
    return {
        "roller": ("roller", np.arange(1, len(frame.rollers) + 1), {"long_name": "from rear to front"}),
        "rail": list(SIDES),
        "strip": ("strip", np.arange(1, frame.strips + 1), {"long_name": "of a tread, from right to left"}),
        "neighbour": (
            "neighbour",
            list(NEIGHBOURS),
            {"long_name": "shoe under a roller's axis, or the next"},
        ),
    }
