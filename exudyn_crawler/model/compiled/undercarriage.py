"""From a case's undercarriage to the numbers that the compiled equations of its side frame take."""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.compiled.bodies import Body, rigid_body
from exudyn_crawler.model.compiled.rollers import Rollers
from exudyn_crawler.model.rail_rows import rail_rows, strip_lines
from fem import ReducedBody

ENDS = ("rear", "front")
"""Pins of a shoe."""


def frame_place(case: Case) -> NDArray:
    """Place (3,) of a side frame's origin at t = 0 with its rollers on rails that have not settled, m."""
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        return np.zeros(3)
    return np.array(
        [frame.start, case.track.first_com[1], case.shoe.com_height + rails.height + frame.radius]
    )


def frame_body(case: Case) -> Body:
    """Side frame, in axes whose origin is at its rollers; one without mass where there is none."""
    frame, none = case.undercarriage, np.zeros(3)
    if frame is None:
        return rigid_body(0.0, np.zeros((3, 3)), none, none)
    return rigid_body(frame.mass, frame.inertia_tensor, np.array(frame.com), none)


def rollers_of(case: Case, reduced: ReducedBody | None) -> Rollers:
    """Rollers of a case, and how they meet its shoes.

    Parameters
    ----------
    reduced : ReducedBody, optional
        Of the flexible shoes.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    along, centers = rail_rows(reduced, case), case.track.joint_centers
    pins = np.array([np.mean([c for n, c in centers.items() if n.startswith(e)], axis=0) for e in ENDS])
    pin_rows = np.zeros((2, 3, along.rows.shape[3]))
    if frame is None or rails is None:
        places, law, rail = np.zeros((0, 0, 3)), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        return Rollers(places, 0.0, law, rail, along.rows, 1.0, case.track.pitch, 0.0, pins, pin_rows, 0.0)
    places = np.array([[(x, y, 0.0) for y in strip_lines(frame, rails)] for x in frame.rollers])
    if reduced is not None:
        for end, name in enumerate(ENDS):
            chosen = [k for k, one in enumerate(reduced.interfaces) if one.name.startswith(name)]
            pins[end] = np.mean([reduced.interfaces[k].center for k in chosen], axis=0)
            pin_rows[end] = reduced.pilots[chosen, :3].mean(axis=0)
    return Rollers(
        places=places,
        radius=frame.radius,
        law=(
            frame.stiffness / frame.strips,
            frame.exponent,
            frame.damping / frame.strips,
            frame.damping_depth,
        ),
        rail=(rails.rear, rails.front, rails.height),
        rows=along.rows,
        spacing=along.spacing,
        pitch=case.track.pitch,
        tumbler=frame.tumbler,
        pins=pins,
        pin_rows=pin_rows,
        tension=frame.end_tension,
    )


class FrameInputs:
    """Travel, machine's force and rolling resistance of a case's side frame over time; zeros without one."""

    def __init__(self, case: Case) -> None:
        self._case = case
        self._none = np.zeros(3), np.zeros(6), 0.0

    def at(self, time: float) -> tuple[NDArray, NDArray, float]:
        """Last three of `records.Inputs` at a time, s."""
        frame, speed = self._case.undercarriage, self._case.drive.speed
        if frame is None:
            return self._none
        now = float(speed.value(time))
        travel = np.array([float(speed.integral(time)), now, float(speed.rate(time))])
        drag = frame.rolling_resistance * now / np.hypot(now, frame.resistance_speed)
        return travel, np.concatenate(self._case.machine_wrench(time), axis=1)[0], float(drag)
