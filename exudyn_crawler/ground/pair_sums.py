"""Sums of the pairs' forces over a whole track."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.pair_overlaps import below, standing
from exudyn_crawler.ground.pair_track import (
    STATE,
    bend,
    contact_at,
    forces_of,
    gather,
    named,
    patch_rectangle,
    patch_rows,
)
from exudyn_crawler.ground.pairs import FROM_CURVE
from exudyn_crawler.ground.rotations import FloatArray


class Sums(NamedTuple):
    """Where the forces of all contacts are added up.

    Attributes
    ----------
    shoes : array (shoes, 6)
        Generalized forces on the shoes' coordinates (N, N m).
    units : array (units, 6)
        Force (N) and moment about the centre (N m) on each unit, global.
    modal : array (flexible shoes, modes)
        Modal forces.
    """

    shoes: FloatArray
    units: FloatArray
    modal: FloatArray


@compiled
def pair_forces(places: tuple, model: tuple, out: tuple, work: FloatArray) -> int:
    """Add up the forces of all contacts between the shoes and the terrain's units.

    Parameters
    ----------
    places, model, out : tuple
        `Bodies`, `Track` and `Sums` as plain tuples; what is in `out` is overwritten.
    work : array (2, VERTICES, 3)
        Scratch memory as of `overlap_workspace`.

    Returns
    -------
    int
        Number of contacts.
    """
    bodies, track = named(places, model)
    sums = Sums(*out)
    sums.shoes.fill(0.0)
    sums.units.fill(0.0)
    sums.modal.fill(0.0)
    state = np.empty((2, STATE))
    rows = np.empty((3, bodies.modal.shape[1]))
    count = 0
    for s in range(bodies.shoes.shape[0]):
        shoe = standing(bodies, track, s)
        f = shoe.row
        for k in range(shoe.cells.columns * shoe.cells.rows):
            u, unit, part = below(bodies, track, shoe, k, work)
            if part.area <= 0.0:
                continue
            gather(bodies, s, u, state)
            if f >= 0:
                patch_rows(patch_rectangle(part, shoe.frame, unit, track), track, rows)
                bend(bodies, f, rows, state)
            contact = contact_at(part, shoe.frame, unit, state, track, FROM_CURVE)
            forces = forces_of(contact, shoe.frame, unit, shoe.at)
            count += 1
            for c in range(3):
                sums.shoes[s, c] += forces.shoe.force[c]
                sums.shoes[s, 3 + c] += forces.shoe.moment[c]
                sums.units[u, c] += forces.unit.force[c]
                sums.units[u, 3 + c] += forces.unit.moment[c]
            if f >= 0:
                for m in range(rows.shape[1]):
                    for c in range(3):
                        sums.modal[f, m] += rows[c, m] * forces.patch[c]
    return count
