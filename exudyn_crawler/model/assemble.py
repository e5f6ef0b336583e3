"""Assembly of a case's tables: its gear names the parts, and the ground lies below."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case, CellTerrain
from exudyn_crawler.ground import packed
from exudyn_crawler.ground.contact import GroundContact, PairGroundContact, ground_contact
from exudyn_crawler.ground.pair_geometry import ContactGeometry
from exudyn_crawler.ground.terrain import TerrainModes, reduced_coordinates
from exudyn_crawler.model import shoe_mesh
from exudyn_crawler.model.assembler import Assembler
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe
from exudyn_crawler.model.forces.units import UnitTable
from exudyn_crawler.model.fronts import fronts_of
from exudyn_crawler.model.kinds import Forces
from exudyn_crawler.model.parts import add_part
from exudyn_crawler.model.tables import Search, Tables
from exudyn_crawler.model.terrain import TerrainTable


class Assembly(NamedTuple):
    """Multibody system of a case before its compilation or its conversion to items of Exudyn."""

    floating: FloatingShoe | None
    point: shoe_mesh.DrivePoint
    contact: GroundContact
    tables: Tables
    bodies: tuple[str, ...]  # names of the bodies beside the shoes
    rows: tuple[tuple[str, int], ...]  # names of the joints, and number of multipliers of each


def assemble(case: Case) -> Assembly:
    """Assemble the parts of a case's machine with the ground below."""
    floating = None if case.flexible is None else floating_shoe(case)
    flexible = () if case.flexible is None else case.flexible.shoes
    bends = case.track.shoe_count in flexible
    point = shoe_mesh.drive_point(case, floating.reduced if floating is not None and bends else None)
    underside = None if floating is None else floating.underside
    contact = ground_contact(case, underside, [number - 1 for number in flexible])
    coordinates = contact.coordinates
    modes = coordinates if isinstance(coordinates, TerrainModes) else reduced_coordinates(case)
    assembler = Assembler(case, floating, point, modes.size)
    for part in case.gear.parts:
        add_part(part, assembler)
    tables = _tables_of(assembler, contact, modes)
    bodies = tuple(body.name for body in assembler.bodies[assembler.shoes :])
    return Assembly(floating, point, contact, tables, bodies, assembler.row_names)


def _tables_of(assembler: Assembler, contact: GroundContact, modes: TerrainModes) -> Tables:
    """Return the tables of the assembled parts and of the ground."""
    geometry = packed.nothing(ContactGeometry)
    reference = np.zeros((0, 4))
    if isinstance(contact, PairGroundContact):
        geometry = contact.geometry
        reference = contact.unit_reference
    terrain = TerrainTable(
        modes.heave,
        modes.tilt,
        reference,
        np.ascontiguousarray(modes.stiffness),
        np.ascontiguousarray(modes.damping),
        modes.weight,
        6 * assembler.shoes,
    )
    units = UnitTable(geometry, assembler.first_modal, int(assembler.flexible.sum()))
    bodies = assembler.table_of_bodies()
    fronts, rows = fronts_of(assembler, bodies, list(range(terrain.first, terrain.first + modes.size)))
    return Tables(
        bodies=bodies,
        modes=assembler.modes,
        markers=assembler.table_of_markers(),
        joints=assembler.tables_of_joints(),
        loads=assembler.table_of_loads(),
        terrain=terrain,
        forces=Forces(units, assembler.cells, assembler.teeth, assembler.wheels, assembler.arms),
        multipliers=sum(count for _, count in assembler.row_names),
        fronts=fronts,
        rows=rows,
        search=search_of(assembler.case),
    )


def search_of(case: Case) -> Search:
    """Return the search of a case's steps.

    On cells, rows that load or unload change their stiffness by a factor of forty. Under dragged shoes an old
    matrix leaves 0.02 of such a residual in the median and seldom over 0.13, whatever the first correction
    left; up to 1 where points return. Under wheels a new matrix costs more than it saves, unless the
    contraction with the old one, known within a factor of ten, predicts failure. In a closed track a new
    matrix takes about as long as three iterations.
    """
    on_cells = isinstance(case.terrain, CellTerrain)
    rolls = bool(case.gear.bodies)
    slower = 10.0 if rolls else 1.0
    return Search(
        least=0.15 if on_cells and not rolls else 0.0,
        slower=slower if on_cells else 0.0,
        ahead=3 if case.gear.loops else 0,
        guards=case.gear.pin_play is not None,
    )
