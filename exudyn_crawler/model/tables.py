"""System as tables: bodies, markers, joints and forces, and the workspace of its equations.

Compiled code reads them in a block of memory (`ground.packed`). A kind that a case does not have has no rows,
so that all cases are compiled as one.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import packed
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.model.bodies import Bodies, Modes
from exudyn_crawler.model.elimination import Fronts
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.joints.pin import ROWS
from exudyn_crawler.model.kinds import Forces, ForceWork, Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import JointRows
from exudyn_crawler.model.terrain import TerrainTable


class FrontRows(NamedTuple):
    """Rows of the terms of the equations in the fronts of the elimination."""

    # (fronts, bodies): row of a body's first coordinate in a front, -1 where the front has none; modes follow
    body: packed.Ints2
    front: packed.Ints1  # (bodies,): front in which a body is eliminated
    terrain: packed.Ints1  # (fronts,): row of the terrain's first coordinate
    multiplier: packed.Ints2  # (fronts, multipliers): row of a multiplier


class Search(NamedTuple):
    """Conditions for a new matrix before the old one fails, and guards of changes."""

    least: float  # least share of a residual that it leaves
    slower: float  # what it leaves over what it left last; zero with the first for no such judgement
    ahead: int  # iterations that it may still take at its last rate, zero for any number
    guards: bool  # True: no change by an old matrix raises the residual, and one by a new matrix is halved


class Tables(NamedTuple):
    """Constant data of a system."""

    bodies: Bodies
    modes: Modes
    markers: Markers
    joints: Joints
    loads: Loads
    terrain: TerrainTable
    forces: Forces
    multipliers: int  # of all joints
    fronts: Fronts  # order of the elimination
    rows: FrontRows
    search: Search


class Workspace(NamedTuple):
    """Results of a residual for the matrix and for the next residual."""

    first: packed.Floats2  # (bodies, ...): this and the next two are the `Inertia` of every body
    second: packed.Floats3
    turning: packed.Floats3
    joints: JointRows
    forces: ForceWork
    on_terrain: packed.Floats2  # (units, 2): forces on heave and tilt of the terrain's units

    @classmethod
    def allocate(cls, tables: Tables, contacts: int, shoes: ShoePoints) -> "Workspace":
        """Return the workspace of a system with at most `contacts` contacts, or with shoes on cells."""
        count = len(tables.bodies.mass)
        m = len(tables.modes.stiffness)
        joints = tables.joints
        links = len(joints.plays.markers)
        directed = joints.plays.directed + ROWS * links
        turns = joints.pins.in_plane or joints.pins.follows
        turned = joints.plays.turned + links if turns else 0
        loaded = len(joints.frictions.pins)
        return cls(
            first=np.zeros((count, 3)),
            second=np.zeros((count, 3, 3)),
            turning=np.zeros((count, 3, m)),
            joints=JointRows.allocate(tables.multipliers, directed, turned, loaded, m),
            forces=ForceWork.allocate(tables.forces, tables.terrain, contacts, shoes, m),
            on_terrain=np.zeros((len(tables.terrain.reference), 2)),
        )


class System(NamedTuple):
    """Tables and workspace in one block for compiled code."""

    tables: Tables
    work: Workspace


SYSTEM = packed.type_of(System)
read_system = packed.reader(SYSTEM, Tables, Workspace, Joints, Forces, ForceWork)
