"""A system as tables: bodies, markers, joints and force elements, and the workspace of its equations.

Compiled code takes them as plain tuples (`ground.frames.plain`) and names them again. What a case has none of
is None: compiled code of it is left out.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.cells.kernel import ShoePoints
from exudyn_crawler.ground.frames import Vector, inlined, plain
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_stiffness import UnitContacts
from exudyn_crawler.ground.rotations import FloatArray, ForceRows, IntArray
from exudyn_crawler.model.bodies import Bodies, Modes
from exudyn_crawler.model.elimination import Fronts
from exudyn_crawler.model.forces.cells import CellTable, CellWorkspace
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.forces.teeth import Teeth, TeethWorkspace
from exudyn_crawler.model.forces.units import TerrainTable, UnitWorkspace
from exudyn_crawler.model.forces.wheels import Wheels, WheelWorkspace
from exudyn_crawler.model.joints import PULLED, ROWS, ClosedJoints, Joints, Markers, Pull


class FrontRows(NamedTuple):
    """Where in the fronts of the elimination the terms of the equations go."""

    # (fronts, bodies): row of a body's first coordinate in a front, -1 where the front has none; modes follow
    body: IntArray
    front: IntArray  # (bodies,): front in which a body is eliminated
    terrain: IntArray  # (fronts,): row of the terrain's first coordinate
    multiplier: IntArray  # (fronts, multipliers): row of a multiplier


class Tables(NamedTuple):
    """All of a system that does not change."""

    bodies: Bodies
    modes: Modes
    markers: Markers
    joints: Joints
    loads: Loads
    terrain: TerrainTable
    flexible: IntArray  # (2,): first modal coordinate of all, and the number of flexible bodies
    contact: tuple | None  # `pair_geometry.ContactGeometry` of shoes and units
    fronts: Fronts  # order of the elimination
    rows: FrontRows
    pull: Pull | None  # what the drive pulls; without it the drive's force acts at its marker alone
    cells: CellTable | None  # undersides of the shoes on ground of cells
    closed: ClosedJoints | None = None  # of a closed track
    teeth: Teeth | None = None
    wheels: Wheels | None = None  # of a side frame, on the shoes

    @property
    def multiplier_count(self) -> int:
        """Number of multipliers: of pins, drive, turn, holds and motors."""
        motors = 0 if self.closed is None else len(self.closed.motors)
        return ROWS * len(self.joints.pins) + 2 + len(self.joints.holds) + motors


class Inputs(NamedTuple):
    """What time makes of loads and drive."""

    gravity: Vector  # m/s2, global
    loads: FloatArray  # (loads, 6): forces (N) and moments (N m), global
    shift: float  # how far those that shift act to the left of their places, m
    active: FloatArray  # (2,): whether drive and turn act, 1 or 0
    speeds: FloatArray  # (2,): of drive and turn, m/s and rad/s
    drag: FloatArray  # (wheels,): rolling resistance over normal force, with the sign of the speed
    motors: FloatArray = np.zeros(0)  # (motors,): speeds of the tumblers against their frames, rad/s


class Workspace(NamedTuple):
    """What a residual leaves for the matrix and for the next one."""

    first: FloatArray  # (bodies, ...): this and the next two are the `Inertia` of every body
    second: FloatArray
    turning: FloatArray
    gap: FloatArray  # (multipliers,): of the constraints, m, rad and their rates
    jacobian: FloatArray  # (multipliers, 2, 6 + modes): of the gaps, by the coordinates of their bodies
    pulled: IntArray  # (PULLED,): bodies of the pull
    pull: FloatArray  # (PULLED, 6 + modes): its directions
    elements: tuple  # `ForceRows` of contacts with units, lugs, wheels, and of shoes on cells, two kinds
    counts: IntArray  # (5,): how many there are of each
    units: tuple  # workspaces of these
    cells: tuple | None
    motors: FloatArray  # (motors, 2, 3): of frame and tumbler, as of `joints.motor_speed`
    turned: FloatArray  # (pins, 2, 3, 3): as of `joints.write_turned`; none of an open track on units
    teeth: tuple | None
    wheels: tuple | None

    @classmethod
    def allocate(cls, tables: Tables, contacts: int, shoes: ShoePoints | None = None) -> tuple:
        """Workspace of a system with at most so many contacts, or with shoes on cells, as plain tuples."""
        count, m = len(tables.bodies.mass), len(tables.modes.stiffness)
        reference, teeth, wheels = tables.terrain.reference, tables.teeth, tables.wheels
        motors = 0 if tables.closed is None else len(tables.closed.motors)
        touching, forces = UnitContacts.allocate(contacts, m), np.zeros((len(reference), 2))
        rates, scratch = np.zeros_like(reference), overlap_workspace()
        others = (
            teeth and TeethWorkspace.allocate(len(teeth.markers), m),
            wheels and WheelWorkspace.allocate(wheels, m),
        )
        turns = tables.closed is not None or tables.cells is not None
        cells = tables.cells and shoes and CellWorkspace.allocate(tables.cells, shoes)
        none = ForceRows.allocate(0, 1, m)
        on_cells = (cells.rigid, cells.flexible) if cells else (none, none)
        elements = touching.rows, *(one.rows if one else none for one in others), *on_cells
        return plain(
            cls(
                np.zeros((count, 3)),
                np.zeros((count, 3, 3)),
                np.zeros((count, 3, m)),
                np.zeros(tables.multiplier_count),
                np.zeros((tables.multiplier_count, 2, 6 + m)),
                np.zeros(PULLED, dtype=np.int64),
                np.zeros((PULLED, 6 + m)),
                tuple(tuple(one) for one in elements),
                np.array([0, 0, 0, *(len(rows[1]) for rows in on_cells)]),
                UnitWorkspace(reference.copy(), rates, forces, touching, scratch),
                cells,
                np.zeros((motors, 2, 3)),
                np.zeros((len(tables.joints.pins) if turns else 0, 2, 3, 3)),
                *others,
            )
        )


@inlined
def named_tables(values: tuple) -> Tables:
    """Tables of their values as plain tuples, which Python hands over in less time."""
    bodies, modes, markers, joints, loads, terrain, flexible, contact, fronts, rows = values[:10]
    return Tables(
        Bodies(*bodies),
        Modes(*modes),
        Markers(*markers),
        Joints(*joints),
        Loads(*loads),
        TerrainTable(*terrain),
        flexible,
        contact,
        Fronts(*fronts),
        FrontRows(*rows),
        *values[10:],
    )
