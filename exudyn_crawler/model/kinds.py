"""Kinds of joints and of forces: their tables, their workspaces, and calls of all of them.

A new kind is a file in `joints` or `forces`, and here a field of its table and a call. The equations sum over
rows and do not depend on kinds.
"""

from typing import NamedTuple

from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.compiled import inlined
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.forces import arms, cells, teeth, units, wheels
from exudyn_crawler.model.forces.arms import Arms, ArmWorkspace
from exudyn_crawler.model.forces.cells import CellTable, CellWorkspace
from exudyn_crawler.model.forces.teeth import Teeth, TeethWorkspace
from exudyn_crawler.model.forces.units import UnitTable, UnitWorkspace
from exudyn_crawler.model.forces.wheels import Wheels, WheelWorkspace
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.joints import drive, friction, hold, motor, pin, play, pull, recoil
from exudyn_crawler.model.joints.drive import Speeds
from exudyn_crawler.model.joints.friction import Frictions
from exudyn_crawler.model.joints.hold import Held
from exudyn_crawler.model.joints.motor import Motors
from exudyn_crawler.model.joints.pin import Pins
from exudyn_crawler.model.joints.play import Plays
from exudyn_crawler.model.joints.pull import Pull
from exudyn_crawler.model.joints.recoil import Recoils
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import JointRows, Motion
from exudyn_crawler.model.terrain import TerrainTable


class Joints(NamedTuple):
    """Tables of all kinds of joints."""

    pins: Pins
    plays: Plays
    frictions: Frictions
    drive: Speeds
    pull: Pull
    holds: Held
    motors: Motors
    recoils: Recoils


class Forces(NamedTuple):
    """Tables of all kinds of forces."""

    units: UnitTable
    cells: CellTable
    teeth: Teeth
    wheels: Wheels
    arms: Arms


class ForceWork(NamedTuple):
    """Workspaces of all kinds of forces, and their rows."""

    units: UnitWorkspace
    cells: CellWorkspace
    teeth: TeethWorkspace
    wheels: WheelWorkspace
    arms: ArmWorkspace
    rows: tuple[ForceRows, ForceRows, ForceRows, ForceRows, ForceRows, ForceRows]

    @classmethod
    def allocate(
        cls, forces: Forces, terrain: TerrainTable, contacts: int, shoes: ShoePoints, modes: int
    ) -> "ForceWork":
        """Return workspaces for at most `contacts` contacts with units, or for shoes on cells; m modes."""
        on_units = UnitWorkspace.allocate(terrain, contacts, modes)
        on_cells = CellWorkspace.allocate(forces.cells, shoes)
        at_teeth = TeethWorkspace.allocate(len(forces.teeth.markers), modes)
        at_wheels = WheelWorkspace.allocate(forces.wheels, modes)
        of_arms = ArmWorkspace.allocate(len(forces.arms.torque), modes)
        on_shoes = on_units.contacts.rows, at_teeth.rows, at_wheels.rows, on_cells.rigid, on_cells.flexible
        return cls(
            units=on_units,
            cells=on_cells,
            teeth=at_teeth,
            wheels=at_wheels,
            arms=of_arms,
            rows=(*on_shoes, of_arms.rows),
        )


@inlined
def write_joints(joints: Joints, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of all joints."""
    pin.write_rows(joints.pins, bodies, markers, motion, rows)
    play.write_rows(joints.plays, bodies, markers, motion, rows)
    friction.write_rows(joints.frictions, joints.pins, bodies, markers, motion, rows)
    drive.write_rows(joints.drive, bodies, markers, motion, rows)
    pull.write_rows(joints.pull, bodies, markers, motion, rows)
    hold.write_rows(joints.holds, bodies, markers, motion, rows)
    motor.write_rows(joints.motors, bodies, markers, motion, rows)
    recoil.write_rows(joints.recoils, bodies, markers, motion, rows)


@inlined
def turn_multipliers(
    joints: Joints, bodies: Bodies, markers: Markers, change: FloatArray, multipliers: FloatArray
) -> None:
    """Rotate multipliers along rotating axes with a `change` of coordinates and multipliers."""
    pin.turn_moments(joints.pins, bodies, markers, change, multipliers)


@inlined
def write_forces(
    forces: Forces,
    terrain: TerrainTable,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    inputs: Inputs,
    weights: Weights,
    work: ForceWork,
) -> None:
    """Write the rows of all forces at coordinates, rates and accelerations (3, coordinates)."""
    units.write_rows(forces.units, terrain, bodies, state, weights, work.units)
    cells.write_rows(forces.cells, bodies, state, weights, work.cells)
    teeth.write_rows(forces.teeth, bodies, markers, state, weights, work.teeth)
    wheels.write_rows(forces.wheels, bodies, state, inputs.resists, weights, work.wheels)
    arms.write_rows(forces.arms, bodies, state, weights, work.arms)
