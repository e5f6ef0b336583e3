"""Pair contact of the whole track as functions of the generalized coordinates."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import PairContact, Shoe, Terrain
from exudyn_crawler.ground.coordinates import ReducedCoordinates, TerrainCoordinates, flexible_triplets
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pairs import (
    PAIR_COORDINATES,
    RESULTS,
    contact_derivatives,
    contact_forces,
)
from fem.patches import Underside


class TrackContact:
    """Contact forces between shoes and terrain as functions of the generalized coordinates.

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
        Formulation of the terrain.
    underside : Underside, optional
        Integrated modes of the flexible shoes' underside.
    flexible_shoes : sequence of int
        Indices (from 0) of the flexible shoes.
    """

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
        shoes, units = len(com_positions), terrain.unit_count
        if underside is None:
            underside = Underside(np.zeros(2), np.ones(2), np.zeros((2, 2, 3, 0)))
        modes = underside.mode_count
        self._flexible_row = np.full(shoes, -1)
        self._flexible_row[list(flexible_shoes)] = np.arange(len(flexible_shoes))
        self._flexible = (underside.corner, underside.cell, underside.integral, self._flexible_row)
        self._modal_shape = (len(flexible_shoes), modes)
        self._modal_forces = np.zeros(self._modal_shape)
        self.coordinates = coordinates
        self.shoe_reference = np.hstack((com_positions, np.zeros((shoes, 3))))
        self.unit_reference = np.hstack((terrain.centers, np.zeros((units, 1))))
        self._tilt_axis = terrain.tilt_axis
        self._grid = np.array(
            [
                terrain.columns,
                terrain.rows,
                terrain.unit_length,
                terrain.unit_width,
                terrain.unit_height,
                *terrain.origin,
            ]
        )
        self._footprint = shoe.footprint
        self._law = law.as_array(shoe.length * shoe.width)
        # units that a shoe's outline can meet at once, at any yaw
        diagonal = float(np.hypot(shoe.length, shoe.width))
        reach = (int(diagonal / terrain.unit_length) + 2) * (int(diagonal / terrain.unit_width) + 2)
        contacts = shoes * min(reach, units)
        # every evaluation reuses this memory
        self._displacements = np.zeros((units, 4))
        self._unit_rates = np.zeros((units, 4))
        self._shoe_forces = np.zeros((shoes, 6))
        self._unit_forces = np.zeros((units, 6))
        self._results = np.zeros((contacts, RESULTS))
        self._pairs = np.zeros((contacts, 2), dtype=np.int64)
        self._patch_rows = np.zeros((contacts, 3, modes))
        self._blocks = np.zeros((contacts, PAIR_COORDINATES, PAIR_COORDINATES))
        self._work = overlap_workspace()

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, the terrain's, the flexible shoes' modes."""
        return self._first_modal + self._modal_forces.size

    @property
    def _first_modal(self) -> int:
        return self.shoe_reference.size + self.coordinates.size

    def _places(self, q: NDArray, q_t: NDArray) -> tuple[NDArray, ...]:
        """Places and rates of shoes and units, modal coordinates and their rates."""
        split, modal = self.shoe_reference.size, self._first_modal
        shoes = self.shoe_reference + q[:split].reshape(-1, 6)
        shoe_rates = q_t[:split].reshape(-1, 6)
        self.coordinates.motion(q[split:modal], self._displacements)
        self.coordinates.motion(q_t[split:modal], self._unit_rates)
        units = self.unit_reference + self._displacements
        bent, bending = (x[modal:].reshape(self._modal_shape) for x in (q, q_t))
        return shoes, shoe_rates, units, self._unit_rates, bent, bending

    def _evaluate(self, q: NDArray, q_t: NDArray) -> tuple[int, NDArray]:
        places = self._places(q, q_t)
        count = contact_forces(
            *places,
            self._flexible,
            self._tilt_axis,
            self._grid,
            self._footprint,
            self._law,
            self._shoe_forces,
            self._unit_forces,
            self._modal_forces,
            self._results,
            self._work,
        )
        return count, places[2]

    def forces(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized contact forces: array (size,)."""
        _, units = self._evaluate(q, q_t)
        generalized = np.empty(self.size)
        split, modal = self.shoe_reference.size, self._first_modal
        generalized[:split] = self._shoe_forces.ravel()
        self.coordinates.project(self._unit_forces, units, generalized[split:modal])
        generalized[modal:] = self._modal_forces.ravel()
        return generalized

    def derivatives(
        self,
        q: NDArray,
        q_t: NDArray,
        position_factor: float,
        velocity_factor: float,
        secant: bool = False,
    ) -> NDArray:
        """Triplets (row, column, value) of the weighted sum of both derivatives of the forces.

        ``position_factor * d(forces)/dq + velocity_factor * d(forces)/dq_t``, array (entries, 3);
        `secant` as for `contact.contact_derivatives`.
        """
        count = contact_derivatives(
            *self._places(q, q_t),
            self._flexible,
            self._tilt_axis,
            self._grid,
            self._footprint,
            self._law,
            position_factor,
            velocity_factor,
            secant,
            self._pairs,
            self._blocks,
            self._patch_rows,
            self._work,
        )
        pairs, blocks = self._pairs[:count], self._blocks[:count]
        triplets = self.coordinates.derivative(pairs, blocks, len(self.shoe_reference))
        if not self._modal_forces.size:
            return triplets
        assert isinstance(self.coordinates, ReducedCoordinates)
        flexible = flexible_triplets(
            self.coordinates.modes.heave,
            self.coordinates.modes.tilt,
            self.coordinates.reached,
            pairs,
            blocks,
            self._patch_rows[:count],
            self._flexible_row,
            self._first_modal,
        )
        return np.concatenate((triplets, flexible))

    def results(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Contacts at a state: array (contacts, RESULTS), columns as in `contact.RESULT`."""
        count, _ = self._evaluate(q, q_t)
        return self._results[:count].copy()

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        out = np.zeros_like(self.unit_reference)
        self.coordinates.motion(q[self.shoe_reference.size : self._first_modal], out)
        return out
