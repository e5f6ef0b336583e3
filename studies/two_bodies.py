"""Two-body verification problem: a block dragged over a fixed plate.

Reproduces the verification of the equations in the K-paper, tables 7 and 8 ("Multi-Body Dynamic Modeling and
Simulation of Crawler-Formation Interactions in Surface Mining Operations - Crawler Kinematics").

Body 2, a plate, is fixed to the ground at its centre. Body 3, a block, keeps its orientation, is driven along
x and is free in y and z. The block's penetration and its rate are given. Accelerations and reactions follow
by hand (Newton and Euler) and, independently, from the assembled multibody system.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from exudyn_crawler.case import PairContact, Shoe, Terrain
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.terrain import UnitCoordinates
from exudyn_crawler.model.exudyn import exu, items
from studies.comparison import comparison_table, reported_values

GRAVITY = 9.81
DENSITY = 7801.0
"""Density, kg/m3 (K-paper: body 2 of 30 x 10 x 1 m weighs 2.340e6 kg)."""
PLATE = (30.0, 10.0, 1.0)  # m, sides of body 2; its centre is at (15, 5, -0.5) (K-paper)
BLOCK = (0.5, 3.5, 0.5)  # m, sides of body 3; its COM is at (3.25, 5.0, 0.25) at t = 0 (K-paper)
BLOCK_START = (3.25, 5.0, 0.25)
SPEED = 0.5
"""Prescribed speed along x, m/s (K-paper)."""
TIME = 0.5  # s, time of the printed solution (K-paper, tables 7 and 8)
NORMAL_FORCE = 44275.0  # N, contact force at that time: ADAMS output, from both printed values of the K-paper
SINKING = 0.02  # m/s, penetration rate of the block; arbitrary, since only the force is printed


Three = tuple[float, float, float]


@dataclass(frozen=True)
class TwoBodySolution:
    """Accelerations and reactions at `TIME` in global axes."""

    block_acceleration: Three  # acceleration of body 3's COM, m/s2
    plate_force_z: float  # generalized force on body 2: its weight and the contact, N
    drive_force: float  # force on body 3 along x, N
    hold_moment: Three  # moment on body 3 that keeps its orientation, N m
    fixing_force: Three  # force on body 2 from the ground, at its centre, N
    fixing_moment: Three  # moment on body 2 from the ground, N m


def _box(sides: Three) -> tuple[float, Three]:
    """Return mass (kg) and principal moments of inertia (kg m2) of a solid box."""
    mass = DENSITY * float(np.prod(sides))
    x, y, z = sides
    return mass, (mass / 12 * (y**2 + z**2), mass / 12 * (x**2 + z**2), mass / 12 * (x**2 + y**2))


UNITS = {"block_acceleration": "m/s2", "plate_force_z": "N", "drive_force": "N"}
UNITS |= {"hold_moment": "N m", "fixing_force": "N", "fixing_moment": "N m"}
BLOCK_MASS, BLOCK_INERTIA = _box(BLOCK)
PLATE_MASS, PLATE_INERTIA = _box(PLATE)


def block_penetration(law: PairContact) -> float:
    """Return the penetration (m), beyond the damping depth, for the printed force at the given rate."""
    return float(((NORMAL_FORCE - law.damping * SINKING) / law.stiffness) ** (1.0 / law.exponent))


def hand_solution(law: PairContact) -> TwoBodySolution:
    """Solve Newton's and Euler's equations of the two bodies.

    The slip of 0.5 m/s is above the friction speed, so that friction is mu_d times the normal force. The
    contact acts at half the penetration below the plate's top face, under the block's middle.
    """
    friction = law.dynamic_friction * NORMAL_FORCE
    depth = block_penetration(law)
    contact_z = -0.5 * depth
    block_z = 0.5 * BLOCK[2] - depth
    arm_x = BLOCK_START[0] + SPEED * TIME - 0.5 * PLATE[0]
    arm_z = contact_z + 0.5 * PLATE[2]
    weight = PLATE_MASS * GRAVITY
    # moment of a force (fx, 0, fz) at (ax, 0, az) about y: az fx - ax fz
    on_block = (contact_z - block_z) * -friction
    on_plate = arm_z * friction - arm_x * -NORMAL_FORCE
    return TwoBodySolution(
        block_acceleration=(0.0, 0.0, NORMAL_FORCE / BLOCK_MASS - GRAVITY),
        plate_force_z=-weight - NORMAL_FORCE,
        drive_force=friction,
        hold_moment=(0.0, -on_block, 0.0),
        fixing_force=(-friction, 0.0, weight + NORMAL_FORCE),
        fixing_moment=(0.0, -on_plate, 0.0),
    )


def engine_solution(law: PairContact) -> TwoBodySolution:
    """Solve for initial accelerations and multipliers of the assembled system at `TIME` with Exudyn."""
    start = np.array([BLOCK_START])
    sides = ("length", "width", "height")
    # no spring carries the plate, which is fixed to the ground
    of_plate = {f"unit_{name}": side for name, side in zip(sides, PLATE, strict=True)}
    plate = Terrain.stress().with_(columns=1, rows=1, origin=(0.0, 0.0), density=DENSITY, **of_plate)
    half = 0.5 * BLOCK[2]
    flat = {"com_height": half, "length": BLOCK[0], "width": BLOCK[1], "load_point": (0.0, 0.0, half)}
    block = Shoe.ph4100c().with_(mass=BLOCK_MASS, inertia=(*BLOCK_INERTIA, 0.0, 0.0, 0.0), **flat)
    reference = np.hstack((start, np.zeros((1, 3))))
    contact = PairGroundContact(reference, block, plate, law, UnitCoordinates(1, plate.tilt_axis))
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    displacement = np.array([SPEED * TIME, 0.0, -block_penetration(law), *[0.0] * 9])
    velocity = np.array([SPEED, 0.0, -SINKING, *[0.0] * 9])
    moved = _add_body(mbs, start[0], (BLOCK_MASS, BLOCK_INERTIA), displacement[:3], velocity[:3])
    fixed = _add_body(mbs, plate.centers[0], (PLATE_MASS, PLATE_INERTIA), np.zeros(3), np.zeros(3))
    _add_contact(mbs, contact, [moved, fixed])
    ground = mbs.AddObject(items.ObjectGround())
    place = plate.centers[0].tolist()
    at_ground = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=place))
    at_plate = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=fixed))
    fixing = mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[at_ground, at_plate]))
    holds = _add_holds(mbs, moved)
    accelerations, multipliers = _initial_state(mbs)
    rows = mbs.systemData.GetObjectLTGAE
    drive, hold_x, hold_y, hold_z = (float(-multipliers[rows(item)[0]]) for item in holds)
    # the joint's equations are p1 - p0 = 0, vz0 . vy1 = 0, vz0 . vx1 = 0, vx0 . vy1 = 0, all axes aligned
    fx, fy, fz, about_x, about_y, about_z = (-multipliers[row] for row in rows(fixing))
    contact_on_plate = float(contact.forces(displacement, velocity)[8])
    return TwoBodySolution(
        block_acceleration=tuple(accelerations[:3]),
        plate_force_z=contact_on_plate - PLATE_MASS * GRAVITY,
        drive_force=drive,
        hold_moment=(hold_x, hold_y, hold_z),
        fixing_force=(float(fx), float(fy), float(fz)),
        fixing_moment=(float(about_x), float(-about_y), float(about_z)),
    )


def _add_body(
    mbs: "exu.MainSystem",
    position: np.ndarray,
    body: tuple[float, tuple[float, float, float]],
    displacement: np.ndarray,
    velocity: np.ndarray,
) -> int:
    """Add a body of given mass and principal moments of inertia, with its weight; return its node."""
    mass, inertia = body
    names = ("referenceCoordinates", "initialCoordinates", "initialVelocities")
    vectors = zip(names, (position, displacement, velocity), strict=True)
    upright = {name: [*vector, 0.0, 0.0, 0.0] for name, vector in vectors}
    node = mbs.AddNode(items.NodeRigidBodyRxyz(**upright))
    body_of = items.ObjectRigidBody(mass=mass, inertia=[*inertia, 0.0, 0.0, 0.0], nodeNumber=node)
    number = mbs.AddObject(body_of)
    com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=number))
    mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=[0, 0, -mass * GRAVITY]))
    return node


def _add_contact(mbs: "exu.MainSystem", contact: PairGroundContact, nodes: list[int]) -> None:
    """Add the contact of block and plate; neither turns, so that angles about any axes serve."""

    def force(_mbs, _t, _item, q, q_t):
        return contact.forces(np.array(q), np.array(q_t))

    massless = exu.MatrixContainer()
    mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=nodes, massMatrix=massless, forceUserFunction=force))


def _add_holds(mbs: "exu.MainSystem", node: int) -> list[int]:
    """Drive a body along x and keep its orientation; return the connectors: x first, then rotations."""
    at_rest = mbs.AddNode(items.NodePointGround())
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=at_rest, coordinate=0))
    holds = []
    for coordinate in (0, 3, 4, 5):
        held = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        speed = SPEED if coordinate == 0 else 0.0
        markers = [fixed, held]
        hold = items.ObjectConnectorCoordinate(markerNumbers=markers, velocityLevel=True, offset=speed)
        holds.append(mbs.AddObject(hold))
    return holds


def _initial_state(mbs: "exu.MainSystem") -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations and multipliers of the assembled system in its initial state."""
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.numberOfSteps = 1
    settings.timeIntegration.endTime = 1e-9
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.5
    states = []

    def keep(system: "exu.MainSystem", _time: float) -> bool:
        data = system.systemData
        states.append((np.array(data.GetODE2Coordinates_tt()), np.array(data.GetAECoordinates())))
        return True

    mbs.SetPostStepUserFunction(keep)
    mbs.SolveDynamic(settings)
    return states[0]


def study() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Compare both solutions with each other, and the engine's with the printed values."""
    law = PairContact.oil_sand()
    engine = engine_solution(law)
    return compare_verification(hand_solution(law), engine), compare_with_paper(engine)


def compare_verification(hand: TwoBodySolution, engine: TwoBodySolution) -> pd.DataFrame:
    """Compare every quantity by hand and by engine: columns quantity, unit, hand, engine, difference."""
    rows = []
    for name, unit in UNITS.items():
        pair = np.atleast_1d(getattr(hand, name)), np.atleast_1d(getattr(engine, name))
        for axis, (by_hand, by_engine) in enumerate(zip(*pair, strict=True)):
            label = name.replace("_", " ") + (f" {'xyz'[axis]}" if len(pair[0]) == 3 else "")
            rows.append((label, unit, by_hand, by_engine, by_engine - by_hand))
    return pd.DataFrame(rows, columns=["quantity", "unit", "hand", "engine", "difference"])


def compare_with_paper(engine: TwoBodySolution) -> pd.DataFrame:
    """Compare the engine's values with those printed in the K-paper."""
    z = {
        "body 3 z acceleration": engine.block_acceleration[2],
        "body 2 generalized z force": engine.plate_force_z,
    }
    reported = reported_values("verification")
    return comparison_table(reported, [z[name.removesuffix(" at t=0.5 s")] for name in reported["quantity"]])
