"""How the terrain's coordinates carry the contact: motion of the units, forces, derivatives.

The coordinates are those of the shoes (six each), then the terrain's, then the flexible shoes' modes.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.rotations import generalized_moment, tilted
from exudyn_crawler.ground.terrain import TerrainModes
from exudyn_crawler.ground.triplets import PairBlocks, Shapes, body_triplets, terrain_triplets

UNIT_COORDINATES = 6
"""Coordinates of a unit in the constrained formulation: position and angles about x, y, z."""


class TerrainCoordinates(Protocol):
    """How a formulation of the terrain carries the units' motion."""

    @property
    def size(self) -> int:
        """Number of terrain coordinates."""
        ...

    @property
    def shapes(self) -> Shapes | None:
        """Heave and tilt of the units by these coordinates; None where they are the units' own."""
        ...

    def sunk_evenly(self, heave: float) -> NDArray:
        """Coordinates (size,) at which all units heave by the same (m) and none tilts."""
        ...

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Write displacement (x, y, z) and tilt of the units, or their rates, into `out` (units, 4)."""
        ...

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Write generalized terrain forces of the units' forces and moments (units, 6) into `out`.

        `units` (units, 4) are their places.
        """
        ...

    def derivative(self, blocks: PairBlocks, shoe_count: int) -> NDArray:
        """Triplets (row, column, value) of pair blocks in the shoes' and these coordinates."""
        ...


@compiled
def _modal_motion(heave, tilt, q, out):
    for u in range(heave.shape[0]):
        z = 0.0
        a = 0.0
        for k in range(heave.shape[1]):
            z += heave[u, k] * q[k]
            a += tilt[u, k] * q[k]
        out[u, 2] = z
        out[u, 3] = a


@compiled
def _modal_project(heave, tilt, tilt_axis, unit_forces, out):
    out.fill(0.0)
    for u in range(heave.shape[0]):
        force, moment = unit_forces[u, 2], unit_forces[u, 3 + tilt_axis]
        if force != 0.0 or moment != 0.0:
            for k in range(heave.shape[1]):
                out[k] += heave[u, k] * force + tilt[u, k] * moment


@dataclass(frozen=True)
class ReducedCoordinates:
    """Terrain carried by its independent coordinates.

    `reached` of them, the first ones, move the units that the track is expected to touch.
    """

    modes: TerrainModes
    tilt_axis: int
    reached: int

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.modes.size

    @property
    def shapes(self) -> Shapes:
        """Heave and tilt of the units."""
        return Shapes(self.modes.heave, self.modes.tilt, self.reached)

    def sunk_evenly(self, heave: float) -> NDArray:
        """A combination of the modes, since the units meet at one height everywhere."""
        shapes = np.vstack((self.modes.heave, self.modes.tilt))
        units = len(self.modes.heave)
        return np.linalg.lstsq(shapes, np.repeat([heave, 0.0], units), rcond=None)[0]

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Heave and tilt of the units; there is no other motion."""
        _modal_motion(self.modes.heave, self.modes.tilt, q, out)

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Generalized forces."""
        _modal_project(self.modes.heave, self.modes.tilt, self.tilt_axis, unit_forces, out)

    def derivative(self, blocks: PairBlocks, shoe_count: int) -> NDArray:
        """Triplets in a pattern that rarely changes, so that factorizations can reuse it."""
        return terrain_triplets(tuple(self.shapes), tuple(blocks), shoe_count)


@compiled
def _body_project(unit_forces, units, tilt_axis, out):
    for u in range(units.shape[0]):
        force = unit_forces[u]
        moment = generalized_moment((force[3], force[4], force[5]), tilted(units[u, 3], tilt_axis))
        for k in range(3):
            out[6 * u + k] = force[k]
            out[6 * u + 3 + k] = moment[k]


@dataclass(frozen=True)
class ConstrainedCoordinates:
    """Terrain carried by rigid bodies with six coordinates each."""

    unit_count: int
    tilt_axis: int

    @property
    def size(self) -> int:
        """Six coordinates a unit."""
        return UNIT_COORDINATES * self.unit_count

    @property
    def shapes(self) -> None:
        """None: the units have coordinates of their own."""
        return

    def sunk_evenly(self, heave: float) -> NDArray:
        """The units' heights."""
        bodies = np.zeros((self.unit_count, UNIT_COORDINATES))
        bodies[:, 2] = heave
        return bodies.ravel()

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Displacement and the one angle that the units keep."""
        bodies = q.reshape(self.unit_count, UNIT_COORDINATES)
        out[:, :3] = bodies[:, :3]
        out[:, 3] = bodies[:, 3 + self.tilt_axis]

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Forces and generalized moments of the bodies."""
        _body_project(unit_forces, units, self.tilt_axis, out)

    def derivative(self, blocks: PairBlocks, shoe_count: int) -> NDArray:
        """Triplets of the pairs; their small dependence on the units' x and y is left out."""
        return body_triplets(tuple(blocks), shoe_count, self.tilt_axis)
