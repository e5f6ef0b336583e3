"""Tension of closed chains at rest: push on the idlers, and sag between idler and carrier."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.results.history import catalogue
from exudyn_crawler.results.history.side_frame import pins_in_frame

IDLER = "idler"


class Hanging(NamedTuple):
    """Closed chain in one state."""

    side: str  # side of the track, right or left; empty for a case of one track
    push: float  # push of the chain on the idler, backward along the side frame, N
    sag: float  # depth of the pins between idler and carrier below a straight edge on them, m
    span: float  # distance along the frame from the idler's axis to that of the carrier or tumbler, m
    carrier: str  # name of this carrier, or tumbler

    @property
    def pretension(self) -> float:
        """Half of the push on the idler, since both runs pull on it, N."""
        return 0.5 * self.push


def hanging_chains(case: Case, state: xr.Dataset) -> list[Hanging]:
    """Return the chains of all tracks in one state of a history: a dataset without times."""
    ahead = catalogue.rotation_matrices(state.side_frame_angles.values)[:, 0]
    pins = pins_in_frame(case, state)[:, [0, 2]].reshape(case.gear.tracks, -1, 2)
    take_ups = np.atleast_1d(state.take_up.values)
    sides = ("",) if case.gear.tracks == 1 else SIDES
    chains = []
    for side, its_pins, take_up in zip(sides, pins, take_ups, strict=True):
        force = state.wheel_force.sel(wheel=f"{side} {IDLER}".strip()).values
        chains.append(_hanging(case, side, -float(force @ ahead), its_pins, float(take_up)))
    return chains


def roller_clearances(case: Case, state: xr.Dataset) -> np.ndarray:
    """Return clearances of the upper run's rails above the lower rollers in a state: (tracks, rollers), m.

    It follows from the distance between the rollers' axes and straight lines from pin to pin. A run that lies
    on a roller presses it, so that its clearance is slightly negative.
    """
    closed = case.part(Closed)
    rails = case.shoe.roller_path
    pins = pins_in_frame(case, state)[:, [0, 2]].reshape(case.gear.tracks, -1, 2)
    axes = np.zeros((case.gear.tracks, len(closed.rollers), 2))
    axes[:, :, 0] = closed.rollers
    if closed.arms:
        for track, angles in zip(axes, state.arm_angle.values.reshape(case.gear.tracks, -1), strict=True):
            for arm, angle in zip(closed.arms, angles, strict=True):
                c, s = np.cos(angle), np.sin(angle)
                arms = track[arm.roller - 1] - arm.pivot
                track[arm.roller - 1] = arm.pivot + np.array([[c, s], [-s, c]]) @ arms
    apart = np.array([_from_upper(*of) for of in zip(pins, axes, strict=True)])
    return apart - closed.roller_radius - rails.height + case.track.pin_height


def _from_upper(pins: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return distances (m) of axes (n, 2) from the part above them of a closed chain of pins (m, 2)."""
    ahead = np.roll(pins, 1, axis=0) - pins
    from_pins = axes[:, None] - pins
    share = np.clip(np.sum(from_pins * ahead, axis=2) / np.sum(ahead**2, axis=1), 0.0, 1.0)
    feet = pins + share[..., None] * ahead
    apart = np.linalg.norm(axes[:, None] - feet, axis=2)
    return np.where(feet[..., 1] > axes[:, 1:], apart, np.inf).min(axis=1)


def _hanging(case: Case, side: str, push: float, pins: np.ndarray, take_up: float) -> Hanging:
    """Return the chain of pins (n, 2), given by x and z in the frame, m."""
    closed = case.part(Closed)
    place, height = closed.idler.place
    carriers = {label.words: place for label, place in closed.upper.items()}
    carriers["tumbler"] = closed.tumbler.place
    name, (start, _) = max(carriers.items(), key=lambda item: item[1][0])
    end = place + take_up
    half = 0.5 * closed.chain_pitch(case.track)
    between = (pins[:, 1] > height) & (pins[:, 0] > start - half) & (pins[:, 0] < end + half)
    return Hanging(side, push, depth_below_edge(pins[between]), end - start, name)


def depth_below_edge(points: np.ndarray) -> float:
    """Return the greatest depth (m) of points (n, 2), x and z, below straight edges laid on them."""
    ordered = points[np.argsort(points[:, 0])]
    edge = list[np.ndarray]()
    for point in ordered:
        while len(edge) > 1 and _turns_up(edge[-2], edge[-1], point):
            edge.pop()
        edge.append(point)
    if len(edge) < 2:
        return 0.0
    x, z = np.array(edge).T
    return float(np.max(np.interp(ordered[:, 0], x, z) - ordered[:, 1]))


def _turns_up(first: np.ndarray, second: np.ndarray, third: np.ndarray) -> bool:
    """Return True if the second of three points lies on or below the line of the others."""
    (x0, z0) = second - first
    (x1, z1) = third - second
    return bool(x0 * z1 - z0 * x1 >= 0.0)
