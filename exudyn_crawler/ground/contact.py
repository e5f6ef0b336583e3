"""Contact between shoes and ground: what every model of it does, that of pairs, and the choice of one."""

from collections.abc import Callable, Sequence
from math import prod
from typing import NamedTuple, Protocol

import numpy as np

from exudyn_crawler.case import Case, CellTerrain, PairContact, Shoe, Terrain
from exudyn_crawler.ground import frames, laws, overlap, pairs, rotations
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.pair_geometry import BodyStates, ContactGeometry, Flexible, Outline
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.sphere_contact import SphereGroundContact
from exudyn_crawler.ground.terrain import TerrainCoordinates, UnitCoordinates, grid_of, terrain_coordinates
from fem.patches import Underside

NO_DERIVATIVES = rotations.Weights(0.0, 0.0, 0.0, False, 1.0)
"""Of forces alone."""


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


class ContactWrenches(NamedTuple):
    """Forces (N) and moments about the origins (N m) on shoes and units, global; modal forces."""

    shoes: np.ndarray  # (shoes, 6)
    units: np.ndarray  # (units, 6)
    modal: np.ndarray  # (flexible shoes, modes)


class PairGroundContact:
    """Contact by one contact for every pair of a shoe and a unit; a `GroundContact`.

    `reference` (shoes, 6) are positions of the COMs (m, global) and angles (rad) of the shoes where their
    coordinates are zero, and `unit_reference` (units, 4) centres (m) and tilts of the units with the springs
    free. Shoes of these indices (from 0) are flexible, by the integrated modes of their underside; they need
    terrain by its independent coordinates, or a ValueError says so.
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
        if flexible_shoes and isinstance(coordinates, UnitCoordinates):
            raise ValueError(
                "coordinates must be the terrain's independent ones where shoes are flexible, "
                "got the units' own"
            )
        shoes, units = len(reference), terrain.unit_count
        if underside is None:
            underside = Underside(np.zeros(2), np.ones(2), np.zeros((2, 2, 3, 0)))
        modes = underside.mode_count
        row = np.full(shoes, -1)
        row[list(flexible_shoes)] = np.arange(len(flexible_shoes))
        self.coordinates = coordinates
        self.shoe_reference = reference
        self.unit_reference = np.hstack((terrain.centers, terrain.tilts[:, None]))
        self._law, self._terrain = law, terrain
        self._row = row
        geometry = ContactGeometry(
            Outline(grid_of(terrain), pairs.Footprint(*shoe.footprint.tolist()), shoe.finger_length),
            pair_law(law, shoe.length * shoe.width),
            Flexible(underside.corner, underside.cell, underside.integral, row),
            shoe.fingers,
        )
        self._geometry = frames.plain(geometry)
        # units that a shoe's outline can meet at once, at any yaw
        diagonal = float(np.hypot(shoe.length, shoe.width))
        reach = (int(diagonal / terrain.unit_length) + 2) * (int(diagonal / terrain.unit_width) + 2)
        contacts = shoes * min(reach, units) * (1 + len(shoe.fingers))
        self._contacts = UnitContacts.allocate(contacts, modes)
        self._work = overlap.overlap_workspace()
        self._modal_shape = (len(flexible_shoes), modes)

    @property
    def geometry(self) -> tuple:
        """`pair_geometry.ContactGeometry` as plain tuples."""
        return self._geometry

    @property
    def greatest_count(self) -> int:
        """Number of contacts that there can be at once."""
        return len(self._contacts.results)

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, the terrain's, the flexible shoes' modes."""
        return self.shoe_reference.size + self.coordinates.size + prod(self._modal_shape)

    def bodies(self, shoes: np.ndarray, shoe_rates: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> BodyStates:
        """Places of all bodies, as the contact takes them.

        Of positions (m) and angles (rad) of the shoes (shoes, 6), and of the coordinates `q` of the terrain
        and, behind them, of the modes; and of their rates.
        """
        ground = self.coordinates.size
        modal = slice(ground, ground + prod(self._modal_shape))
        return BodyStates(
            shoes,
            shoe_rates,
            self.unit_reference + self.coordinates.motion(q[:ground]),
            self.coordinates.motion(q_t[:ground]),
            q[modal].reshape(self._modal_shape),
            q_t[modal].reshape(self._modal_shape),
        )

    def bodies_at(self, q: np.ndarray, q_t: np.ndarray) -> BodyStates:
        """Places of all bodies at generalized coordinates and their rates."""
        shoes, rates = (values[: self.shoe_reference.size].reshape(-1, 6) for values in (q, q_t))
        rest = slice(self.shoe_reference.size, None)
        return self.bodies(self.shoe_reference + shoes, rates, q[rest], q_t[rest])

    def _touching(self, bodies: BodyStates) -> tuple[np.ndarray, np.ndarray]:
        """Contacts (contacts, RESULTS), and how modes move their patches (contacts, 3, modes)."""
        count = touching_pairs(
            tuple(bodies), self._geometry, tuple(NO_DERIVATIVES), tuple(self._contacts), self._work
        )
        return self._contacts.results[:count], self._contacts.modes[:count]

    def wrenches(self, bodies: BodyStates) -> "ContactWrenches":
        """Forces of all contacts on the bodies."""
        rows, modes = self._touching(bodies)
        shoe, unit = rows[:, pairs.RESULT["shoe"]].astype(int), rows[:, pairs.RESULT["unit"]].astype(int)
        point = rows[:, pairs.RESULT["point"]]
        force = rows[:, pairs.RESULT["normal_force"]] + rows[:, pairs.RESULT["friction_force"]]
        torque = rows[:, pairs.RESULT["friction_torque"]]
        found = ContactWrenches(
            np.zeros_like(bodies.shoes), np.zeros((len(bodies.units), 6)), np.zeros(self._modal_shape)
        )
        for places, index, sign, out in (
            (bodies.shoes, shoe, 1.0, found.shoes),
            (bodies.units, unit, -1.0, found.units),
        ):
            moment = torque + np.cross(point - places[index, :3], force)
            np.add.at(out, index, sign * np.hstack((force, moment)))
        if found.modal.size:
            bent = self._row[shoe] >= 0
            R = rotations.rotation_matrices(bodies.shoes[shoe[bent], 3:])
            local = np.einsum("nji,nj->ni", R, force[bent])
            np.add.at(found.modal, self._row[shoe[bent]], np.einsum("ncm,nc->nm", modes[bent], local))
        return found

    def forces(self, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
        """Generalized contact forces: array (size,)."""
        bodies = self.bodies_at(q, q_t)
        found = self.wrenches(bodies)
        found.shoes[:, 3:] = rotations.moments_on_angles(bodies.shoes[:, 3:], found.shoes[:, 3:])
        units = self.coordinates.project(found.units)
        return np.concatenate((found.shoes.ravel(), units, found.modal.ravel()))

    def results(self, q: np.ndarray, q_t: np.ndarray, wrenches: np.ndarray | None = None) -> np.ndarray:
        """Contacts at a state: array (contacts, RESULTS), columns as in `pairs.RESULT`.

        `wrenches` are not needed: the forces in motion are these.
        """
        return self._touching(self.bodies_at(q, q_t))[0].copy()

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Height (m) of the ground along the track's middle at places x (m), with the springs free."""
        return self._terrain.surface(x)


class GroundContact(Protocol):
    """Contacts between all shoes and units, read off a state.

    The coordinates q, with rates q_t: six a shoe (COM displacement from `shoe_reference` and angles), the
    terrain's as `coordinates` has them, the flexible shoes' modes.
    """

    coordinates: TerrainCoordinates  # how the terrain's coordinates carry the units
    shoe_reference: np.ndarray  # (shoes, 6): COM positions (m, global) and angles at coordinates of zero

    @property
    def size(self) -> int:
        """Number of generalized coordinates."""
        ...

    @property
    def results(self) -> Callable[..., np.ndarray]:
        """Contacts (contacts, RESULTS), columns as in `pairs.RESULT`, at coordinates and their rates.

        A third argument is what a state has of them, of contact that does not follow from these.
        """
        ...

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Height (m) of the ground along the track's middle at places x (m), before a track stands on it."""
        ...


def ground_contact(
    case: Case, underside: Underside | None = None, flexible_shoes: Sequence[int] = ()
) -> GroundContact:
    """Contact of a case by the model that it names; flexible shoes as for `PairGroundContact`."""
    if isinstance(case.terrain, CellTerrain):
        return CellGroundContact(case)
    coordinates = terrain_coordinates(case)
    if isinstance(coordinates, UnitCoordinates) and case.contact.model == "spheres":
        return SphereGroundContact(case, coordinates)
    return PairGroundContact(
        case.shoe_reference,
        case.shoe,
        case.unit_terrain(),
        case.pair_contact(),
        coordinates,
        underside,
        flexible_shoes,
    )
