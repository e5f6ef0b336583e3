"""Contact of shoes with the units of the terrain, whose forces act on the terrain's coordinates."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import overlap
from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import FloatArray, Floats2, Floats3
from exudyn_crawler.ground.pair_geometry import BodyStates, ContactGeometry
from exudyn_crawler.ground.pair_stiffness import UnitContacts, touching_pairs
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.ground.terrain import modal_motion
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.terrain import TerrainTable


class UnitTable(NamedTuple):
    """Shoes, which are the first bodies, and units in the form of the contact."""

    geometry: ContactGeometry
    first_modal: int  # number of the first modal coordinate of all
    flexible: int  # flexible shoes


class UnitWorkspace(NamedTuple):
    """Workspace of the contacts."""

    units: Floats2  # (units, 4): places of the units
    rates: Floats2  # (units, 4)
    contacts: UnitContacts
    overlap: Floats3  # scratch of the clipping

    @classmethod
    def allocate(cls, terrain: TerrainTable, contacts: int, modes: int) -> "UnitWorkspace":
        """Return a workspace for at most `contacts` contacts."""
        places = terrain.reference.copy()
        touching = UnitContacts.allocate(contacts, modes)
        return cls(
            units=places, rates=np.zeros_like(places), contacts=touching, overlap=overlap.overlap_workspace()
        )


@inner(allocates=True)
def write_rows(
    table: UnitTable,
    terrain: TerrainTable,
    bodies: Bodies,
    state: FloatArray,
    weights: Weights,
    work: UnitWorkspace,
) -> None:
    """Write the rows of the contacts at a state."""
    if terrain.reference.shape[0] == 0:
        return
    modal_motion(terrain.heave, terrain.tilt, state[0, terrain.first :], work.units)
    modal_motion(terrain.heave, terrain.tilt, state[1, terrain.first :], work.rates)
    for u in range(terrain.heave.shape[0]):
        for k in range(4):
            work.units[u, k] = terrain.reference[u, k] + (work.units[u, k] if k > 1 else 0.0)
    shoes = table.geometry.flexible.row.shape[0]
    modes = table.geometry.flexible.integral.shape[3]
    first = table.first_modal
    last = first + table.flexible * modes
    places = BodyStates(
        bodies.reference[:shoes] + state[0, : 6 * shoes].reshape((shoes, 6)),
        state[1, : 6 * shoes].reshape((shoes, 6)),
        work.units,
        work.rates,
        state[0, first:last].reshape((table.flexible, modes)),
        state[1, first:last].reshape((table.flexible, modes)),
    )
    # derivatives of what stands negative in the residual
    negative = Weights(
        -weights.position, -weights.velocity, weights.acceleration, weights.secant, weights.level
    )
    rows = work.contacts.rows
    rows.acting[0] = touching_pairs(places, table.geometry, negative, work.contacts, work.overlap)
