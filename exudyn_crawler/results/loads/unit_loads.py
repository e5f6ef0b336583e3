"""Where loads enter a flexible shoe: families of unit loads, what each does to its modes and its nodes.

| family | coordinates |
|---|---|
| joints | (joint, 6): force and moment on each joint centre |
| machine | (2, 3): force spread evenly over the loaded surface; force times its shift to the left, N m |
| ground | (point, 3): tractions over the rectangles from a corner of the underside to the points of a grid |
| rails | (station, 3): forces at stations along each strip of the treads; under a side frame |
| drive | (3,): force on the pulled node; lacking where none is |
| inertia | (mode,): momentum of the modes that are integrated |

The ground's grid and the rails' cubics are those of the equations of motion, whose modal loads these
coordinates therefore give to rounding: an even traction over any rectangle is the sum of 16 rectangles from
the corner, and a force between stations is shared by the four of a cubic.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, FlexibleShoes, Rails, Track, Undercarriage
from exudyn_crawler.model.drive_point import pulled_node
from exudyn_crawler.model.flexible_shoes import integrated_in, shoe_model, weights_a_metre, whole_reduction
from exudyn_crawler.model.rail_rows import STATIONS, cubic_weights, extended, station_spacing, strip_weights
from fem import ElasticBody, Nested, ReducedBody
from fem.patches import Underside, integrate_underside

JOINTS, MACHINE, GROUND, RAILS, DRIVE, INERTIA = "joints", "machine", "ground", "rails", "drive", "inertia"

THIRDS = 3
"""Pieces between two stations of the equations' rails: a cubic has four values there."""
STRIP_STATIONS = THIRDS * (STATIONS - 1) + 1
"""Stations along the line of a strip."""


class NodalShares(NamedTuple):
    """Family of p unit loads along x, y and z each that k nodes share: weights (p, k), nodes (k,)."""

    nodes: NDArray
    weights: NDArray

    def work(self, modes: NDArray) -> NDArray:
        """Work (3 p, m) on modes (n, 3, m)."""
        rows: NDArray = np.tensordot(self.weights, modes[self.nodes], axes=1)
        return rows.reshape(-1, modes.shape[2])

    def nodal(self, count: int) -> NDArray:
        """Weights (n, p) of all nodes."""
        weights = np.zeros((count, len(self.weights)))
        weights[self.nodes] = self.weights.T
        return weights


class StripStations(NamedTuple):
    """Stations of the strips' lines: x of the first, m, and the distance of neighbours."""

    rear: float
    spacing: float

    @property
    def positions(self) -> NDArray:
        """X in m."""
        return self.rear + self.spacing * np.arange(STRIP_STATIONS)

    def shares(self, line: int, x: NDArray) -> tuple[NDArray, NDArray]:
        """Numbers (times, 4) of stations and their shares in a force at x (times,) on a strip's line."""
        t = np.clip((x - self.rear) / self.spacing, 0.0, STRIP_STATIONS - 1.0)
        first = THIRDS * np.minimum((t / THIRDS).astype(int), STATIONS - 2)
        u = t - first
        shares = (
            -(u - 1.0) * (u - 2.0) * (u - 3.0) / 6.0,
            u * (u - 2.0) * (u - 3.0) / 2.0,
            -u * (u - 1.0) * (u - 3.0) / 2.0,
            u * (u - 1.0) * (u - 2.0) / 6.0,
        )
        return line * STRIP_STATIONS + first[:, None] + np.arange(4), np.column_stack(shares)


@dataclass(frozen=True, eq=False)
class ShoeUnitLoads:
    """Unit loads of a flexible shoe, k of all families one after the other.

    Attributes
    ----------
    body : ElasticBody
        Mesh and material.
    whole : ReducedBody
        All M modes that the stress is made of.
    integrated : Nested
        The m modes that a run integrates, and where they lie among all.
    underside : Underside
        Grid of the family "ground".
    strips : StripStations or None
        Stations of the family "rails"; None without a side frame.
    spread : mapping of str to NodalShares
        Families whose forces nodes share, by name.
    """

    body: ElasticBody
    whole: ReducedBody
    integrated: Nested
    underside: Underside
    strips: StripStations | None
    spread: Mapping[str, NodalShares]

    @cached_property
    def families(self) -> dict[str, slice]:
        """Where the coordinates of each family stand."""
        counts = {JOINTS: 6 * len(self.whole.interfaces)}
        counts |= {name: 3 * len(family.weights) for name, family in self.spread.items()}
        counts[INERTIA] = len(self.integrated.body.frequencies)
        ends = np.cumsum(list(counts.values())).tolist()
        return {name: slice(end - counts[name], end) for name, end in zip(counts, ends, strict=True)}

    @property
    def size(self) -> int:
        """Number k of unit loads."""
        return self.families[INERTIA].stop

    @cached_property
    def work(self) -> NDArray:
        """Work (k, M) of the unit loads on all modes: their modal loads."""
        modes = len(self.whole.frequencies)
        spread = [family.work(self.whole.modes) for family in self.spread.values()]
        return np.concatenate([self.whole.pilots.reshape(-1, modes), *spread, self.integrated.inside.T])

    @cached_property
    def answers(self) -> NDArray:
        """Static coordinates (k, M) of all modes under the unit loads."""
        return self.work / (2.0 * np.pi * self.whole.frequencies) ** 2

    def forces(self, loads: NDArray) -> tuple[NDArray, NDArray]:
        """Forces on nodes (n, 3), N, and forces and moments on joint centres (i, 6) of coordinates (k,)."""
        nodal = np.zeros_like(self.body.mesh.nodes)
        for name, family in self.spread.items():
            nodal[family.nodes] += family.weights.T @ loads[self.families[name]].reshape(-1, 3)
        modes = self.integrated.body.modes
        inertia = self.body.mass_matrix @ (modes @ loads[self.families[INERTIA]]).ravel()
        return nodal + inertia.reshape(-1, 3), loads[self.families[JOINTS]].reshape(-1, 6)


def unit_loads(case: Case) -> ShoeUnitLoads:
    """Unit loads of a case's flexible shoes; remembered.

    Raises
    ------
    ValueError
        If the case has no flexible shoes or their mesh does not fit the track.
    """
    flexible = case.flexible_shoes()
    body, _ = shoe_model(flexible, case.track)
    return _unit_loads(
        flexible,
        case.track,
        whole_reduction(case).body,
        tuple(case.shoe.footprint.tolist()),
        pulled_node(case, body.mesh),
        (case.undercarriage, case.shoe.rails),
    )


@lru_cache(maxsize=2)
def _unit_loads(
    flexible: FlexibleShoes,
    track: Track,
    whole: ReducedBody,
    footprint: tuple[float, ...],
    node: int | None,
    rolled: tuple[Undercarriage | None, Rails | None],
) -> ShoeUnitLoads:
    body, _ = shoe_model(flexible, track)
    mesh, strips = body.mesh, None
    under = mesh.nodes_of("underside")
    # of each node its own integrals: products with modes are those of the equations
    each = np.eye(len(under))[:, None]
    underside = integrate_underside(mesh.nodes[under, :2], each, np.array(footprint))
    machine = _machine_weights(whole, flexible.load_surface)
    loaded = np.flatnonzero(machine.any(axis=1))
    spread = {
        MACHINE: NodalShares(loaded, machine[loaded].T),
        GROUND: NodalShares(under, underside.integral.reshape(-1, len(under))),
    }
    frame, rails = rolled
    if frame is not None and rails is not None:
        strips = StripStations(rails.rear, station_spacing(rails) / THIRDS)
        nodes, weights = strip_weights(mesh, frame, rails)
        along = cubic_weights(np.arange(STRIP_STATIONS) / THIRDS) @ extended(weights)
        spread[RAILS] = NodalShares(nodes, along.reshape(-1, len(nodes)))
    if node is not None:
        spread[DRIVE] = NodalShares(np.array([node]), np.eye(1))
    return ShoeUnitLoads(body, whole, integrated_in(flexible, whole), underside, strips, spread)


def _machine_weights(whole: ReducedBody, loaded: str) -> NDArray:
    """Nodal forces (n, 2) of a unit force over the loaded surface, and of what a metre of shift adds."""
    even = whole.weights(loaded)
    return np.column_stack((even, weights_a_metre(even, whole.nodes)))
