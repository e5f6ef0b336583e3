"""From a case's undercarriage to the numbers that the compiled equations of its side frame take."""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Rails, Undercarriage
from exudyn_crawler.model.compiled.bodies import rigid_body
from exudyn_crawler.model.compiled.rollers import Rollers, SideFrame
from exudyn_crawler.model.rail_rows import rail_rows, strip_lines
from fem import ReducedBody

ENDS = ("rear", "front")
"""Pins of a shoe."""


def side_frame_of(case: Case, reduced: ReducedBody | None) -> SideFrame | tuple[()]:
    """Side frame of a case with its rollers, and how they meet its shoes; empty where there is none.

    Parameters
    ----------
    reduced : ReducedBody, optional
        Of the flexible shoes.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        return ()
    height = case.shoe.com_height + rails.height + frame.radius
    return SideFrame(
        rigid_body(frame.mass, frame.inertia_tensor, np.array(frame.com), np.zeros(3)),
        np.array([frame.start, case.track.first_com[1], height]),
        _rollers(case, frame, rails, reduced),
    )


def _rollers(case: Case, frame: Undercarriage, rails: Rails, reduced: ReducedBody | None) -> Rollers:
    along, centers = rail_rows(reduced, case), case.track.joint_centers
    pins = np.array([np.mean([c for n, c in centers.items() if n.startswith(e)], axis=0) for e in ENDS])
    pin_rows = np.zeros((2, 3, along.rows.shape[3]))
    if reduced is not None:
        for end, name in enumerate(ENDS):
            chosen = [k for k, one in enumerate(reduced.interfaces) if one.name.startswith(name)]
            pins[end] = np.mean([reduced.interfaces[k].center for k in chosen], axis=0)
            pin_rows[end] = reduced.pilots[chosen, :3].mean(axis=0)
    return Rollers(
        places=np.array([[(x, y, 0.0) for y in strip_lines(frame, rails)] for x in frame.rollers]),
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
