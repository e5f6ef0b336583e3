"""Where loads enter a flexible shoe, as families of unit loads, and the static fields of these loads.

| family | coordinates (times, ...) |
|---|---|
| joints | (joint, 6): force and moment on each joint centre |
| machine | (2, 3): force spread evenly over the loaded surface; force times its shift to the left, N m |
| ground | (point, 3): tractions of a grid over the underside |
| rails | (station, 3): forces at stations of the right rail, then of the left; only if asked for |
| drive | (3,): force on the pulled node; lacking where none is |
| inertia | (mode,): momentum of the modes that are integrated |
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, hstack

from exudyn_crawler.case import Case, FlexibleShoes, Track
from exudyn_crawler.model.drive_point import pulled_node
from exudyn_crawler.model.flexible_shoes import (
    integrated_reduction,
    shoe_model,
    weights_a_metre,
    whole_reduction,
)
from exudyn_crawler.model.reductions import kept_fields
from fem import (
    FlatRectangle,
    Kept,
    KeptFields,
    Mesh,
    PressureGrid,
    ReducedBody,
    Stations,
    UnitLoads,
    flat_parts,
)

JOINTS, MACHINE, GROUND, RAILS, DRIVE, INERTIA = "joints", "machine", "ground", "rails", "drive", "inertia"

GROUND_SPACING = 0.2
"""m, at most, between points of the ground's grid: a fifth of a unit."""
RAIL_REACH = 0.1
"""m, half the length over which a force on a rail is spread: about an element; a roller's line is shorter."""
RAIL_SPACING = 0.0375
"""m, about, between stations of a rail: `Stations` says what it leaves open."""


def ground_grid(mesh: Mesh) -> PressureGrid:
    """Grid over the underside of a shoe.

    Raises
    ------
    ValueError
        If the underside is no level rectangle.
    """
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    low, high = under.min(axis=0), under.max(axis=0)
    along, across = (1 + int(np.ceil(side / GROUND_SPACING)) for side in high - low)
    return PressureGrid(FlatRectangle(mesh, "underside", low, high), (along, across))


def rail_stations(mesh: Mesh) -> list[Stations]:
    """Stations of each rail of a shoe, from the right to the left.

    Raises
    ------
    KeyError
        If the mesh has no surface "rails".
    ValueError
        If a rail is no level rectangle.
    """
    rails = flat_parts(mesh, "rails")
    lengths = [rail.high[0] - rail.low[0] for rail in rails]
    return [
        Stations(rail, 1 + round(length / RAIL_SPACING), min(RAIL_REACH, 0.5 * length))
        for rail, length in zip(rails, lengths, strict=True)
    ]


def rail_loads(stations: Sequence[Stations], rail: int, forces: NDArray, x: NDArray) -> NDArray:
    """Coordinates (times, stations of all rails, 3) of the family "rails" by forces on one rail.

    A force acts in the middle of the rail's width and makes no moment there; several are added up.

    Parameters
    ----------
    stations : sequence of Stations
        Of `rail_stations`.
    rail : int
        Its number among them: 0 for the right one.
    forces : array (times, 3)
        N, body axes.
    x : array (times,)
        m, body axes.

    Raises
    ------
    ValueError
        If there is no such rail, or a force acts beyond its ends.
    """
    if not 0 <= rail < len(stations):
        raise ValueError(f"rail must be in 0..{len(stations) - 1}, got {rail}")
    parts = [np.zeros((len(forces), one.count, 3)) for one in stations]
    parts[rail] = stations[rail].coordinates(forces, x)
    return np.concatenate(parts, axis=1)


def shoe_fields(case: Case, rails: bool = False) -> KeptFields:
    """Static fields of a case's flexible shoes beside all modes of `whole_reduction`; kept like these.

    Parameters
    ----------
    rails : bool
        Whether forces on the rails are among the loads.

    Raises
    ------
    ValueError
        If the case has no flexible shoes, or the underside of their mesh, or a rail, is no level rectangle.
    """
    flexible = case.flexible_shoes()
    body, _ = shoe_model(flexible, case.track)
    node = pulled_node(case, body.mesh)
    integrated = integrated_reduction(case).body
    return _fields(flexible, case.track, node, whole_reduction(case), integrated, rails)


@lru_cache(maxsize=2)
def _fields(
    flexible: FlexibleShoes,
    track: Track,
    node: int | None,
    whole: Kept,
    integrated: ReducedBody,
    rails: bool,
) -> KeptFields:
    body, interfaces = shoe_model(flexible, track)
    families = {
        JOINTS: UnitLoads.at_centers(len(body.mesh.nodes), interfaces),
        MACHINE: UnitLoads.spread(_machine_weights(whole.body, flexible.load_surface), interfaces),
        GROUND: UnitLoads.spread(ground_grid(body.mesh).weights, interfaces),
        INERTIA: UnitLoads.of_inertia(integrated.modes, interfaces),
    }
    if rails:
        weights = hstack([stations.weights for stations in rail_stations(body.mesh)])
        families[RAILS] = UnitLoads.spread(csr_array(weights), interfaces)
    if node is not None:
        families[DRIVE] = UnitLoads.spread(np.eye(len(body.mesh.nodes), 1, -node), interfaces)
    return kept_fields(body, whole, families)


def _machine_weights(whole: ReducedBody, loaded: str) -> NDArray:
    """Nodal forces (n, 2) of a unit force over the loaded surface, and of what a metre of shift adds."""
    even = whole.weights(loaded)
    return np.column_stack((even, weights_a_metre(even, whole.nodes)))
