"""A system as tables: bodies, markers, joints and force elements, and the workspace of its equations.

Compiled code reads them in a block of memory (`ground.packed`). What a case has none of has no rows, so that
all cases are compiled as one.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import overlap, packed, pair_geometry, pair_stiffness
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.frames import Vector
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.ground.rotations import ForceRows
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
    body: packed.Ints2
    front: packed.Ints1  # (bodies,): front in which a body is eliminated
    terrain: packed.Ints1  # (fronts,): row of the terrain's first coordinate
    multiplier: packed.Ints2  # (fronts, multipliers): row of a multiplier


class Tables(NamedTuple):
    """All of a system that does not change."""

    bodies: Bodies
    modes: Modes
    markers: Markers
    joints: Joints
    loads: Loads
    terrain: TerrainTable
    flexible: packed.Ints1  # (2,): first modal coordinate of all, and the number of flexible bodies
    contact: pair_geometry.ContactGeometry  # of shoes and units
    fronts: Fronts  # order of the elimination
    rows: FrontRows
    pull: Pull  # what the drive pulls
    cells: CellTable  # undersides of the shoes on ground of cells
    closed: ClosedJoints  # of a closed track
    teeth: Teeth
    wheels: Wheels  # of a side frame, on the shoes

    @property
    def multiplier_count(self) -> int:
        """Number of multipliers: of pins, drive, turn, holds and motors."""
        return ROWS * len(self.joints.pins) + 2 + len(self.joints.holds) + len(self.closed.motors)


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

    first: packed.Floats2  # (bodies, ...): this and the next two are the `Inertia` of every body
    second: packed.Floats3
    turning: packed.Floats3
    gap: packed.Floats1  # (multipliers,): of the constraints, m, rad and their rates
    jacobian: packed.Floats3  # (multipliers, 2, 6 + modes): of the gaps, by the coordinates of their bodies
    pulled: packed.Ints1  # (PULLED,): bodies of the pull, none where nothing pulls
    pull: packed.Floats2  # (PULLED, 6 + modes): its directions
    # contacts with units, lugs, wheels, and shoes on cells, two kinds
    elements: tuple[
        ForceRows,
        ForceRows,
        ForceRows,
        ForceRows,
        ForceRows,
    ]
    counts: packed.Ints1  # (5,): how many there are of each
    units: UnitWorkspace
    teeth: TeethWorkspace
    wheels: WheelWorkspace
    cells: CellWorkspace
    motors: packed.Floats3  # (motors, 2, 3): of frame and tumbler, as of `joints.motor_speed`
    turned: packed.Floats4  # (pins, 2, 3, 3): as of `joints.write_turned`; none of an open track on units

    @classmethod
    def allocate(cls, tables: Tables, contacts: int, shoes: ShoePoints) -> "Workspace":
        """Workspace of a system with at most so many contacts, or with shoes on cells."""
        count, m = len(tables.bodies.mass), len(tables.modes.stiffness)
        reference, motors = tables.terrain.reference, len(tables.closed.motors)
        pulled = PULLED if len(tables.pull.markers) else 0
        touching, forces = pair_stiffness.UnitContacts.allocate(contacts, m), np.zeros((len(reference), 2))
        rates, scratch = np.zeros_like(reference), overlap.overlap_workspace()
        teeth = TeethWorkspace.allocate(len(tables.teeth.markers), m)
        wheels, cells = WheelWorkspace.allocate(tables.wheels, m), CellWorkspace.allocate(tables.cells, shoes)
        elements = touching.rows, teeth.rows, wheels.rows, cells.rigid, cells.flexible
        turns = motors > 0 or len(tables.cells.flexible) > 0
        return cls(
            np.zeros((count, 3)),
            np.zeros((count, 3, 3)),
            np.zeros((count, 3, m)),
            np.zeros(tables.multiplier_count),
            np.zeros((tables.multiplier_count, 2, 6 + m)),
            np.zeros(pulled, dtype=np.int64),
            np.zeros((pulled, 6 + m)),
            elements,
            np.array([0, 0, 0, len(cells.rigid.unit), len(cells.flexible.unit)]),
            UnitWorkspace(reference.copy(), rates, forces, touching, scratch),
            teeth,
            wheels,
            cells,
            np.zeros((motors, 2, 3)),
            np.zeros((len(tables.joints.pins) if turns else 0, 2, 3, 3)),
        )


class System(NamedTuple):
    """Tables and workspace, which compiled code finds in one block."""

    tables: Tables
    work: Workspace


SYSTEM = packed.type_of(System)
read_system = packed.reader(SYSTEM)
