"""Stability of a machine on two tracks against tipping over its four edges.

Axes: see `assessment.forces`. Front and rear edges are the end wheels on hard ground, or the outer rollers if
the end wheels are lifted. Left and right edges are the middle of a track, or the outer edge of its shoes (ISO
10567).
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.forces import PARTS, Floats, MachineForces

EDGES = ("front", "rear", "left", "right")
OUTWARD = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
"""Directions (4, 3) of tipping over the edges."""
WEIGHTS = [PARTS.index(name) for name in ("lower", "upper", "payload")]
"""Indices of the forces that keep the direction of gravity as the machine tilts; the others turn with it."""


class Edges(NamedTuple):
    """Distances of the edges from the middle, m, all positive."""

    front: float
    rear: float
    left: float
    right: float


class Tipping(NamedTuple):
    """Moments, distances and tilt angles about each edge: arrays (angles, 4)."""

    stabilising: Floats
    """Sum of the stabilising moments about the edge, N m."""
    overturning: Floats
    """Sum of the overturning moments about the edge, N m."""
    distance: Floats
    """Distance of the resultant's foot inside the edge, m."""
    angle: Floats
    """Further tilt about the edge until the machine tips, rad; 0 if it tips already."""

    @property
    def margin(self) -> Floats:
        """Stabilising over overturning moments; infinite without overturning moments."""
        return np.divide(
            self.stabilising,
            self.overturning,
            out=np.full_like(self.stabilising, np.inf),
            where=self.overturning > 0.0,
        )

    @property
    def first_edge(self) -> np.ndarray:
        """Number in `EDGES` of the edge with the least margin: (angles,).

        Without overturning moments all margins are infinite; then it is the edge with the least angle.
        """
        margin = self.margin
        overturned = np.isfinite(margin).any(axis=1)
        return np.where(overturned, margin.argmin(axis=1), self.angle.argmin(axis=1))


def tipping(forces: MachineForces, edges: Edges) -> Tipping:
    """Return the moments about each edge, and the angle until the machine tips.

    The edge has the distance d and the outward unit vector n; z is up. The moment of a force about it is
    (d - r.n) (-F_z) - r_z F.n; positive ones stabilise, negative ones overturn. The weights W have their
    common centre d_w inside the edge and h_w above it. After a further tilt t, W (d_w cos t - h_w sin t) + M
    = 0, with M the moment of all other forces. Hence t = acos(-M / (W sqrt(d_w^2 + h_w^2))) - atan(h_w / d_w)
    (statics; derived).
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
    """Return the further tilt (rad) about each edge at which the machine tips: array (angles, 4)."""
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
    """Return the vertical load (N) at a reach that tips the machine over the first edge: (angles,).

    `forces` exclude the payload, on level ground. The load hangs at `reach` (m) ahead of the swing axis at x
    = `swing_axis` (m). T = M / (r.n - d), M the stabilising moment about the edge; infinite if a load tips
    the machine over no edge. The rated load of SAE J1097 and ISO 10567 is at most 75 % of it.
    """
    slew = np.atleast_1d(slew)
    place = np.stack((swing_axis + reach * np.cos(slew), reach * np.sin(slew), np.zeros_like(slew)), axis=-1)
    arm = place @ OUTWARD.T - np.array(edges)
    balance = tipping(forces, edges)
    held = balance.stabilising - balance.overturning
    loads = np.divide(held, arm, out=np.full_like(held, np.inf), where=arm > 0.0)
    return np.maximum(loads.min(axis=1), 0.0)
