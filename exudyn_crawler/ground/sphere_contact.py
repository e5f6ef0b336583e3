"""Sphere contact of the whole track as functions of the generalized coordinates, by the engine's law."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Terrain
from exudyn_crawler.ground.coordinates import TerrainCoordinates
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.grid import grid_of, units_below
from exudyn_crawler.ground.laws import LINEAR, PROPORTIONAL, Law
from exudyn_crawler.ground.laws.linear import Linear
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import moments_of, rotation_matrices
from exudyn_crawler.ground.sphere_derivatives import COORDINATES, sphere_derivatives
from exudyn_crawler.ground.spheres import (
    COLUMN,
    COLUMNS,
    SphereBodies,
    SphereTrack,
    sphere_contacts,
    sphere_forces,
)
from exudyn_crawler.ground.triplets import PairBlocks, Weights


@dataclass(frozen=True)
class SphereField:
    """Spheres under every shoe.

    Attributes
    ----------
    places : array (spheres, 3)
        Centres in the shoe's frame, m.
    radius : float
        m.
    law : Linear
        Of one sphere.
    inset : tuple of float
        How far the units' faces are drawn back from the edges between units, along x and along y, m.
    area : float
        Part of the underside that a sphere stands for, m2.
    """

    places: NDArray
    radius: float
    law: Linear
    inset: tuple[float, float]
    area: float


def sphere_field(case: Case) -> SphereField:
    """Spheres of a case, at the middle of equal parts of the underside, touching it from within."""
    spheres, shoe = case.sphere_contact(), case.shoe
    low_x, high_x, low_y, high_y, z = shoe.footprint
    x = low_x + (high_x - low_x) * (np.arange(spheres.spheres_x) + 0.5) / spheres.spheres_x
    y = low_y + (high_y - low_y) * (np.arange(spheres.spheres_y) + 0.5) / spheres.spheres_y
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    count = len(grid)
    inset = (0.0, 0.0)
    if spheres.faces == "drawn_back":
        inset = _seam(case.terrain, spheres.radius, case.settled_penetration)
    return SphereField(
        places=np.column_stack((grid, np.full(count, z + spheres.radius))),
        radius=spheres.radius,
        law=Linear(case.sphere_stiffness, spheres.damping / count, spheres.friction, spheres.friction_speed),
        inset=inset,
        area=shoe.length * shoe.width / count,
    )


def _seam(terrain: Terrain, radius: float, depth: float) -> tuple[float, float]:
    """How far faces are drawn back so that both push a sphere over the middle of a seam as one does, m.

    A sphere over the seam of two whole faces touches the edges of both and is pushed twice as hard. Drawn
    back by this much, both together push a sphere at the settled depth there as hard as one face does.
    """
    height = radius - depth
    slant = radius / (1.0 + 0.5 * depth / height)  # from 2 (radius - slant) height / slant = depth
    inset = math.sqrt(slant**2 - height**2)
    return (inset if terrain.columns > 1 else 0.0), (inset if terrain.rows > 1 else 0.0)


class SphereGroundContact:
    """Contact of all spheres by the engine's law; a `contact.GroundContact`.

    Parameters
    ----------
    com_positions, terrain, coordinates
        As of `pair_contact.PairGroundContact`; the engine's contact needs the units as bodies.
    spheres : SphereField
        Spheres under every shoe.
    """

    def __init__(
        self, com_positions: NDArray, terrain: Terrain, coordinates: TerrainCoordinates, spheres: SphereField
    ) -> None:
        shoes, units, count = len(com_positions), terrain.unit_count, len(spheres.places)
        self.coordinates = coordinates
        self.spheres = spheres
        self.shoe_reference = np.hstack((com_positions, np.zeros((shoes, 3))))
        self.unit_reference = np.hstack((terrain.centers, np.zeros((units, 1))))
        self._grid = grid_of(terrain)
        self._tops = 0.5 * terrain.unit_height + terrain.top_heights
        track = SphereTrack(
            grid=self._grid,
            tops=self._tops,
            half_x=0.5 * terrain.unit_length - spheres.inset[0],
            half_y=0.5 * terrain.unit_width - spheres.inset[1],
            places=spheres.places,
            radius=spheres.radius,
            law=Law(normal=LINEAR, friction=PROPORTIONAL, linear=spheres.law),
        )
        self._track = plain(track)
        # a sphere reaches four units at most, with both triangles of each
        pairs = 4 * shoes * count
        self._table = np.zeros((2 * pairs, COLUMNS))
        self._blocks = PairBlocks(
            np.zeros((pairs, 2), dtype=np.int64),
            np.zeros((pairs, COORDINATES, COORDINATES)),
            np.zeros((pairs, 3, 0)),
        )
        self._moments = np.zeros((pairs, 3))
        self._shoe_forces = np.zeros((shoes, 6))
        self._unit_forces = np.zeros((units, 6))

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, then the terrain's."""
        return self.shoe_reference.size + self.coordinates.size

    def _shoes(self, q: NDArray) -> NDArray:
        return self.shoe_reference + q[: self.shoe_reference.size].reshape(-1, 6)

    def touching(self, q: NDArray, q_t: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """Touching spheres at a state, and the places of shoes and units.

        Returns
        -------
        table : array (contacts, COLUMNS)
            Columns as in `spheres.COLUMN`; overwritten by the next call.
        shoes, units : array (shoes, 6), array (units, 4)
            Places and angles.
        """
        bodies = SphereBodies(
            self._shoes(q),
            q_t[: self.shoe_reference.size].reshape(-1, 6),
            self.unit_reference + self.unit_motion(q),
            self.unit_motion(q_t),
        )
        count = sphere_contacts(tuple(bodies), self._track, self._table)
        return self._table[:count], bodies.shoes, bodies.units

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        out = np.zeros_like(self.unit_reference)
        self.coordinates.motion(q[self.shoe_reference.size :], out)
        return out

    def settled_depth(self, loads: NDArray) -> NDArray:
        """Depth (m) of the spheres of shoes that each carry such a load (N) evenly."""
        return np.maximum(loads, 0.0) / (self.spheres.law.stiffness * len(self.spheres.places))

    def ground_below(self, q: NDArray, heights: NDArray) -> NDArray:
        """Mean height (m) of the units below each shoe's spheres, of the units' heights: array (shoes,)."""
        centers = self._shoes(q)[:, None, :2] + self.spheres.places[:, :2]
        return heights[units_below(self._grid, centers)].mean(axis=1)

    def sunken(self, q: NDArray) -> list[int]:
        """Numbers of the shoes with a sphere whose centre is below its unit's face: nothing holds that up."""
        shoes = self._shoes(q)
        turned = self.spheres.places @ rotation_matrices(shoes[:, 3:]).transpose(0, 2, 1)
        centers = shoes[:, None, :3] + turned
        below = units_below(self._grid, centers[..., :2])
        units = (self.unit_reference + self.unit_motion(q))[below]
        apart = centers - units[..., :3]
        sine, cosine = np.sin(units[..., 3]), np.cos(units[..., 3])
        across = -apart[..., 1] if self._grid.tilt_axis == 0 else apart[..., 0]
        above = sine * across + cosine * apart[..., 2] - self._tops[below]
        return (np.flatnonzero((above <= 0.0).any(axis=1)) + 1).tolist()

    def forces(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized contact forces: array (size,)."""
        table, shoes, units = self.touching(q, q_t)
        sphere_forces(shoes, units, table, self._shoe_forces, self._unit_forces)
        generalized = np.empty(self.size)
        split = self.shoe_reference.size
        generalized[:split] = self._shoe_forces.ravel()
        self.coordinates.project(self._unit_forces, units, generalized[split:])
        return generalized

    def derivatives(self, q: NDArray, q_t: NDArray, weights: Weights) -> NDArray:
        """Triplets (row, column, value) of both derivatives of the forces, as of `GroundContact`."""
        table, shoes, units = self.touching(q, q_t)
        pairs, values, rows = self._blocks
        count = sphere_derivatives(
            (shoes, units),
            self._grid.tilt_axis,
            tuple(self.spheres.law),
            table,
            weights.typed(),
            (pairs, values, self._moments),
        )
        found = PairBlocks(pairs[:count], values[:count], rows[:count])
        return self.coordinates.derivative(found, len(self.shoe_reference))

    def results(self, q: NDArray, q_t: NDArray, shoe_forces: NDArray | None = None) -> NDArray:
        """Contacts at a state, summed over the spheres of each pair: array (contacts, RESULTS).

        Parameters
        ----------
        shoe_forces : array (6 shoes,), optional
            The engine's generalized contact forces on the shoes. Within a step the engine keeps every
            sphere in the branch of the friction law (rising or full) where it was before, so that its
            friction may pass the law's for that step; what its forces differ from the law's on a shoe is
            shared among the shoe's pairs by their normal forces.

        Returns
        -------
        array (contacts, RESULTS)
            Columns as in `pairs.RESULT`. The point is the centre of pressure; penetration, its rate and
            slip velocity are means over the spheres, weighted by their normal forces; the area is that of
            their parts of the underside. The friction torque is all that the spheres' forces do about the
            point, so that it has components along the face, too.
        """
        table, shoes, _ = self.touching(q, q_t)
        found = _by_pair(table, self.spheres.area)
        if shoe_forces is not None and len(found):
            self._share_rest(found, shoes, shoe_forces.reshape(-1, 6))
        return found

    def _share_rest(self, found: NDArray, shoes: NDArray, generalized: NDArray) -> None:
        """Add to the friction of each pair its share of what the forces on its shoe exceed the law's by."""
        index = found[:, RESULT["shoe"]].astype(int)
        force = found[:, RESULT["normal_force"]] + found[:, RESULT["friction_force"]]
        arm = found[:, RESULT["point"]] - shoes[index, :3]
        moment = np.cross(arm, force) + found[:, RESULT["friction_torque"]]
        rest_force, rest_moment = generalized[:, :3].copy(), moments_of(shoes[:, 3:], generalized[:, 3:])
        np.subtract.at(rest_force, index, force)
        np.subtract.at(rest_moment, index, moment)
        weight = np.maximum(found[:, RESULT["normal_force"]][:, 2], 0.0)
        total = np.bincount(index, weight, len(shoes))[index]
        share = np.divide(weight, total, out=np.zeros_like(weight), where=total > 0.0)[:, None]
        extra = share * rest_force[index]
        found[:, RESULT["friction_force"]] += extra
        # the moment of the shared force about the COM is taken off the rest of the moment
        carried = np.zeros_like(rest_moment)
        np.add.at(carried, index, np.cross(arm, extra))
        found[:, RESULT["friction_torque"]] += share * (rest_moment - carried)[index]


def _by_pair(table: NDArray, area: float) -> NDArray:
    """Gather touching spheres into one row for every pair of shoe and unit."""
    keys, row = np.unique(table[:, :2], axis=0, return_inverse=True)
    row = row.ravel()

    def total(values: NDArray) -> NDArray:
        summed = np.zeros((len(keys), *values.shape[1:]))
        np.add.at(summed, row, values)
        return summed

    size = table[:, COLUMN["size"]]
    normal = size[:, None] * table[:, COLUMN["normal"]]
    slip = table[:, COLUMN["slip"]]
    friction = -table[:, COLUMN["drag"], None] * slip
    # a sphere that leaves may be pulled by its damping; it has no weight
    weight = np.maximum(size, 1e-9)
    weight = weight / total(weight)[row]
    point = total(weight[:, None] * table[:, COLUMN["point"]])
    out = np.zeros((len(keys), RESULTS))
    out[:, :2] = keys
    out[:, RESULT["penetration"]] = total(weight * table[:, COLUMN["depth"]])
    out[:, RESULT["penetration_rate"]] = total(weight * table[:, COLUMN["approach"]])
    out[:, RESULT["area"]] = area * np.bincount(row, minlength=len(keys))
    out[:, RESULT["point"]] = point
    out[:, RESULT["normal_force"]] = total(normal)
    out[:, RESULT["friction_force"]] = total(friction)
    out[:, RESULT["slip_velocity"]] = total(weight[:, None] * slip)
    arm = table[:, COLUMN["point"]] - point[row]
    out[:, RESULT["friction_torque"]] = total(np.cross(arm, normal + friction))
    return out
