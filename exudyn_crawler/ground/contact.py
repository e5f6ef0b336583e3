"""Contact between shoes and ground: the interface of its models, the model of pairs, choice of a model."""

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
    """Return the law of a pair; `underside_area` (m2) is that of a shoe."""
    return pairs.PairLaw(
        laws.Impact(law.stiffness, law.exponent, law.damping, law.damping_depth),
        laws.Coulomb(law.static_friction, law.dynamic_friction, law.stiction_speed, law.friction_speed),
        edge_width=law.edge_width,
        whole_area=underside_area if law.sharing == "area" else 0.0,
        area_normal=law.normal == "area",
        closest_points=law.penetration == "closest",
    )


STATES_AT_ONCE = 64
"""Number of states whose contacts are found in one call, so that the overhead of the call does not matter."""


class PairGroundContact:
    """Model with one contact for every pair of a shoe and a unit; a `GroundContact`.

    `reference` (shoes, 6) holds the positions of the COMs (m, global) and the angles (rad) of the shoes at
    zero coordinates. `unit_reference` (units, 4) holds the centres (m) and tilts (rad) of the units with
    unloaded springs. The shoes `flexible_shoes` (indices from 0) bend by the integrated modes of their
    `underside`; they need a terrain in its independent coordinates.
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
        """Return the poses of all bodies at coordinates (..., size) and their rates, for kernels."""
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
        """Return contacts (contacts, RESULTS) and their patches' motions by modes (contacts, 3, modes)."""
        count = pair_stiffness.touching_pairs(
            bodies, self.geometry, NO_DERIVATIVES, self._contacts, self._work
        )
        return self._contacts.results[:count], self._contacts.modes[:count]

    def forces(self, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
        """Return the generalized contact forces: array (size,)."""
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
        """Return the contacts at states; see `GroundContact`.

        `wrenches` are not needed: this model computes the forces of the simulation from the state.
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
        # an underside of strips or with holes covers only a share of its rectangle
        results[:, pairs.RESULT["area"]] *= self._ground_share
        return results, counts

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Return the ground's height (m) along the track's middle at x (m), with unloaded springs."""
        return self._terrain.surface(x)


GroundContact = PairGroundContact | sphere_contact.SphereGroundContact | CellGroundContact
"""Contacts between all shoes and the ground at a state, and the height of the ground, `surface`.

The coordinates q, with rates q_t, are: six for each shoe (COM displacement from `shoe_reference` and angles),
those of the terrain in the order of `coordinates`, and the modes of the flexible shoes. `results` takes
states (times, size) and a third argument (times, ...) if the model stores values that do not follow from the
state. It returns the contacts of all times, one after the other (contacts, RESULTS), with columns as in
`pairs.RESULT`, and their numbers (times,).
"""


def ground_contact(
    case: Case, underside: Underside | None = None, flexible_shoes: Sequence[int] = ()
) -> GroundContact:
    """Return the contact of a case by the case's model; flexible shoes as for `PairGroundContact`."""
    if isinstance(case.terrain, CellTerrain):
        return CellGroundContact(case)
    coordinates = terrain_coordinates(case)
    if isinstance(coordinates, UnitCoordinates) and case.contact.model == "spheres":
        return sphere_contact.SphereGroundContact(case, coordinates)
    of_case = case.gear.shoe_reference(case), case.shoe, case.part(Terrain), case.part(PairContact)
    return PairGroundContact(*of_case, coordinates, underside, flexible_shoes)
