"""Points of a flexible shoe's mesh at pins, ground, rollers and drive; its fit with rigid neighbours."""

from dataclasses import dataclass

import numpy as np

from exudyn_crawler.case import Case, Rails, RunningGear, Shoe, Track
from exudyn_crawler.case.parameters.track import COUPLING, PinCoupling
from exudyn_crawler.ground.rotations import rotation_matrices
from fem import Interface, Mesh, ReducedBody
from meshes.checks import check_extent, named_surfaces
from meshes.rails import rail_outline, station_weights
from meshes.undersides import ground_outline

PIN_TOLERANCE = 1e-3
"""Allowed distance (m) between the axis of a bore and the pin."""
BESIDE = 1.0
"""Largest offset of a joint from the middle of its bore, fraction of the bore's length; 0.5 is the face of
the lug."""
TOLERANCE = 5e-3
"""Allowed difference (m) between the mesh's underside, or its rails, and those of the rigid shoes, at which
all shoes are in contact."""
EDGES = ["rear", "front", "right", "left", "height"]


def pin_interfaces(mesh: Mesh, name: str, track: Track, pins: PinCoupling = COUPLING) -> list[Interface]:
    """Return interfaces of a shoe at the joint centres of its track, each coupled to its bore by `pins`.

    Raises `ValueError`, with this name of the mesh, if the mesh is in other units or has no bore at a pin.
    """
    check_extent(mesh, name)
    interfaces = []
    taken = np.zeros(len(mesh.nodes), dtype=bool)
    for joint, center in track.joint_centers.items():
        if f"bore {joint}" not in mesh.surfaces:
            raise ValueError(
                f"the mesh {name!r} must have the surface 'bore {joint}', {named_surfaces(mesh)}"
            )
        nodes = mesh.nodes_of(f"bore {joint}")
        bore = mesh.nodes[nodes]
        off = 0.5 * (bore.min(axis=0) + bore.max(axis=0)) - center
        # a bore is as long as its lug is wide, of which the joint centre need not be the middle; between lugs
        # side by side it is in their gap
        if np.hypot(off[0], off[2]) > PIN_TOLERANCE or abs(off[1]) > BESIDE * np.ptp(bore[:, 1]):
            raise ValueError(
                f"the mesh {name!r} must meet the track's pins within {PIN_TOLERANCE} m: "
                f"its bore {joint!r} is off the pin by {off.round(4).tolist()} m"
            )
        # a bore that is parted in the middle has nodes on both sides of the cut
        nodes = nodes[~taken[nodes]]
        taken[nodes] = True
        interfaces.append(Interface(joint, center, nodes, pins))
    return interfaces


def check_fit(mesh: Mesh, name: str, shoe: Shoe, rails: Rails | None) -> None:
    """Raise `ValueError` if the underside of a mesh, or its rails, are not those of the rigid shoes."""
    under = ground_outline(mesh)
    edges = [under.low[0], under.high[0], under.low[1], under.high[1], under.level]
    compared = [("underside of the case's shoes", EDGES, edges, shoe.footprint.tolist())]
    if rails is not None:
        try:
            outline = rail_outline(mesh)._asdict()
        except ValueError as error:
            raise ValueError(
                f"flexible.mesh {name!r} cannot be used with wheels on its rails: {error}"
            ) from error
        wanted = [getattr(rails, key) for key in outline]
        compared.append(("rails of shoe.rails", list(outline), list(outline.values()), wanted))
    for what, keys, sizes, wanted in compared:
        if np.abs(np.subtract(sizes, wanted)).max() > TOLERANCE:
            must, has = (
                dict(zip(keys, np.round(numbers, 4).tolist(), strict=True)) for numbers in (wanted, sizes)
            )
            raise ValueError(
                f"the mesh {name!r} must have the {what} within {TOLERANCE} m, {must}; it has {has}. "
                f"Shoe.from_mesh({name!r}) makes the shoe that matches the mesh"
            )


STATIONS = 9
"""Number of stations along a rail, including its ends."""


def strip_lines(frame: RunningGear, rails: Rails) -> np.ndarray:
    """Return y of the strips of a roller, those of the right tread first: array (2 strips,), m."""
    return np.concatenate([middle + frame.strip_places for middle in rails.middles])


def station_spacing(rails: Rails) -> float:
    """Return the distance of neighbouring stations, m."""
    return (rails.front - rails.rear) / (STATIONS - 1)


def strip_weights(mesh: Mesh, frame: RunningGear, rails: Rails) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes (k,) of the rails, and their weights (lines, STATIONS, k).

    A weight is the node's share in a force at a station of a strip.
    """
    lines = strip_lines(frame, rails)
    along = np.linspace(rails.rear, rails.front, STATIONS)
    weights = station_weights(mesh, [(x, y) for y in lines for x in along])
    nodes = np.flatnonzero(weights.any(axis=0))
    return nodes, weights[:, nodes].reshape(len(lines), STATIONS, -1)


def extended(rows: np.ndarray) -> np.ndarray:
    """Return rows (lines, STATIONS, ...) with one linearly extrapolated station at either end."""
    before = 2.0 * rows[:, :1] - rows[:, 1:2]
    behind = 2.0 * rows[:, -1:] - rows[:, -2:-1]
    return np.ascontiguousarray(np.concatenate((before, rows, behind), axis=1))


def rail_rows(reduced: ReducedBody | None, frame: RunningGear, rails: Rails) -> np.ndarray:
    """Return displacements of the rails, on lines under the strips of wheels, by m modes of flexible shoes.

    They are at even stations, as in `extended`: array (lines, STATIONS + 2, 3, m); without a reduced body m
    is 0.
    """
    if reduced is None:
        return np.zeros((len(strip_lines(frame, rails)), STATIONS + 2, 3, 0))
    nodes, weights = strip_weights(reduced.mesh, frame, rails)
    return extended(np.einsum("lsn,nck->lsck", weights, reduced.modes[nodes]))


def cubic_weights(t: np.ndarray) -> np.ndarray:
    """Return weights (k, STATIONS + 2) of `extended` rows at positions (k,), in spacings from the rear end.

    The cubics are those of `forces.wheels`.
    """
    first = np.minimum(t.astype(int), STATIONS - 2)
    u = t - first
    values = (
        u * (u * (2.0 - u) - 1.0),
        2.0 + u * u * (3.0 * u - 5.0),
        u * (1.0 + u * (4.0 - 3.0 * u)),
        u * u * (u - 1.0),
    )
    weights = np.zeros((len(t), STATIONS + 2))
    for n, value in enumerate(values):
        weights[np.arange(len(t)), first + n] = 0.5 * value
    return weights


@dataclass(frozen=True)
class DrivePoint:
    """Point of a shoe at which the drive acts, with m modes; none for a rigid shoe."""

    place: np.ndarray  # (3,): position in the undeformed shoe, m, the shoe's frame
    rows: np.ndarray  # (3, m): its displacement by each mode; transposed, they make modal loads of a force

    def arm(self, angles: np.ndarray, modal: np.ndarray) -> np.ndarray:
        """Return the vector from the frame's origin to the point, global: array (..., 3), m.

        `angles` (..., 3) are successive rotations about x, y, z, rad, `modal` (..., m) modal coordinates.
        """
        local = self.place + modal @ self.rows.T
        return np.einsum("...ij,...j->...i", rotation_matrices(angles), local)


def pulled_node(case: Case, mesh: Mesh) -> int | None:
    """Return the node of the flexible shoes' mesh with all of the drive's force; None without such a node."""
    flexible = case.flexible
    if flexible is None or case.gear.loops or case.drive.point != "com node":
        return None
    if case.track.shoe_count not in flexible.shoes:
        return None
    return int(np.argmin(np.linalg.norm(mesh.nodes - np.array(flexible.com_node), axis=1)))


def pin_middle(track: Track, reduced: ReducedBody | None, end: str) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the middle of the rear or front pins of a shoe (m).

    For a flexible shoe also return its displacement by the modes.
    """
    if reduced is None:
        centers = [center for name, center in track.joint_centers.items() if name.startswith(end)]
        return np.mean(centers, axis=0), None
    chosen = [k for k, interface in enumerate(reduced.interfaces) if interface.name.startswith(end)]
    place = np.mean([reduced.interfaces[k].center for k in chosen], axis=0)
    return place, reduced.pilots[chosen, :3].mean(axis=0)


def drive_point(case: Case, reduced: ReducedBody | None) -> DrivePoint:
    """Return the point at which a case's drive moves its front shoe; `reduced` is the body with its modes.

    With None the shoe is rigid; its COM then takes the place of a node.
    """
    at_pins = case.drive.point == "front pins"
    node = None if reduced is None else pulled_node(case, reduced.mesh)
    if reduced is not None and node is not None:
        return DrivePoint(reduced.nodes[node], reduced.modes[node])
    # the frame moves with the body as a whole: its modes are orthogonal to that
    none = np.zeros((3, 0 if reduced is None else len(reduced.frequencies)))
    place, rows = pin_middle(case.track, reduced, "front")
    return DrivePoint(place if at_pins else np.zeros(3), rows if at_pins and rows is not None else none)
