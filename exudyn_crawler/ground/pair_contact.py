"""Pair contact of the whole track as functions of the generalized coordinates."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import PairContact, Shoe, Terrain
from exudyn_crawler.ground.coordinates import TerrainCoordinates
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.grid import grid_of, units_below
from exudyn_crawler.ground.laws import COULOMB, IMPACT, Law
from exudyn_crawler.ground.laws.coulomb import Coulomb
from exudyn_crawler.ground.laws.impact import Impact
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_derivatives import PAIR_COORDINATES, pair_derivatives
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.pair_sums import Sums, pair_forces
from exudyn_crawler.ground.pair_track import Bodies, Flexible, Track
from exudyn_crawler.ground.pairs import Footprint, PairLaw
from exudyn_crawler.ground.rows import Weights as RowWeights
from exudyn_crawler.ground.triplets import PairBlocks, Weights, modal_triplets
from fem.patches import Underside

NO_DERIVATIVES = RowWeights(0.0, 0.0, 0.0, False, 1.0)
"""Of forces alone."""


def pair_law(law: PairContact, underside_area: float) -> PairLaw:
    """Law of a pair; `underside_area` (m2) is that of a shoe."""
    return PairLaw(
        Law(
            normal=IMPACT,
            friction=COULOMB,
            impact=Impact(law.stiffness, law.exponent, law.damping, law.damping_depth),
            coulomb=Coulomb(
                law.static_friction, law.dynamic_friction, law.stiction_speed, law.friction_speed
            ),
        ),
        edge_width=law.edge_width,
        whole_area=underside_area if law.sharing == "area" else 0.0,
    )


class PairGroundContact:
    """Contact by one contact for every pair of a shoe and a unit; a `contact.GroundContact`.

    Parameters
    ----------
    com_positions : array (shoes, 3)
        COMs of the shoes where their coordinates are zero, m, global.
    shoe : Shoe
        What all of them are.
    terrain : Terrain
        Grid of units.
    law : PairContact
        Contact law of every pair.
    coordinates : TerrainCoordinates
        Formulation of the terrain; flexible shoes need one with shapes.
    underside : Underside, optional
        Integrated modes of the flexible shoes' underside.
    flexible_shoes : sequence of int
        Indices (from 0) of the flexible shoes.

    Raises
    ------
    ValueError
        If there are flexible shoes and the units have coordinates of their own.
    """

    spheres = None

    def __init__(
        self,
        com_positions: NDArray,
        shoe: Shoe,
        terrain: Terrain,
        law: PairContact,
        coordinates: TerrainCoordinates,
        underside: Underside | None = None,
        flexible_shoes: Sequence[int] = (),
    ) -> None:
        if flexible_shoes and coordinates.shapes is None:
            raise ValueError(
                "coordinates must be the terrain's independent ones where shoes are flexible, "
                "got the units' own"
            )
        shoes, units = len(com_positions), terrain.unit_count
        if underside is None:
            underside = Underside(np.zeros(2), np.ones(2), np.zeros((2, 2, 3, 0)))
        modes = underside.mode_count
        row = np.full(shoes, -1)
        row[list(flexible_shoes)] = np.arange(len(flexible_shoes))
        self.coordinates = coordinates
        self.shoe_reference = np.hstack((com_positions, np.zeros((shoes, 3))))
        self.unit_reference = np.hstack((terrain.centers, terrain.tilts[:, None]))
        self._law = law
        self._row = row
        self._grid = grid_of(terrain)
        track = Track(
            self._grid,
            Footprint(*shoe.footprint.tolist()),
            Flexible(underside.corner, underside.cell, underside.integral, row),
            pair_law(law, shoe.length * shoe.width),
        )
        self._track = plain(track)
        # units that a shoe's outline can meet at once, at any yaw
        diagonal = float(np.hypot(shoe.length, shoe.width))
        reach = (int(diagonal / terrain.unit_length) + 2) * (int(diagonal / terrain.unit_width) + 2)
        contacts = shoes * min(reach, units)
        # every evaluation reuses this memory
        self._displacements = np.zeros((units, 4))
        self._unit_rates = np.zeros((units, 4))
        self._sums = Sums(
            np.zeros((shoes, 6)),
            np.zeros((units, 6)),
            np.zeros((len(flexible_shoes), modes)),
        )
        self._contacts = UnitContacts.allocate(contacts, modes)
        self._blocks = PairBlocks(
            np.zeros((contacts, 2), dtype=np.int64),
            np.zeros((contacts, PAIR_COORDINATES, PAIR_COORDINATES)),
            np.zeros((contacts, 3, modes)),
        )
        self._work = overlap_workspace()
        self._first_modal = self.shoe_reference.size + coordinates.size

    @property
    def track(self) -> tuple:
        """`pair_track.Track` as plain tuples."""
        return self._track

    @property
    def flexible_rows(self) -> NDArray:
        """Row of every shoe in the modal coordinates, -1 for a rigid one: array (shoes,) of int."""
        return self._row

    @property
    def greatest_count(self) -> int:
        """Number of contacts that there can be at once."""
        return len(self._contacts.results)

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, the terrain's, the flexible shoes' modes."""
        return self._first_modal + self._sums.modal.size

    def _bodies(self, q: NDArray, q_t: NDArray) -> Bodies:
        """Places of all bodies, as the coordinates have them."""
        split, modal = self.shoe_reference.size, self._first_modal
        last = modal + self._sums.modal.size
        self.coordinates.motion(q[split:modal], self._displacements)
        self.coordinates.motion(q_t[split:modal], self._unit_rates)
        return Bodies(
            self.shoe_reference + q[:split].reshape(-1, 6),
            q_t[:split].reshape(-1, 6),
            self.unit_reference + self._displacements,
            self._unit_rates,
            q[modal:last].reshape(self._sums.modal.shape),
            q_t[modal:last].reshape(self._sums.modal.shape),
        )

    def forces(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized contact forces: array (size,)."""
        bodies = self._bodies(q, q_t)
        pair_forces(tuple(bodies), self._track, tuple(self._sums), self._work)
        generalized = np.empty(self.size)
        split, modal = self.shoe_reference.size, self._first_modal
        generalized[:split] = self._sums.shoes.ravel()
        self.coordinates.project(self._sums.units, bodies.units, generalized[split:modal])
        generalized[modal:] = self._sums.modal.ravel()
        return generalized

    def derivatives(self, q: NDArray, q_t: NDArray, weights: Weights) -> NDArray:
        """Triplets (row, column, value) of both derivatives of the forces, as of `GroundContact`."""
        bodies = tuple(self._bodies(q, q_t))
        count = pair_derivatives(bodies, self._track, weights.typed(), tuple(self._blocks), self._work)
        pairs, values, rows = self._blocks
        found = PairBlocks(pairs[:count], values[:count], rows[:count])
        triplets = self.coordinates.derivative(found, len(self.shoe_reference))
        shapes = self.coordinates.shapes
        if not self._sums.modal.size or shapes is None:
            return triplets
        modal = modal_triplets(tuple(shapes), tuple(found), self._row, self._first_modal)
        return np.concatenate((triplets, modal))

    def results(self, q: NDArray, q_t: NDArray, shoe_forces: NDArray | None = None) -> NDArray:
        """Contacts at a state: array (contacts, RESULTS), columns as in `pairs.RESULT`.

        `shoe_forces` are not needed: the forces in motion are these.
        """
        bodies = tuple(self._bodies(q, q_t))
        count = touching_pairs(bodies, self._track, tuple(NO_DERIVATIVES), tuple(self._contacts), self._work)
        return self._contacts.results[:count].copy()

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        out = np.zeros_like(self.unit_reference)
        self.coordinates.motion(q[self.shoe_reference.size : self._first_modal], out)
        return out

    def settled_depth(self, loads: NDArray) -> NDArray:
        """Penetration (m) of shoes that each stand on one unit under these loads (N)."""
        return (np.maximum(loads, 0.0) / self._law.stiffness) ** (1.0 / self._law.exponent)

    def ground_below(self, q: NDArray, heights: NDArray) -> NDArray:
        """Height (m) of the ground below each shoe's COM, of the units' heights: array (shoes,)."""
        shoes = self.shoe_reference[:, :2] + q[: self.shoe_reference.size].reshape(-1, 6)[:, :2]
        return heights[units_below(self._grid, shoes)]

    def sunken(self, q: NDArray) -> list[int]:
        """None: the law pushes a shoe up from any depth."""
        return []
