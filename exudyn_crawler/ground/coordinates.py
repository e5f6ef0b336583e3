"""How the terrain's coordinates carry its units."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.terrain import TerrainModes, localized, terrain_modes, units_near

REACH = 1.0
"""m round the track at t = 0 within which contact is expected."""
UNIT_COORDINATES = 6
"""Coordinates of a unit that is a body: position and angles."""


@compiled
def _modal_motion(heave, tilt, q, out):
    for u in range(heave.shape[0]):
        z = a = 0.0
        for k in range(heave.shape[1]):
            z += heave[u, k] * q[k]
            a += tilt[u, k] * q[k]
        out[u, 2], out[u, 3] = z, a


@dataclass(frozen=True)
class ReducedCoordinates:
    """Terrain carried by its independent coordinates."""

    modes: TerrainModes
    tilt_axis: int

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.modes.size

    def motion(self, q: NDArray) -> NDArray:
        """Displacement (x, y, z) and tilt of the units, or their rates: array (units, 4), m and rad."""
        units = np.zeros((len(self.modes.heave), 4))
        _modal_motion(self.modes.heave, self.modes.tilt, q, units)
        return units

    def project(self, wrenches: NDArray) -> NDArray:
        """Generalized forces (size,) of forces and moments on the units (units, 6)."""
        heave, tilt = wrenches[:, 2], wrenches[:, 3 + self.tilt_axis]
        return np.asarray(heave @ self.modes.heave + tilt @ self.modes.tilt)

    def sunk_evenly(self, heave: float) -> NDArray:
        """Coordinates (size,) at which all units heave by the same (m) and none tilts.

        A combination of the modes, since the units meet at one height everywhere.
        """
        shapes = np.vstack((self.modes.heave, self.modes.tilt))
        return np.linalg.lstsq(shapes, np.repeat([heave, 0.0], len(self.modes.heave)), rcond=None)[0]


@dataclass(frozen=True)
class UnitCoordinates:
    """Terrain whose units are rigid bodies with six coordinates each; all but their tilt is held."""

    unit_count: int
    tilt_axis: int

    @property
    def size(self) -> int:
        """Six coordinates a unit."""
        return UNIT_COORDINATES * self.unit_count

    def motion(self, q: NDArray) -> NDArray:
        """As of `ReducedCoordinates`."""
        bodies = q.reshape(self.unit_count, UNIT_COORDINATES)
        return np.column_stack((bodies[:, :3], bodies[:, 3 + self.tilt_axis]))

    def project(self, wrenches: NDArray) -> NDArray:
        """As of `ReducedCoordinates`; moments beside the tilt's only load what holds the units."""
        return wrenches.ravel()

    def sunk_evenly(self, heave: float) -> NDArray:
        """As of `ReducedCoordinates`."""
        bodies = np.zeros((self.unit_count, UNIT_COORDINATES))
        bodies[:, 2] = heave
        return bodies.ravel()


TerrainCoordinates = ReducedCoordinates | UnitCoordinates


def reduced_coordinates(case: Case) -> ReducedCoordinates:
    """Independent coordinates of a case's terrain, of which the track moves as few as possible."""
    near = units_near(case.terrain, case.outline(0.0), REACH)
    return ReducedCoordinates(localized(terrain_modes(case.terrain), near), case.terrain.tilt_axis)


def terrain_coordinates(case: Case) -> TerrainCoordinates:
    """Coordinates of a case's terrain; Exudyn's contact of spheres needs the units as bodies."""
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        return UnitCoordinates(case.terrain.unit_count, case.terrain.tilt_axis)
    return reduced_coordinates(case)
