"""The one place where the package meets Exudyn: builds the multibody system of a case.

Coordinates: six a shoe (COM displacement from t = 0 and the angles about x, y, z), then the terrain's.
"""

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

# The build without range checks is faster; with it Exudyn gives no timing statistics.
if os.environ.get("EXUDYN_CRAWLER_CHECKED") != "1":
    sys.exudynFast = True  # type: ignore[attr-defined]

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Drive, StepProfile
from exudyn_crawler.case.track import SIDES
from exudyn_crawler.ground.assembly import (
    ConstrainedCoordinates,
    ReducedCoordinates,
    TerrainCoordinates,
    TrackContact,
)
from exudyn_crawler.ground.terrain import localized, terrain_joints, terrain_modes, units_near
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe
from exudyn_crawler.model.general_contact import SphereContact, add_general_contact
from exudyn_crawler.model.shoes import ShoeBody, add_shoe_bodies, add_shoe_nodes

exu.config.printToConsole = False

REACH = 1.0
"""m round the track at t = 0 within which contact is expected; beyond, only the speed suffers."""

TANGENTS_A_STEP = 2
"""Jacobians with the tangent of the friction curve in one step; later ones take the secant."""


@dataclass
class System:
    """Multibody system of a case, assembled, with what is needed to read it.

    Attributes
    ----------
    mbs : exudyn.MainSystem
        The assembled system.
    contact : TrackContact or SphereContact
        Contact forces as functions of the system's coordinates.
    general : exudyn.GeneralContact, optional
        The engine's own contact, where it makes the forces.
    floating : FloatingShoe, optional
        What the flexible shoes share.
    link_rows, drive_row, turn_row :
        Indices of the Lagrange multipliers: six for each pin's joint of each link; of the drive; of the turn
        (None without one).
    """

    container: "exu.SystemContainer"
    mbs: "exu.MainSystem"
    case: Case
    contact: TrackContact | SphereContact
    general: "exu.GeneralContact | None"
    floating: FloatingShoe | None
    link_rows: list[list[list[int]]]
    drive: int
    drive_row: int
    turn: int | None
    turn_row: int | None

    def sunken(self) -> list[int]:
        """Numbers of the shoes with spheres below the ground in the current state; see `SphereContact`."""
        if self.general is None or not isinstance(self.contact, SphereContact):
            return []
        return self.contact.sunken(np.array(self.mbs.systemData.GetODE2Coordinates()))

    def set_initial(self, q: NDArray) -> None:
        """Start from rest at the coordinates `q`."""
        self.mbs.systemData.SetODE2Coordinates(q.tolist(), exu.ConfigurationType.Initial)
        self._find_contacts(q)

    def _find_contacts(self, q: NDArray) -> None:
        if self.general is not None:
            # the engine looked for touching spheres when it was assembled, with none in the ground yet, and
            # would let the track fall through the first step
            self.mbs.systemData.SetODE2Coordinates(q.tolist())
            self.general.UpdateContacts(self.mbs)

    def set_state(self, row: NDArray) -> None:
        """Start from a row as of `state`; its time goes into the solver's settings."""
        q, q_t, q_tt = np.split(row[1 : 1 + 3 * self.contact.size], 3)
        data = self.mbs.systemData
        data.SetODE2Coordinates(q.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_t(q_t.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_tt(q_tt.tolist(), exu.ConfigurationType.Initial)
        self._find_contacts(q)

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""
        for item in (self.drive, self.turn):
            if item is not None:
                self.mbs.SetObjectParameter(item, "activeConnector", on)

    def state(self) -> NDArray:
        """Time, coordinates, their first and second rates and the multipliers, in one row.

        After them, with contact model "general", the shoes' generalized contact forces.
        """
        data = self.mbs.systemData
        parts = [
            [data.GetTime()],
            data.GetODE2Coordinates(),
            data.GetODE2Coordinates_t(),
            data.GetODE2Coordinates_tt(),
            data.GetAECoordinates(),
        ]
        if self.general is not None:
            forces = self.general.GetSystemODE2RhsContactForces(copy=True)
            parts.append(forces[: self.contact.shoe_reference.size])
        return np.concatenate(parts)


def build(case: Case, static: bool = False) -> System:
    """Build and assemble the system of a case.

    Parameters
    ----------
    static : bool
        Hold the front shoe in x, y and about z instead of driving it. Nothing else fixes the track in
        the plane, since friction needs slip.
    """
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    floating = None
    if case.flexible is not None:
        floating = floating_shoe(case)
    shoe_nodes = add_shoe_nodes(mbs, case)
    terrain_nodes, coordinates = add_terrain(mbs, case, ground)
    shoes = add_shoe_bodies(mbs, case, shoe_nodes, floating)
    _add_loads(mbs, case, shoes)
    links = _add_links(mbs, shoes)
    contact: TrackContact | SphereContact
    general = None
    if case.contact_model == "general":
        contact = SphereContact(case)
        if not static:
            general = add_general_contact(mbs, case, shoes, terrain_nodes)
    else:
        contact = TrackContact(
            case.track.com_positions(case.shoe.com_height),
            case.shoe,
            case.terrain,
            case.contact,
            coordinates,
            None if floating is None else floating.underside,
            [index for index, shoe in enumerate(shoes) if shoe.is_flexible],
        )
    modal_nodes = [shoe.modal_node for shoe in shoes if shoe.modal_node is not None]
    add_contact(mbs, contact, shoe_nodes + terrain_nodes + modal_nodes, forces=general is None)

    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    turn = None
    if static:
        drive, _, _ = (_hold(mbs, fixed, shoe_nodes[-1], axis) for axis in (0, 1, 5))
        if case.terrain.heights is not None:
            _add_dashpots(mbs, case, fixed, shoe_nodes)
    else:
        drive = _add_drive(mbs, case.drive, fixed, shoe_nodes[-1])
        if case.drive.turn_rate is not None:
            turn = _add_turn(mbs, case.drive, shoe_nodes[-1])
    mbs.Assemble()
    rows = mbs.systemData.GetObjectLTGAE
    return System(
        container=container,
        mbs=mbs,
        case=case,
        contact=contact,
        general=general,
        link_rows=[[rows(pin) for pin in link] for link in links],
        floating=floating,
        drive=drive,
        drive_row=rows(drive)[0],
        turn=turn,
        turn_row=None if turn is None else rows(turn)[0],
    )


def _add_loads(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody]) -> None:
    """Machine load on the top face of every shoe."""
    for number, shoe in enumerate(shoes, start=1):
        profile = case.loads.profile(number)
        load = items.LoadForceVector(markerNumber=shoe.top, loadVector=[0.0, 0.0, -float(profile.value(0.0))])
        if len(set(profile.values)) > 1:
            load.loadVectorUserFunction = _vertical(profile)
        mbs.AddLoad(load)


def _vertical(profile: StepProfile) -> Callable[..., list[float]]:
    """Exudyn's user function of a downward load over time."""
    size = _at_time(profile.value)

    def vertical(_mbs, t, _load):
        return [0.0, 0.0, -size(t)]

    return vertical


def _add_links(mbs: "exu.MainSystem", shoes: Sequence[ShoeBody]) -> list[list[int]]:
    """Hinges between neighbours: for every link its joints, right pin first.

    Two rigid shoes have one: a spherical joint and a parallel axis in one item, five equations; the
    parallel axis has no place of its own, where its marker sits changes neither the motion nor the torque.
    Where a shoe is flexible each pin is a revolute joint.
    """
    links = []
    for number, (rear, front) in enumerate(pairwise(shoes), start=1):
        sides = SIDES if rear.is_flexible or front.is_flexible else SIDES[:1]
        links.append(
            [
                mbs.AddObject(
                    items.ObjectJointGeneric(
                        name=f"{side} pin of link {number}",
                        markerNumbers=[rear.pins["front", side], front.pins["rear", side]],
                        constrainedAxes=[1, 1, 1, 1, 0, 1],
                    )
                )
                for side in sides
            ]
        )
    return links


def add_terrain(mbs: "exu.MainSystem", case: Case, ground: int) -> tuple[list[int], TerrainCoordinates]:
    """Add the terrain in the case's formulation: its nodes and how they carry the units' motion."""
    # the engine's own contact needs the units as bodies
    if case.terrain_formulation == "constrained" or case.contact_model == "general":
        return _add_constrained_terrain(mbs, case, ground)
    return _add_reduced_terrain(mbs, case)


def _add_reduced_terrain(mbs: "exu.MainSystem", case: Case) -> tuple[list[int], TerrainCoordinates]:
    """Terrain in its independent coordinates, of which the track moves as few as possible."""
    near = units_near(case.terrain, case.outline(0.0), REACH)
    modes = localized(terrain_modes(case.terrain), near)
    moved = np.any(modes.heave[near] != 0.0, axis=0) | np.any(modes.tilt[near] != 0.0, axis=0)
    reached = int(np.flatnonzero(moved).max()) + 1
    zeros = [0.0] * modes.size
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=modes.size,
        )
    )
    mbs.AddObject(
        items.ObjectGenericODE2(
            name="terrain",
            nodeNumbers=[node],
            massMatrix=_sparse(np.eye(modes.size)),
            stiffnessMatrix=_sparse(modes.stiffness),
            dampingMatrix=_sparse(modes.damping),
            forceVector=case.gravity * modes.weight,
        )
    )
    return [node], ReducedCoordinates(modes, case.terrain.tilt_axis, reached)


def _sparse(values: NDArray) -> "exu.MatrixContainer":
    rows, columns = np.nonzero(values)
    matrix = exu.MatrixContainer()
    triplets = np.column_stack((rows, columns, values[rows, columns]))
    matrix.SetWithSparseMatrix(triplets, *values.shape)
    return matrix


def _add_constrained_terrain(
    mbs: "exu.MainSystem", case: Case, ground: int
) -> tuple[list[int], TerrainCoordinates]:
    """Terrain as rigid units with the papers' joints and held rotations."""
    terrain = case.terrain
    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    nodes, bodies = [], []
    weight = [0.0, 0.0, -terrain.unit_mass * case.gravity]
    across = np.eye(3)[0 if terrain.tilt == "pitch" else 1]
    springs = [0.0] if terrain.springs_per_unit == 1 else [-terrain.spring_offset, terrain.spring_offset]
    for number, center in enumerate(terrain.centers, start=1):
        node = mbs.AddNode(
            items.NodeRigidBodyRxyz(name=f"unit {number}", referenceCoordinates=[*center, 0.0, 0.0, 0.0])
        )
        body = mbs.AddObject(
            items.ObjectRigidBody(
                name=f"unit {number}",
                mass=terrain.unit_mass,
                inertia=[*terrain.unit_inertia, 0.0, 0.0, 0.0],
                nodeNumber=node,
            )
        )
        nodes.append(node)
        bodies.append(body)
        com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
        mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=weight))
        for offset in springs:
            place = offset * across
            mbs.AddObject(
                items.ObjectConnectorCartesianSpringDamper(
                    markerNumbers=[
                        mbs.AddMarker(
                            items.MarkerBodyPosition(bodyNumber=ground, localPosition=list(center + place))
                        ),
                        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=list(place))),
                    ],
                    stiffness=[0.0, 0.0, terrain.spring_stiffness],
                    damping=[0.0, 0.0, terrain.spring_damping],
                )
            )
        if terrain.column_tilt:
            stiffness = terrain.springs_per_unit * terrain.column_tilt_stiffness
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, _coordinate(mbs, node, 3 + terrain.tilt_axis)],
                    stiffness=stiffness,
                    damping=terrain.damping_time * stiffness,
                )
            )
        for axis in {0, 1, 2} - {terrain.tilt_axis}:
            mbs.AddObject(
                items.ObjectConnectorCoordinate(
                    name=f"rotation {axis} of unit {number}",
                    markerNumbers=[fixed, _coordinate(mbs, node, 3 + axis)],
                    velocityLevel=True,
                )
            )
    sides = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    for joint in terrain_joints(terrain):
        face = sides[joint.axis] * np.eye(3)[joint.axis]
        mbs.AddObject(
            items.ObjectJointSpherical(
                name=f"terrain joint {joint.first + 1}-{joint.second + 1}",
                markerNumbers=[
                    mbs.AddMarker(
                        items.MarkerBodyPosition(bodyNumber=bodies[unit], localPosition=list(place))
                    )
                    for unit, place in ((joint.first, face), (joint.second, -face))
                ],
                constrainedAxes=[1, 1, 1] if joint.spherical else [0, 0, 1],
            )
        )
    for axis in (0, 1):
        _hold(mbs, fixed, nodes[-1], axis)
    return nodes, ConstrainedCoordinates(terrain.unit_count, terrain.tilt_axis)


def _coordinate(mbs: "exu.MainSystem", node: int, coordinate: int) -> int:
    return mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def _add_dashpots(mbs: "exu.MainSystem", case: Case, fixed: int, nodes: Sequence[int]) -> None:
    """Dashpots that damp the shoes on their contact critically; at rest they do nothing."""
    stiffness = case.mean_load / case.settled_penetration
    damping = 2.0 * np.sqrt(case.shoe.mass * stiffness)
    arms = 0.5 * np.array([case.shoe.width, case.shoe.length, case.shoe.width])
    for node in nodes:
        for coordinate in range(6):
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, _coordinate(mbs, node, coordinate)],
                    damping=damping if coordinate < 3 else damping * arms[coordinate - 3] ** 2,
                )
            )


def _hold(mbs: "exu.MainSystem", fixed: int, node: int, coordinate: int) -> int:
    """Keep one coordinate of a node where it is."""
    return mbs.AddObject(
        items.ObjectConnectorCoordinate(markerNumbers=[fixed, _coordinate(mbs, node, coordinate)])
    )


def add_contact(
    mbs: "exu.MainSystem", contact: TrackContact | SphereContact, nodes: Sequence[int], forces: bool = True
) -> None:
    """All contacts as one item over the shoes' and the terrain's nodes.

    Without `forces` it gives their derivatives only, the forces being another's.
    """
    size = contact.size
    asked_time, asked = -1.0, 0

    def force(_mbs, _t, _item, q, q_t):
        return contact.forces(np.array(q), np.array(q_t))

    def jacobian(_mbs, t, _item, q, q_t, position_factor, velocity_factor):
        nonlocal asked_time, asked
        asked_time, asked = (t, asked + 1) if t == asked_time else (t, 1)
        # Exudyn asks for the derivative of the left-hand side, where forces stand negative
        triplets = contact.derivatives(
            np.array(q),
            np.array(q_t),
            -position_factor,
            -velocity_factor,
            secant=asked > TANGENTS_A_STEP,
        )
        matrix = exu.MatrixContainer()
        matrix.SetWithSparseMatrix(triplets, size, size)
        return matrix

    mbs.AddObject(
        items.ObjectGenericODE2(
            name="contact",
            nodeNumbers=list(nodes),
            massMatrix=exu.MatrixContainer(),
            forceUserFunction=force if forces else 0,
            jacobianUserFunction=jacobian,
        )
    )


def _at_time(function: Callable[[float], NDArray]) -> Callable[[float], float]:
    """Function of time as a number, remembered: a step asks for the same time again and again."""

    @lru_cache(maxsize=4)
    def at_time(time: float) -> float:
        return float(function(time))

    return at_time


def _add_drive(mbs: "exu.MainSystem", drive: Drive, fixed: int, node: int) -> int:
    """Prescribed travel of the front shoe's COM along x, as a constraint."""
    distance = _at_time(drive.speed.integral)
    speed = _at_time(drive.speed.value)

    def travel(_mbs, t, _item, _offset):
        return distance(t)

    def rate(_mbs, t, _item, _offset):
        return speed(t)

    return mbs.AddObject(
        items.ObjectConnectorCoordinate(
            name="drive",
            markerNumbers=[fixed, _coordinate(mbs, node, 0)],
            offset=1.0,  # Exudyn calls the offset functions only where the offset is not zero
            offsetUserFunction=travel,
            offsetUserFunction_t=rate,
            # on velocity level a halved step leaves no error in the acceleration
            velocityLevel=True,
        )
    )


def _add_turn(mbs: "exu.MainSystem", drive: Drive, node: int) -> int:
    """Prescribed angular velocity of the front shoe about its own z axis: a non-holonomic constraint.

    With the angles (a, b, c) about x, y, z it reads ``a' sin b + c' = rate(t)``.
    """
    assert drive.turn_rate is not None
    rate = _at_time(drive.turn_rate.value)
    empty = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=mbs.AddNode(items.NodePointGround())))
    marker = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node))

    def residual(_mbs, t, _item, q, q_t, _velocity_level):
        return [np.sin(q[4]) * q_t[3] + q_t[5] - rate(t)]

    def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
        return np.array([[0.0, 0.0, 0.0, np.sin(q[4]), 0.0, 1.0]])

    return mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            name="turn",
            markerNumbers=[empty, marker],
            scalingMarker1=np.zeros((1, 6)),
            constraintUserFunction=residual,
            jacobianUserFunction=jacobian,
            velocityLevel=True,
        )
    )
