"""Finite elements of a check's shoe, and the balanced loads of its cases."""

from functools import cached_property

import numpy as np

from exudyn_crawler.case import Track
from exudyn_crawler.model import reductions
from exudyn_crawler.model.shoe_mesh import pin_interfaces
from exudyn_crawler.results.checks import cases as ready
from exudyn_crawler.results.stress.hot_spots import BORES, shoe_regions
from fem import (
    ElasticBody,
    Partition,
    PinContact,
    Shapes,
    cached_pin_contacts,
    contact_coordinates,
    contact_loads,
)
from fem.body import interfaces, supports
from fem.body.mesh import triangle_normals
from meshes import STEEL, ShoeDimensions, mesh_named, mesh_shoe, with_load_surfaces
from meshes.checks import check_surfaces

POINTS, RAIL_POINTS = 0.02, 0.01
"""Distance of points on the underside and other faces, and on the rails, m."""
BED = (5, 15)
"""Numbers of points along x and y of the grid of tractions that bend the underside."""
LINE = 4e-3
"""Half length of a tread's contact at the very end of a rail, m: that of a Hertz contact."""
BALANCE = 1e-3
"""Greatest imbalance, fraction of the sum of all forces (times 1 m for moments); meshes round places."""
NORMALS: dict[ready.Facing, tuple[int, float]] = {
    "front": (0, 1.0),
    "rear": (0, -1.0),
    "left": (1, 1.0),
    "right": (1, -1.0),
    "up": (2, 1.0),
    "down": (2, -1.0),
}
"""Axis and sign of the direction of a face."""


class CheckedShoe:
    """Finite elements of a check's shoe: its factorized stiffness, its surface and regions.

    Loads are forces on all nodes, then forces and moments on all joint centres: arrays (3 n + 24,), N and N
    m, or with several columns. Construction raises as `mesh_named` and `mesh_shoe`.
    """

    def __init__(self, check: ready.ShoeCheck) -> None:
        track = check.track or Track.ph4100c()
        if check.dimensions:
            shoe_mesh = mesh_shoe(ShoeDimensions(**check.dimensions), check.mesh)
            name = check.name
            mesh = with_load_surfaces(shoe_mesh)
        else:
            name = check.mesh
            mesh = mesh_named(check.mesh)
        check_surfaces(mesh, "underside", name)
        self.mesh, self.body = mesh, ElasticBody(mesh, STEEL)
        pins = pin_interfaces(mesh, name, track, check.pins)
        self.partition, self.outline = Partition(self.body, pins), ready.ShoeOutline.of(mesh)
        empty = (np.empty((len(mesh.nodes), count, 0)) for count in (3, 6))
        self.shapes = Shapes(mesh, STEEL, tuple(pins), *empty)
        self.regions = shoe_regions(self.shapes, track)[mesh.surface_nodes]
        self.unused_regions = [BORES] if len(self.shapes.held_nodes) else []
        self._points: dict[str, supports.SurfacePoints] = {}

    @cached_property
    def contacts(self) -> tuple[PinContact, ...]:
        """Pins in contact, of the shoe's steel, cached on disk."""
        return cached_pin_contacts(
            reductions.reductions_folder(), self.partition, STEEL, warn=reductions.warn
        )

    @cached_property
    def bed(self) -> supports.OneSidedBed:
        """Points of the underside for support by the ground."""
        points = supports.surface_points(self.mesh, self.mesh.surface("underside"), POINTS)
        return supports.OneSidedBed(self.partition, points, BED)

    @cached_property
    def of_centers(self) -> np.ndarray:
        """Motions (24, 6) of the joint centres in rigid motions of the body."""
        return interfaces.rigid_motion_of_centers(self.partition.interfaces, self.body.center_of_mass)

    def facing(self, way: ready.Facing) -> supports.SurfacePoints:
        """Return the points of all faces of one direction, those beneath others included."""
        if way not in self._points:
            axis, sign = NORMALS[way]
            normal = triangle_normals(self.mesh.nodes[self.mesh.boundary[:, :3]])
            looking = sign * normal[:, axis] >= 0.9 * np.linalg.norm(normal, axis=1)
            self._points[way] = supports.surface_points(self.mesh, self.mesh.boundary[looking], POINTS)
        return self._points[way]

    def rail(self, tread: ready.TreadForce) -> np.ndarray:
        """Return the nodal forces (n, 3) of a tread, N."""
        rails = self.outline.rails
        half = 0.5 * tread.length
        if rails is None:
            raise ValueError("treads must be left out: the shoe has no rails")
        if "rail" not in self._points:
            self._points["rail"] = supports.surface_points(self.mesh, self.mesh.surface("rails"), RAIL_POINTS)
        points = self._points["rail"]
        sign = 1.0 if tread.side == "left" else -1.0
        middle = 0.5 * (rails.front + rails.rear)
        x = {None: middle + tread.x, "front": rails.front - tread.x, "rear": rails.rear + tread.x}[tread.end]
        if not rails.rear <= x <= rails.front:
            raise ValueError(f"a tread must press on the rail, got x = {x:.4g} m in the shoe")
        half = min(half, max(min(x - rails.rear, rails.front - x), LINE))
        x = min(max(x, rails.rear + half), rails.front - half)
        y = (rails.left if sign > 0 else rails.right) + sign * tread.across
        width = rails.width if tread.width is None else tread.width
        place = points.positions[:, :2]
        target = np.array([x, y])
        sides = 0.5 * np.array([max(2.0 * half, 2.0 * RAIL_POINTS), width])
        near = points.chosen(np.flatnonzero((np.abs(place - target) <= sides).all(axis=1)))
        if len(near.areas) < 3:
            raise ValueError(f"a tread must press on the rail, got y = {y:.4g} m in the shoe")
        return near.spread(np.array([0.0, 0.0, -tread.force]), _centred(near, target))

    def pressure(self, load: ready.Pressure) -> np.ndarray:
        """Return the nodal forces (n, 3) of a pressure, N."""
        points = self.facing(load.facing)
        along = NORMALS[load.facing][0]
        chosen = inside(points.positions, load, [axis for axis in range(3) if axis != along])
        if not chosen.any():
            raise ValueError(
                f"pressures: no face is directed {load.facing} between {load.low} and {load.high} m"
            )
        return points.chosen(np.flatnonzero(chosen)).spread(np.array(load.force))

    def loads(self, case: ready.CheckCase) -> np.ndarray:
        """Return the loads of a case without the ground's, forces of holding pins and their contact included.

        ValueError, with the remaining force and moment, for loads out of balance.
        """
        loads = np.zeros(self.mesh.nodes.size + len(self.of_centers))
        forces, centers = self.parts(loads)
        for hold in (*map(self.rail, case.treads), *map(self.pressure, case.pressures)):
            forces += hold.ravel()
        joints = [interface.name for interface in self.partition.interfaces]
        known = {f"{name} {axis}": 6 * k + i for k, name in enumerate(joints) for i, axis in enumerate("xyz")}
        if unknown := [place for place in case.held_by if place not in known]:
            raise ValueError(f"held_by must be among {', '.join(known)}, got {', '.join(unknown)}")
        for pin in case.pins:
            centers[[known[f"{pin.pin} {axis}"] for axis in "xyz"]] += pin.force
        size = np.abs(forces).sum() + np.abs(centers).sum()
        # the ground carries forces upward and moments about x and y
        rows = [0, 1, 5] if case.ground is not None else list(range(6))
        if held := [known[place] for place in case.held_by]:
            left = self.resultant(loads)[rows]
            centers[held] += np.linalg.lstsq(self.of_centers[held][:, rows].T, -left, rcond=None)[0]
        left = self.resultant(loads)
        if np.abs(left[rows]).max() > BALANCE * size or size == 0.0:
            raise ValueError(
                f"without ground the loads must be in balance, got forces "
                f"{left[:3].round(1).tolist()} N and moments {left[3:].round(1).tolist()} N m that remain"
            )
        if self.contacts:
            joined = self.contacts, self.partition.interfaces
            pressed = contact_coordinates(*joined, centers.reshape(1, -1, 6))[0]
            nodal, taken = contact_loads(*joined, len(self.mesh.nodes))
            forces += nodal @ pressed
            centers += taken @ pressed
        return loads

    def parts(self, loads: np.ndarray) -> list[np.ndarray]:
        """Return views of the loads on nodes (3 n, ...) and on joint centres (24, ...)."""
        return np.split(loads, [self.mesh.nodes.size])

    def resultant(self, loads: np.ndarray) -> np.ndarray:
        """Return the resultant force (N) and moment about the centre of mass (N m): (6,)."""
        forces, centers = self.parts(loads)
        return self.body.rigid_modes.T @ forces + self.of_centers.T @ centers

    def answers(self, loads: np.ndarray) -> np.ndarray:
        """Return the displacements (n, 3, k), m, under loads (3 n + 24, k)."""
        return self.partition.static_response(*self.parts(loads)).reshape(-1, 3, loads.shape[1])


def inside(places: np.ndarray, part: ready.Pressure | ready.GroundPart, across: list[int]) -> np.ndarray:
    """Return True for each place (p, axes) in a part's box, or in its disc over the two axes `across`."""
    low = np.array(part.low)
    high = np.array(part.high)
    away = np.abs(places - 0.5 * (low + high)) / (0.5 * (high - low))
    in_box = (away <= 1.0).all(axis=1)
    return in_box & ((away[:, across] ** 2).sum(axis=1) <= 1.0) if part.round else in_box


def _centred(points: supports.SurfacePoints, place: np.ndarray) -> np.ndarray:
    """Return a linear density (p,) that centres a force at a place (2,), cut off at zero."""
    off = points.positions[:, :2] - place
    plane = np.column_stack((np.ones(len(off)), off))
    weights = np.linalg.lstsq(
        plane.T @ (points.areas[:, None] * plane), np.array([1.0, 0.0, 0.0]), rcond=None
    )[0]
    return np.maximum(plane @ weights, 0.0)
