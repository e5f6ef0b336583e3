"""Sums of the pairs' forces over a whole track."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.grid import cell
from exudyn_crawler.ground.pair_track import (
    STATE,
    Bodies,
    bend,
    cells_below,
    contact_at,
    forces_of,
    gather,
    named_track,
    patch_rows,
)
from exudyn_crawler.ground.pairs import FROM_CURVE, keep, pair_overlap
from exudyn_crawler.ground.rotations import FloatArray, attitude, shoe_frame, tilted, unit_frame


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
    results : array (contacts, RESULTS)
        One row a contact, columns as in `pairs.RESULT`.
    """

    shoes: FloatArray
    units: FloatArray
    modal: FloatArray
    results: FloatArray


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
        Number of contacts; more than ``Sums.results`` has rows where some did not fit in.
    """
    bodies, track, sums = Bodies(*places), named_track(model), Sums(*out)
    sums.shoes.fill(0.0)
    sums.units.fill(0.0)
    sums.modal.fill(0.0)
    state = np.empty((2, STATE))
    rows = np.empty((3, bodies.modal.shape[1]))
    grid = track.grid
    half = (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    count = 0
    for s in range(bodies.shoes.shape[0]):
        f = track.flexible.row[s]
        at = attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
        shoe = shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], at)
        cells = cells_below(shoe, track.footprint, grid)
        for k in range(cells.columns * cells.rows):
            u = cell(grid, cells, k)
            tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
            unit = unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)
            part = pair_overlap(shoe, unit, track.footprint, half, work)
            if part.area <= 0.0:
                continue
            gather(bodies, s, u, state)
            if f >= 0:
                patch_rows(part, shoe, unit, track, rows)
                bend(bodies, f, rows, state)
            contact = contact_at(part, shoe, unit, state, track, FROM_CURVE)
            forces = forces_of(contact, shoe, unit, at)
            if count < sums.results.shape[0]:
                keep(contact, s, u, sums.results[count])
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
