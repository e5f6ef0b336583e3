"""Contact between shoes and ground: what every model of it does, that of pairs, and the choice of one."""

from collections.abc import Sequence

import numpy as np

from exudyn_crawler.case import Case, CellTerrain, PairContact, Shoe, Terrain
from exudyn_crawler.ground import laws, overlap, pair_stiffness, pairs, rotations, sphere_contact
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.pair_geometry import BodyStates, ContactGeometry, Flexible, Outline
from exudyn_crawler.ground.rows import NO_DERIVATIVES
from exudyn_crawler.ground.terrain import TerrainCoordinates, UnitCoordinates, grid_of, terrain_coordinates
from fem.body.rectangle_motion import Underside


def pair_law(law: PairContact, underside_area: float) -> pairs.PairLaw:
    """Law of a pair; `underside_area` (m2) is that of a shoe."""
    return pairs.PairLaw(
        laws.Impact(law.stiffness, law.exponent, law.damping, law.damping_depth),
        laws.Coulomb(law.static_friction, law.dynamic_friction, law.stiction_speed, law.friction_speed),
        edge_width=law.edge_width,
        whole_area=underside_area if law.sharing == "area" else 0.0,
        area_normal=law.normal == "area",
        closest_points=law.penetration == "closest",
    )


STATES_AT_ONCE = 64
"""Of which contacts are found in one call: Python takes as long for a call as the contacts of a state."""


class PairGroundContact:
    """Contact by one contact for every pair of a shoe and a unit; a `GroundContact`.

    `reference` (shoes, 6) are positions of the COMs (m, global) and angles (rad) of the shoes where their
    coordinates are zero, and `unit_reference` (units, 4) centres (m) and tilts of the units with the springs
    free. Shoes of these indices (from 0) are flexible, by the integrated modes of their underside; they need
    terrain by its independent coordinates.
    """

    def __init__(
        self,
        reference: np.ndarray,
        shoe: Shoe,
        terrain: Terrain,
        law: PairContact,
        coordinates: TerrainCoordinates,
        underside: Underside | None = None,
        flexible_shoes: Sequence[int] = (),
    ) -> None:
        shoes = len(reference)
        units = terrain.unit_count
        if underside is None:
            underside = Underside(np.zeros(2), np.ones(2), np.zeros((2, 2, 3, 0)))
        modes = underside.mode_count
        row = np.full(shoes, -1)
        row[list(flexible_shoes)] = np.arange(len(flexible_shoes))
        self.coordinates = coordinates
        self.shoe_reference = reference
        self.unit_reference = np.hstack((terrain.centers, terrain.tilts[:, None]))
        self._terrain = terrain
        self._row = row
        self._ground_share = shoe.ground_share
        self.geometry = ContactGeometry(
            Outline(grid_of(terrain), pairs.Footprint(*shoe.footprint.tolist()), shoe.finger_length),
            pair_law(law, shoe.length * shoe.width),
            Flexible(underside.corner, underside.cell, underside.integral, row),
            shoe.fingers,
        )
        # units that a shoe's outline can meet at once, at any yaw
        diagonal = float(np.hypot(shoe.length, shoe.width))
        reach = (int(diagonal / terrain.unit_length) + 2) * (int(diagonal / terrain.unit_width) + 2)
        self.greatest_count = shoes * min(reach, units) * (1 + len(shoe.fingers))
        self._contacts = pair_stiffness.UnitContacts.allocate(self.greatest_count, modes)
        self._work = overlap.overlap_workspace()
        self._modal_shape = (len(flexible_shoes), modes)
        self.size = reference.size + coordinates.size + len(flexible_shoes) * modes

    def bodies_at(self, q: np.ndarray, q_t: np.ndarray) -> BodyStates:
        """Places of all bodies at generalized coordinates (..., size) and their rates, for kernels."""
        shoes = self.shoe_reference.size
        modes = shoes + self.coordinates.size
        before = q.shape[:-1]
        shoe_shape = (*before, *self.shoe_reference.shape)
        modal_shape = (*before, *self._modal_shape)
        return BodyStates(
            self.shoe_reference + q[..., :shoes].reshape(shoe_shape),
            np.ascontiguousarray(q_t[..., :shoes]).reshape(shoe_shape),
            self.unit_reference + self.coordinates.motion(q[..., shoes:modes]),
            self.coordinates.motion(q_t[..., shoes:modes]),
            np.ascontiguousarray(q[..., modes : self.size]).reshape(modal_shape),
            np.ascontiguousarray(q_t[..., modes : self.size]).reshape(modal_shape),
        )

    def _touching(self, bodies: BodyStates) -> tuple[np.ndarray, np.ndarray]:
        """Contacts (contacts, RESULTS), and how modes move their patches (contacts, 3, modes)."""
        count = pair_stiffness.touching_pairs(
            bodies, self.geometry, NO_DERIVATIVES, self._contacts, self._work
        )
        return self._contacts.results[:count], self._contacts.modes[:count]

    def forces(self, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
        """Generalized contact forces: array (size,)."""
        bodies = self.bodies_at(q, q_t)
        rows, modes = self._touching(bodies)
        shoe = rows[:, pairs.RESULT["shoe"]].astype(int)
        unit = rows[:, pairs.RESULT["unit"]].astype(int)
        point = rows[:, pairs.RESULT["point"]]
        force = rows[:, pairs.RESULT["normal_force"]] + rows[:, pairs.RESULT["friction_force"]]
        torque = rows[:, pairs.RESULT["friction_torque"]]
        on_shoes = np.zeros_like(bodies.shoes)
        on_units = np.zeros((len(bodies.units), 6))
        arms = point - np.stack((bodies.shoes[shoe, :3], bodies.units[unit, :3]))
        moments = torque + np.cross(arms, force)
        np.add.at(on_shoes, shoe, np.hstack((force, moments[0])))
        np.add.at(on_units, unit, -np.hstack((force, moments[1])))
        on_shoes[:, 3:] = rotations.moments_on_angles(bodies.shoes[:, 3:], on_shoes[:, 3:])
        modal = np.zeros(self._modal_shape)
        if modal.size:
            bent = self._row[shoe] >= 0
            R = rotations.rotation_matrices(bodies.shoes[shoe[bent], 3:])
            local = np.einsum("nji,nj->ni", R, force[bent])
            np.add.at(modal, self._row[shoe[bent]], np.einsum("ncm,nc->nm", modes[bent], local))
        return np.concatenate((on_shoes.ravel(), self.coordinates.project(on_units), modal.ravel()))

    def results(
        self, q: np.ndarray, q_t: np.ndarray, wrenches: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Contacts at states; see `GroundContact`.

        `wrenches` are not needed: the forces in motion are these.
        """
        counts = np.zeros(len(q), dtype=int)
        parts = [np.zeros((0, pairs.RESULTS))]
        for first in range(0, len(q), STATES_AT_ONCE):
            states = slice(first, first + STATES_AT_ONCE)
            bodies = self.bodies_at(q[states], q_t[states])
            rows = np.empty((len(bodies.shoes), self.greatest_count, pairs.RESULTS))
            pair_stiffness.touching_over_time(
                bodies, self.geometry, self._contacts, self._work, rows, counts[states]
            )
            has = np.arange(self.greatest_count) < counts[states, None]
            parts.append(rows[has])
        results = np.concatenate(parts)
        # strips of an underside, and one with holes, have their places in the rectangle that is met
        results[:, pairs.RESULT["area"]] *= self._ground_share
        return results, counts

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Height (m) of the ground along the track's middle at places x (m), with the springs free."""
        return self._terrain.surface(x)


GroundContact = PairGroundContact | sphere_contact.SphereGroundContact | CellGroundContact
"""Contacts between all shoes and the ground, read off a state: which there are, and the ground's `surface`.

The coordinates q, with rates q_t: six a shoe (COM displacement from `shoe_reference` and angles), the
terrain's as `coordinates` has them, the flexible shoes' modes. `results` takes states (times, size), with a
third argument (times, ...) where they store what does not follow from these. It gives the contacts of all
times, one after the other (contacts, RESULTS), with columns as in `pairs.RESULT`, and their numbers (times,).
"""


def ground_contact(
    case: Case, underside: Underside | None = None, flexible_shoes: Sequence[int] = ()
) -> GroundContact:
    """Contact of a case by the model that it names; flexible shoes as for `PairGroundContact`."""
    if isinstance(case.terrain, CellTerrain):
        return CellGroundContact(case)
    coordinates = terrain_coordinates(case)
    if isinstance(coordinates, UnitCoordinates) and case.contact.model == "spheres":
        return sphere_contact.SphereGroundContact(case, coordinates)
    of_case = case.shoe_reference, case.shoe, case.part(Terrain), case.part(PairContact)
    return PairGroundContact(*of_case, coordinates, underside, flexible_shoes)
