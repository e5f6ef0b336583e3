"""Contact of shoes with the units of the terrain, which carry their forces into the terrain's coordinates."""

from typing import NamedTuple

from exudyn_crawler.ground import pair_geometry, pair_stiffness, rotations
from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, IntArray
from exudyn_crawler.ground.terrain import modal_motion
from exudyn_crawler.model import bodies


class TerrainTable(NamedTuple):
    """Terrain in its own coordinates, whose mass is 1."""

    heave: Floats2  # (units, coordinates): of the units by the coordinates
    tilt: Floats2
    reference: Floats2  # (units, 4): where the units are with free springs
    stiffness: Floats2  # (coordinates, coordinates): of the supports, 1/s2
    damping: Floats2  # of the supports, 1/s
    weight: Floats1  # (coordinates,): load of a unit of gravity
    first: int  # number of the first coordinate


class UnitWorkspace(NamedTuple):
    """Workspace of the contacts."""

    units: Floats2  # (units, 4): places of the units
    rates: Floats2  # (units, 4)
    forces: Floats2  # (units, 2): what acts on their heave and tilt
    contacts: pair_stiffness.UnitContacts
    overlap: Floats3  # scratch of the clipping


@inner(allocates=True)
def unit_contacts(
    bodies: bodies.Bodies,
    flexible: IntArray,
    terrain: TerrainTable,
    geometry: pair_geometry.ContactGeometry,
    state: FloatArray,
    weights: rotations.Weights,
    work: UnitWorkspace,
) -> int:
    """Find the contacts at a state and give their number.

    `flexible` are the number of the first modal coordinate, and how many flexible bodies there are; the shoes
    of `geometry` are the first bodies.
    """
    if terrain.reference.shape[0] == 0:
        return 0
    modal_motion(terrain.heave, terrain.tilt, state[0, terrain.first :], work.units)
    modal_motion(terrain.heave, terrain.tilt, state[1, terrain.first :], work.rates)
    for u in range(terrain.heave.shape[0]):
        for k in range(4):
            work.units[u, k] = terrain.reference[u, k] + (work.units[u, k] if k > 1 else 0.0)
    n = geometry.flexible.row.shape[0]
    m = geometry.flexible.integral.shape[3]
    shoes = bodies.reference[:n] + state[0, : 6 * n].reshape((n, 6))
    first, count = flexible[0], flexible[1]
    last = first + count * m
    places = pair_geometry.BodyStates(
        shoes,
        state[1, : 6 * n].reshape((n, 6)),
        work.units,
        work.rates,
        state[0, first:last].reshape((count, m)),
        state[1, first:last].reshape((count, m)),
    )
    # derivatives of what stands negative in the residual
    negative = rotations.Weights(
        -weights.position, -weights.velocity, weights.acceleration, weights.secant, weights.level
    )
    return pair_stiffness.touching_pairs(places, geometry, negative, work.contacts, work.overlap)


@inner
def add_terrain(
    terrain: TerrainTable,
    rows: rotations.ForceRows,
    count: int,
    state: FloatArray,
    gravity: float,
    work: UnitWorkspace,
    residual: FloatArray,
) -> None:
    """Add inertia, supports and weight of the terrain, and the forces of its contacts."""
    first, size = terrain.first, terrain.heave.shape[1]
    for i in range(size):
        force = state[2, first + i] + gravity * terrain.weight[i]
        for k in range(size):
            force += (
                terrain.stiffness[i, k] * state[0, first + k] + terrain.damping[i, k] * state[1, first + k]
            )
        residual[first + i] += force
    work.forces.fill(0.0)
    for p in range(count):
        for c in range(2):
            for r in range(rows.wrench.shape[1]):
                work.forces[rows.unit[p], c] += rows.unit_jacobian[p, r, c] * rows.wrench[p, r]
    for u in range(work.forces.shape[0]):
        heave, tilt = work.forces[u, 0], work.forces[u, 1]
        if heave != 0.0 or tilt != 0.0:
            for k in range(size):
                residual[first + k] -= terrain.heave[u, k] * heave + terrain.tilt[u, k] * tilt
