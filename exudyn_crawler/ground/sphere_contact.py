"""Sphere contact of the whole track as functions of the generalized coordinates, by the engine's law."""

import math

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.coordinates import ConstrainedCoordinates
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import angular_velocity, rotation_matrices
from exudyn_crawler.ground.spheres import COLUMN, COLUMNS, sphere_contacts, sphere_derivatives, sphere_forces


def sphere_places(case: Case) -> NDArray:
    """Centres of the spheres in the shoe's frame: array (spheres, 3), m."""
    spheres = case.sphere_contact()
    low_x, high_x, low_y, high_y, z = case.shoe.footprint
    x = low_x + (high_x - low_x) * (np.arange(spheres.spheres_x) + 0.5) / spheres.spheres_x
    y = low_y + (high_y - low_y) * (np.arange(spheres.spheres_y) + 0.5) / spheres.spheres_y
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack((grid, np.full(len(grid), z + spheres.radius)))


def seam(case: Case) -> tuple[float, float]:
    """How far the faces are drawn back from the edges between units, along x and along y, m.

    Nothing where they are whole: a sphere over the seam of two units touches the edges of both faces and is
    pushed twice as hard. Drawn back by this much, both together push a sphere at the settled depth that
    stands over the middle of the seam up as hard as one face does.
    """
    spheres = case.sphere_contact()
    if spheres.faces == "whole":
        return 0.0, 0.0
    radius, depth = spheres.radius, case.settled_penetration
    height = radius - depth
    slant = radius / (1.0 + 0.5 * depth / height)  # from 2 (radius - slant) height / slant = depth
    inset = math.sqrt(slant**2 - height**2)
    terrain = case.terrain
    return (inset if terrain.columns > 1 else 0.0), (inset if terrain.rows > 1 else 0.0)


class SphereContact:
    """Contact of all spheres as functions of the generalized coordinates, by the engine's law.

    Takes the place of `assembly.TrackContact`, with the units as bodies.

    Parameters
    ----------
    case : Case
        With contact by spheres.
    """

    def __init__(self, case: Case) -> None:
        shoes, terrain, spheres = case.track.shoe_count, case.terrain, case.sphere_contact()
        units = terrain.unit_count
        self.coordinates = ConstrainedCoordinates(units, terrain.tilt_axis)
        com_positions = case.track.com_positions(case.shoe.com_height)
        self.shoe_reference = np.hstack((com_positions, np.zeros((shoes, 3))))
        self.unit_reference = np.hstack((terrain.centers, np.zeros((units, 1))))
        self._tilt_axis = terrain.tilt_axis
        self._grid = np.array(
            [
                terrain.columns,
                terrain.rows,
                terrain.unit_length,
                terrain.unit_width,
                *terrain.origin,
                *seam(case),
            ]
        )
        self._tops = 0.5 * terrain.unit_height + terrain.top_heights
        self._places = sphere_places(case)
        count = len(self._places)
        self._law = np.array(
            [
                case.sphere_stiffness,
                spheres.damping / count,
                spheres.radius,
                spheres.friction,
                spheres.friction_speed,
            ]
        )
        self._area = case.shoe.length * case.shoe.width / count
        # a sphere reaches four units at most, with both triangles of each
        self._table = np.zeros((8 * shoes * count, COLUMNS))
        self._pairs = np.zeros((4 * shoes * count, 2), dtype=np.int64)
        self._blocks = np.zeros((4 * shoes * count, 8, 8))
        self._shoe_forces = np.zeros((shoes, 6))
        self._unit_forces = np.zeros((units, 6))

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, then six a unit."""
        return self.shoe_reference.size + self.coordinates.size

    def touching(self, q: NDArray, q_t: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """Touching spheres at a state, and the places of shoes and units.

        Returns
        -------
        table : array (contacts, COLUMNS)
            Columns as in `spheres.COLUMN`; overwritten by the next call.
        shoes, units : array (shoes, 6), array (units, 4)
            Places and angles.
        """
        split = self.shoe_reference.size
        shoes = self.shoe_reference + q[:split].reshape(-1, 6)
        units = self.unit_reference + self.unit_motion(q)
        count = sphere_contacts(
            shoes,
            q_t[:split].reshape(-1, 6),
            units,
            self.unit_motion(q_t),
            self._tilt_axis,
            self._grid,
            self._tops,
            self._places,
            self._law,
            self._table,
        )
        return self._table[:count], shoes, units

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        out = np.zeros_like(self.unit_reference)
        self.coordinates.motion(q[self.shoe_reference.size :], out)
        return out

    def ground_below(self, q: NDArray, heights: NDArray) -> NDArray:
        """Heights (units,) of the units below every sphere: array (shoes, spheres), m."""
        shoes = self.shoe_reference + q[: self.shoe_reference.size].reshape(-1, 6)
        return heights[self._units_below(shoes[:, None, :2] + self._places[:, :2])]

    def _units_below(self, centers: NDArray) -> NDArray:
        """Index of the unit below each sphere, of which x and y come last: array (shoes, spheres)."""
        columns, rows = self._grid[:2].astype(int)
        cells = np.floor((centers - self._grid[4:6]) / self._grid[2:4]).astype(int)
        cells = np.clip(cells, 0, [columns - 1, rows - 1])
        return cells[..., 0] * rows + cells[..., 1]

    def sunken(self, q: NDArray) -> list[int]:
        """Numbers of the shoes with a sphere whose centre is below its unit's face: nothing holds that up."""
        shoes = self.shoe_reference + q[: self.shoe_reference.size].reshape(-1, 6)
        centers = shoes[:, None, :3] + self._places @ rotation_matrices(shoes[:, 3:]).transpose(0, 2, 1)
        below = self._units_below(centers[..., :2])
        units = (self.unit_reference + self.unit_motion(q))[below]
        apart = centers - units[..., :3]
        sine, cosine = np.sin(units[..., 3]), np.cos(units[..., 3])
        across = -apart[..., 1] if self._tilt_axis == 0 else apart[..., 0]
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

    def derivatives(
        self,
        q: NDArray,
        q_t: NDArray,
        position_factor: float,
        velocity_factor: float,
        secant: bool = False,
    ) -> NDArray:
        """Triplets (row, column, value) of both derivatives of the forces, as of `TrackContact`."""
        table, shoes, units = self.touching(q, q_t)
        count = sphere_derivatives(
            shoes,
            units,
            self._tilt_axis,
            self._law,
            table,
            position_factor,
            velocity_factor,
            secant,
            self._pairs,
            self._blocks,
        )
        return self.coordinates.derivative(
            self._pairs[:count], self._blocks[:count], len(self.shoe_reference)
        )

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
            Columns as in `contact.RESULT`. The point is the centre of pressure; penetration, its rate and
            slip velocity are means over the spheres, weighted by their normal forces; the area is that of
            their parts of the underside. The friction torque is all that the spheres' forces do about the
            point, so that it has components along the face, too.
        """
        table, shoes, _ = self.touching(q, q_t)
        found = _by_pair(table, self._area)
        if shoe_forces is not None and len(found):
            self._share_rest(found, shoes, shoe_forces.reshape(-1, 6))
        return found

    def _share_rest(self, found: NDArray, shoes: NDArray, generalized: NDArray) -> None:
        """Add to the friction of each pair its share of what the forces on its shoe exceed the law's by."""
        index = found[:, RESULT["shoe"]].astype(int)
        force = found[:, RESULT["normal_force"]] + found[:, RESULT["friction_force"]]
        arm = found[:, RESULT["point"]] - shoes[index, :3]
        moment = np.cross(arm, force) + found[:, RESULT["friction_torque"]]
        # generalized moments are the moment's parts along the axes that the angles turn about
        axes = np.stack(
            [angular_velocity(shoes[:, 3:], np.broadcast_to(e, (len(shoes), 3))) for e in np.eye(3)], 1
        )
        wanted = np.linalg.solve(axes, generalized[:, 3:, None])
        rest_force, rest_moment = generalized[:, :3].copy(), wanted[..., 0]
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
