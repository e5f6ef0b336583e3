"""Terrain of units in its independent coordinates: inertia, supports, weight, and forces on units."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2
from exudyn_crawler.ground.rows import Weights


class TerrainTable(NamedTuple):
    """Terrain in coordinates with unit masses."""

    heave: Floats2  # (units, coordinates): of the units by the coordinates
    tilt: Floats2
    reference: Floats2  # (units, 4): where the units are with free springs
    stiffness: Floats2  # (coordinates, coordinates): of the supports, 1/s2
    damping: Floats2  # of the supports, 1/s
    weight: Floats1  # (coordinates,): load of a unit of gravity
    first: int  # number of the first coordinate


@inner
def add_terrain(
    terrain: TerrainTable, state: FloatArray, gravity: float, on_terrain: FloatArray, residual: FloatArray
) -> None:
    """Add inertia, supports and weight of the terrain, and forces (units, 2) on heave and tilt of its units.

    `gravity` is the component along z, m/s2, global.
    """
    first = terrain.first
    size = terrain.heave.shape[1]
    for i in range(size):
        force = state[2, first + i] + gravity * terrain.weight[i]
        for k in range(size):
            force += (
                terrain.stiffness[i, k] * state[0, first + k] + terrain.damping[i, k] * state[1, first + k]
            )
        residual[first + i] += force
    for u in range(on_terrain.shape[0]):
        heave = on_terrain[u, 0]
        tilt = on_terrain[u, 1]
        if heave != 0.0 or tilt != 0.0:
            for k in range(size):
                residual[first + k] -= terrain.heave[u, k] * heave + terrain.tilt[u, k] * tilt


@inner
def add_terrain_matrix(terrain: TerrainTable, weights: Weights, first: int, matrix: FloatArray) -> None:
    """Add the weighted mass, stiffness and damping of the terrain to a matrix, from a row and column on."""
    for i in range(terrain.heave.shape[1]):
        matrix[first + i, first + i] += weights.acceleration
        for k in range(terrain.heave.shape[1]):
            supports = weights.position * terrain.stiffness[i, k] + weights.velocity * terrain.damping[i, k]
            matrix[first + i, first + k] += supports
