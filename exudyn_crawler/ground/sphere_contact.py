"""Spheres under rigid shoes on units, Exudyn's own contact, and contacts derived from its forces.

Exudyn computes the forces (`engine.system`). This module derives values from a state: positions of the
spheres, centre of pressure of the force on a shoe, its component normal to the ground, and the slip there.
"""

import math

import numpy as np

from exudyn_crawler.case import Case, Terrain, statics
from exudyn_crawler.case.parameters.contact import SphereContact
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.ground.rotations import angular_velocity, rotation_matrices
from exudyn_crawler.ground.terrain import TerrainCoordinates, UnitCoordinates, grid_of


def sphere_centers(case: Case) -> np.ndarray:
    """Return the spheres' centres in the shoe's frame (spheres, 3), m.

    Each is above the middle of one of the equal parts of the underside. The spheres touch the underside from
    within.
    """
    spheres = case.part(SphereContact)
    low_x, high_x, low_y, high_y, z = case.shoe.footprint
    x = low_x + (high_x - low_x) * (np.arange(spheres.spheres_x) + 0.5) / spheres.spheres_x
    y = low_y + (high_y - low_y) * (np.arange(spheres.spheres_y) + 0.5) / spheres.spheres_y
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack((grid, np.full(len(grid), z + spheres.radius)))


def face_inset(case: Case) -> tuple[float, float]:
    """Return the inset (m) of the units' faces from the edges between units, along x and along y.

    A sphere over the seam of two whole faces touches the edges of both and is pushed twice as hard. With this
    inset both faces together push a sphere at the settled depth as hard as one face does.
    """
    spheres = case.part(SphereContact)
    terrain = case.part(Terrain)
    if spheres.faces == "whole":
        return 0.0, 0.0
    radius = spheres.radius
    depth = statics.settled_penetration(case)
    height = radius - depth
    slant = radius / (1.0 + 0.5 * depth / height)  # from 2 (radius - slant) height / slant = depth
    inset = math.sqrt(slant**2 - height**2)
    return (inset if terrain.columns > 1 else 0.0), (inset if terrain.rows > 1 else 0.0)


class SphereGroundContact:
    """Contact of all spheres, derived from a state; a `contact.GroundContact`."""

    def __init__(self, case: Case, coordinates: UnitCoordinates) -> None:
        self.coordinates: TerrainCoordinates = coordinates
        coms = case.track.com_positions(case.shoe.com_height)
        terrain: Terrain = case.part(Terrain)
        self.shoe_reference = np.hstack((coms, np.zeros((len(coms), 3))))
        self.unit_reference = np.hstack((terrain.even_centers, np.zeros((terrain.unit_count, 1))))
        self._case, self._terrain, self._grid = case, terrain, grid_of(terrain)
        self._tops = 0.5 * terrain.unit_height + terrain.top_heights
        self._tilts = terrain.tilts
        self._centers, self._radius = sphere_centers(case), case.part(SphereContact).radius
        self.size = self.shoe_reference.size + coordinates.size  # six coordinates a shoe, then the units'

    def _shoes(self, q: np.ndarray) -> np.ndarray:
        return self.shoe_reference + q[: self.shoe_reference.size].reshape(-1, 6)

    def unit_motion(self, q: np.ndarray) -> np.ndarray:
        """Return displacement (m) and tilt (rad) of the units from unloaded springs: (units, 4)."""
        return self.coordinates.motion(q[self.shoe_reference.size :])

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Return the height (m) of the units' faces at x (m), with unloaded springs."""
        return self._terrain.surface(x)

    def _above(self, q: np.ndarray, places: np.ndarray, units: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights (m) of points (..., 3) over faces of units (...,), and face normals (..., 3)."""
        pose = (self.unit_reference + self.unit_motion(q))[units]
        up = self._leaning(pose[..., 3])
        # units roll or follow a relief, but not both
        normal = self._leaning(pose[..., 3] + self._tilts[units])
        above = places - pose[..., :3] - self._tops[units][..., None] * up
        return np.sum(normal * above, axis=-1), normal

    def _leaning(self, tilts: np.ndarray) -> np.ndarray:
        """Return the normals (..., 3) of faces at tilts (rad)."""
        sine = np.sin(tilts)
        cosine = np.cos(tilts)
        none = np.zeros_like(tilts)
        return np.stack((none, -sine, cosine) if self._grid.tilt_axis == 0 else (sine, none, cosine), axis=-1)

    def depths(self, q: np.ndarray) -> np.ndarray:
        """Return the depth of the spheres in the faces below them: (shoes, spheres), m; negative above."""
        shoes = self._shoes(q)
        places = shoes[:, None, :3] + self._centers @ rotation_matrices(shoes[:, 3:]).transpose(0, 2, 1)
        return self._radius - self._above(q, places, self._grid.units_below(places[..., :2]))[0]

    def sunken(self, q: np.ndarray) -> list[int]:
        """Return the numbers of the shoes with a sphere whose centre is below its unit's face.

        No contact holds such a sphere up.
        """
        return (np.flatnonzero((self.depths(q) >= self._radius).any(axis=1)) + 1).tolist()

    def results(self, q: np.ndarray, q_t: np.ndarray, wrenches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return contacts at states with `wrenches` (times, shoes, 6); see `contact.GroundContact`."""
        results = [self._results_at(*state) for state in zip(q, q_t, wrenches, strict=True)]
        return np.concatenate(results), np.array([len(rows) for rows in results])

    def _results_at(self, q: np.ndarray, q_t: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """Return one contact for each touching shoe: array (contacts, RESULTS), as in `pairs.RESULT`.

        `wrenches` (shoes, 6) are Exudyn's contact forces on the shoes and moments about their origins, N and
        N m, global. The point is the centre of pressure on the face of the unit below it. This unit is the
        contact's unit even if the shoe stands on several. The normal force is along that face's normal; the
        rest of the force is friction. The friction torque is the moment about the point. The penetration is
        the mean depth of the touching spheres; the area is that of their parts of the underside. The
        penetration's rate and the slip velocity are those of shoe and unit at the point.
        """
        shoes = self._shoes(q)
        rates = q_t[: self.shoe_reference.size].reshape(-1, 6)
        touching = np.flatnonzero(wrenches.any(axis=1))
        shoes = shoes[touching]
        rates = rates[touching]
        wrenches = wrenches[touching]
        depths = np.maximum(self.depths(q)[touching], 0.0)
        count = (depths > 0.0).sum(axis=1)
        depth = depths.sum(axis=1) / np.maximum(count, 1)
        force = wrenches[:, :3]
        moment = wrenches[:, 3:]
        point = self._pressed(shoes, depth, force, moment)
        unit = self._grid.units_below(point[:, :2])
        above, normal = self._above(q, point, unit)
        point = point - above[:, None] * normal
        arm = point - shoes[:, :3]
        of_unit = self.unit_motion(q_t)[unit]
        spin = np.zeros((len(unit), 3))
        spin[:, self._grid.tilt_axis] = of_unit[:, 3]
        middle = (self.unit_reference + self.unit_motion(q))[unit, :3]
        slip = rates[:, :3] + np.cross(angular_velocity(shoes[:, 3:], rates[:, 3:]), arm)
        slip = slip - of_unit[:, :3] - np.cross(spin, point - middle)
        rate = -np.sum(slip * normal, axis=1)
        pressing = np.sum(force * normal, axis=1)[:, None] * normal
        shoe = self._case.shoe
        out = np.zeros((len(touching), RESULTS))
        out[:, RESULT["shoe"]] = touching
        out[:, RESULT["unit"]] = unit
        out[:, RESULT["penetration"]] = depth
        out[:, RESULT["penetration_rate"]] = rate
        out[:, RESULT["area"]] = shoe.ground_area / len(self._centers) * count
        out[:, RESULT["point"]] = point
        out[:, RESULT["normal_force"]] = pressing
        out[:, RESULT["friction_force"]] = force - pressing
        out[:, RESULT["slip_velocity"]] = slip + rate[:, None] * normal
        out[:, RESULT["friction_torque"]] = moment - np.cross(arm, force)
        return out

    def _pressed(
        self, shoes: np.ndarray, depth: np.ndarray, force: np.ndarray, moment: np.ndarray
    ) -> np.ndarray:
        """Return the centres of pressure on shoes at depths (shoes,), m: array (shoes, 3), m, global."""
        R = rotation_matrices(shoes[:, 3:])
        f, m = (np.einsum("nji,nj->ni", R, values) for values in (force, moment))
        low_x, high_x, low_y, high_y, underside = self._case.shoe.footprint
        z = underside + depth
        # the centre of pressure of a small normal force would lie far outside
        up = np.where(f[:, 2] > 0.0, f[:, 2], np.inf)
        x = np.clip((z * f[:, 0] - m[:, 1]) / up, low_x, high_x)
        y = np.clip((m[:, 0] + z * f[:, 1]) / up, low_y, high_y)
        local = np.column_stack((x, y, z))
        return np.asarray(shoes[:, :3] + np.einsum("nij,nj->ni", R, local))
