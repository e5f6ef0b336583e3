"""Stability against tipping over the four edges on which a machine on two tracks stands.

Axes: see `assessment.forces`. Edges: front and rear (end wheels on hard ground, or outer rollers where those
are lifted), left and right (middle of a track, or the outer edge of its shoes as ISO 10567 has it).
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.forces import PARTS, Floats, MachineForces

EDGES = ("front", "rear", "left", "right")
OUTWARD = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
"""Directions (4, 3) in which a machine tips over the edges."""
WEIGHTS = [PARTS.index(name) for name in ("lower", "upper", "payload")]
"""Forces that keep the direction of gravity as the machine tilts; the others keep theirs in its axes."""


class Edges(NamedTuple):
    """Distances of the edges from the middle, m, all positive."""

    front: float
    rear: float
    left: float
    right: float


class Tipping(NamedTuple):
    """How far a machine is from tipping over each edge: arrays (angles, 4)."""

    stabilising: Floats
    """Sum of the moments about the edge that hold the machine, N m."""
    overturning: Floats
    """Sum of those that tip it, N m."""
    distance: Floats
    """Of the resultant's foot inside of the edge, m."""
    angle: Floats
    """By which the machine may be tilted further about the edge until it tips, rad; 0 where it tips."""

    @property
    def margin(self) -> Floats:
        """Stabilising over overturning moments; infinite where nothing tips."""
        return np.divide(
            self.stabilising,
            self.overturning,
            out=np.full_like(self.stabilising, np.inf),
            where=self.overturning > 0.0,
        )

    @property
    def first_edge(self) -> np.ndarray:
        """Number in `EDGES` of the edge of the least margin: (angles,).

        Where no force overturns, so that all margins are infinite, the edge of the least angle.
        """
        margin = self.margin
        overturned = np.isfinite(margin).any(axis=1)
        return np.where(overturned, margin.argmin(axis=1), self.angle.argmin(axis=1))


def tipping(forces: MachineForces, edges: Edges) -> Tipping:
    """Moments about each edge, and the angle until the machine tips.

    The moment of a force about the edge at the distance d, with the unit vector n outward and z up, is
    (d - r.n) (-F_z) - r_z F.n; positive ones hold the machine, negative ones tip it. Tilted further by t, the
    weights W at their common place d_w inside of the edge and h_w above it leave
    W (d_w cos t - h_w sin t) + M = 0, with M of all else, so that
    t = acos(-M / (W sqrt(d_w^2 + h_w^2))) - atan(h_w / d_w) (statics; derived).
    """
    reach = np.array(edges)
    inside = reach[None, :, None] - np.einsum("akx,ex->aek", forces.place, OUTWARD)
    outward = np.einsum("akx,ex->aek", forces.force, OUTWARD)
    height = forces.place[:, None, :, 2]
    moments = -inside * forces.force[:, None, :, 2] - height * outward
    stabilising = np.where(moments > 0.0, moments, 0.0).sum(axis=2)
    overturning = -np.where(moments < 0.0, moments, 0.0).sum(axis=2)
    weight = -forces.force[:, :, 2].sum(axis=1)[:, None]
    angle = _angle(forces, inside, outward, moments)
    return Tipping(stabilising, overturning, (stabilising - overturning) / weight, angle)


def _angle(forces: MachineForces, inside: Floats, outward: Floats, moments: Floats) -> Floats:
    """Further tilt (rad) about each edge at which the machine tips: array (angles, 4)."""
    others = np.delete(moments, WEIGHTS, axis=2).sum(axis=2)
    down = -forces.force[:, None, WEIGHTS, 2]
    along = outward[:, :, WEIGHTS]
    height = forces.place[:, None, WEIGHTS, 2]
    # moments of the weights as they are, and of weights turned outward by a quarter
    now = moments[:, :, WEIGHTS].sum(axis=2)
    quarter = -(inside[:, :, WEIGHTS] * along + height * down).sum(axis=2)
    cosine = np.clip(-others / np.hypot(now, quarter), -1.0, 1.0)
    tilt = np.arccos(cosine) + np.arctan2(quarter, now)
    return np.where(now + others > 0.0, np.maximum(tilt, 0.0), 0.0)


def tipping_load(
    forces: MachineForces, edges: Edges, reach: float, swing_axis: float, slew: Floats
) -> Floats:
    """Vertical load (N) at a reach at which the machine tips over the edge that comes first: (angles,).

    `forces` are those without payload on level ground; the load hangs at `reach` (m) ahead of the swing axis
    at x = `swing_axis` (m). T = M / (r.n - d), M what holds the machine about the edge; infinite where a load
    tips it over none. A load of which the allowed part is 75 % is what SAE J1097 and ISO 10567 rate.
    """
    slew = np.atleast_1d(slew)
    place = np.stack((swing_axis + reach * np.cos(slew), reach * np.sin(slew), np.zeros_like(slew)), axis=-1)
    arm = place @ OUTWARD.T - np.array(edges)
    balance = tipping(forces, edges)
    held = balance.stabilising - balance.overturning
    loads = np.divide(held, arm, out=np.full_like(held, np.inf), where=arm > 0.0)
    return np.maximum(loads.min(axis=1), 0.0)
