"""Exudyn's items of a machine on its tracks: pins of chains, holds, motors, loads, and their reactions."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.engine.bodies import Shoes
from exudyn_crawler.engine.euler_parameters import SIZE
from exudyn_crawler.ground import rotations
from exudyn_crawler.model.assemble import Assembly
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.exudyn import EulerParameters2G, EulerParameters2RotationMatrix, exu, items
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.joints.motor import BRAKE, SLOW
from exudyn_crawler.model.joints.pin import ROWS, Pins

PIN = [1, 1, 1, 1, 0, 1]
"""Axes of Exudyn's joint that a pin constrains; it turns about y of both bodies."""
IN_PLANE = [1, 0, 1, 0, 0, 0]
"""Axes that a pin with lateral compliance constrains: both in the plane of the chain."""
SIDEWAYS, ROLL = 1, 3
"""Rows of a pin with lateral compliance: offset, and the first of two of its axis y."""
DRIVES = 2
"""Number of rows of the drive, between those of the pins and of the holds."""
TORQUE = exu.OutputVariableType.TorqueLocal
"""Output of a spring: its moment on the body behind, in that body's axes, N m."""
ROTATIONS = 3
"""First of a body's coordinates whose holds are joints of Exudyn."""


class Reactions(NamedTuple):
    """Multipliers of the compiled equations from those of Exudyn's joints and from its springs."""

    rear: np.ndarray  # (pins,): bodies behind the pins
    markers: list[list[int]]  # of Exudyn, behind and ahead of every pin
    springs: dict[int, int]  # across the chain, by the numbers of their pins
    in_plane: bool  # see `Pins`
    holds: np.ndarray  # (h, 2): body, and which of its coordinates; their rows follow those of the drive
    motors: list[int]  # springs in place of motors of limited torque; else empty. Their rows are the last

    def multipliers(self, mbs: "exu.MainSystem", own: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Return the multipliers (N and N m) of the compiled equations.

        `own` are Exudyn's in their order, see `equations_of`, `angles` (bodies, 3) those of the bodies, rad.
        """
        out = own.copy()
        count = ROWS * len(self.rear)
        if self.in_plane:
            pins = out[:count].reshape(-1, ROWS)
            turned = exu.OutputVariableType.RotationMatrix
            ends = [[mbs.GetMarkerOutput(end, turned) for end in pair] for pair in self.markers]
            # bores of a bent shoe turn against it
            behind, ahead = np.reshape(ends, (-1, 2, 3, 3)).swapaxes(0, 1)
            plane = rotations.rotation_matrices(angles[self.rear] * [1.0, 0.0, 1.0])
            kinds = exu.OutputVariableType.ForceLocal, TORQUE
            for p, spring in self.springs.items():
                force, moment = (behind[p] @ mbs.GetObjectOutput(spring, kind) for kind in kinds)
                pins[p, :3] = behind[p] @ pins[p, :3] + force
                pins[p, ROLL:] = moment @ ahead[p][:, 2], -moment @ ahead[p][:, 0]
            pins[:, :3] = np.einsum("pi,pij->pj", pins[:, :3], plane)
        for k, (body, coordinate) in enumerate(self.holds):
            if coordinate >= ROTATIONS:
                # the joint's gap is the sine of the negative yaw times the cosine of the roll; on posts there
                # is no roll
                out[count + DRIVES + k] *= -np.cos(angles[body, 0])
        for k, motor in enumerate(self.motors):
            out[count + DRIVES + len(self.holds) + k] = mbs.GetObjectOutput(motor, TORQUE)[1]
        return out


def equations_of(mbs: "exu.MainSystem", assembly: Assembly) -> np.ndarray:
    """Return the numbers of Exudyn's algebraic equations of all multipliers, -1 for those of springs."""
    rows: list[int] = []
    joints = assembly.tables.joints
    pins = len(joints.pins.markers)
    for k, (name, _) in enumerate(assembly.rows):
        item = mbs.GetObjectNumber(name)
        if mbs.GetObject(item)["objectType"] == "ConnectorRigidBodySpringDamper":
            rows.append(-1)
            continue
        own = list(mbs.systemData.GetObjectLTGAE(item))
        if k < pins:
            soft = joints.pins.compliance[k].any()
            own = [own[0], -1, own[2], -1, -1] if soft else [*own[:4], own[5]]
        elif len(own) == 6:
            own = [own[joints.holds.coordinates[k - pins - DRIVES, 1]]]
        rows += own
    return np.array(rows)


def add_pins(mbs: "exu.MainSystem", names: list[str], pins: Pins, markers: list[int]) -> dict[int, int]:
    """Add all pins, and springs for their compliance; return the springs by the numbers of their pins."""
    springs = {}
    for p, (name, pair, compliance) in enumerate(zip(names, pins.markers, pins.compliance, strict=True)):
        ends = [markers[end] for end in pair]
        soft = bool(compliance.any())
        axes = IN_PLANE if soft else PIN
        mbs.AddObject(items.ObjectJointGeneric(name=name, markerNumbers=ends, constrainedAxes=axes))
        if soft:
            springs[p] = _add_spring(mbs, f"compliance of {name}", ends, compliance)
    return springs


def _add_spring(mbs: "exu.MainSystem", name: str, ends: list[int], compliance: np.ndarray) -> int:
    """Add the spring of a pin with lateral compliance; return its number.

    The bodies behind and ahead turn about the pin by any angle b. Their small turns a and c about the other
    axes of Exudyn's sequence x, y, z are a vector (a + c sin b, 0, c cos b) in the body behind.
    """
    stiffness = 1.0 / compliance[SIDEWAYS]
    turning = 1.0 / compliance[ROLL]

    def wrench(_mbs, _t, _item, displacement, rotation, *_rest):
        a, b, c = rotation
        moment = turning * (a + c * np.sin(b)), 0.0, turning * c * np.cos(b)
        return [0.0, stiffness * displacement[1], 0.0, *moment]

    return mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            name=name, markerNumbers=ends, springForceTorqueUserFunction=wrench
        )
    )


def add_holds(mbs: "exu.MainSystem", names: list[str], holds: np.ndarray, shoes: Shoes) -> None:
    """Hold coordinates of bodies at zero; `holds` (h, 2) are bodies, and which of their six coordinates.

    The yaw is zero where the axis y of the body is across the global x. Roll and pitch are held with it only.
    """
    ground = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=mbs.AddNode(items.NodePointGround())))
    for name, (body, coordinate) in zip(names, holds.tolist(), strict=True):
        if coordinate < ROTATIONS:
            mbs.CreateCoordinateConstraint(name, [None, shoes.nodes[body]], [None, coordinate])
            continue
        axes = [0] * 6
        axes[coordinate] = 1
        marker = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=shoes.nodes[body]))
        mbs.AddObject(
            items.ObjectJointGeneric(name=name, markerNumbers=[ground, marker], constrainedAxes=axes)
        )


def add_motors(mbs: "exu.MainSystem", names: list[str], kernels: CompiledSystem, shoes: Shoes) -> list[int]:
    """Add the motors of tumblers against their frames, about the tumblers' axes.

    A motor prescribes the rate, or has a torque by the lag behind it; return the springs of such torques.
    """
    motors = kernels.tables.joints.motors
    speeds = at_time(kernels)
    if np.isfinite(motors.limit).all():
        return [_add_torque(mbs, name, k, kernels, shoes) for k, name in enumerate(names)]

    def direction(q: list[float]) -> np.ndarray:
        """Return the factors (1, coordinates) of the rate in those of frame and tumbler."""
        turns = [np.array(q[first : first + 4]) for first in (3, 3 + SIZE)]
        axis = EulerParameters2RotationMatrix(turns[1])[:, 1]
        row = np.zeros((1, 2 * SIZE))
        row[0, 3:SIZE] = -axis @ EulerParameters2G(turns[0])
        row[0, 3 + SIZE :] = axis @ EulerParameters2G(turns[1])
        return row

    for k, (name, pair) in enumerate(zip(names, motors.bodies.tolist(), strict=True)):
        markers = [
            mbs.AddMarker(items.MarkerObjectODE2Coordinates(objectNumber=shoes.bodies[body])) for body in pair
        ]

        def gap(_mbs, t, _item, q, q_t, _level, k=k):
            return direction(q) @ np.array(q_t) - speeds(t).motors[k]

        mbs.AddObject(
            items.ObjectConnectorCoordinateVector(
                name=name,
                markerNumbers=markers,
                scalingMarker0=np.zeros((1, 1)),  # declares one equation
                constraintUserFunction=gap,
                jacobianUserFunction=lambda _mbs, _t, _item, q, _q_t, _level: direction(q),
                velocityLevel=True,
            )
        )
    return []


def _add_torque(mbs: "exu.MainSystem", name: str, motor: int, kernels: CompiledSystem, shoes: Shoes) -> int:
    """Add the torque of a motor by the lag behind its rate, see `joints.motor`; return its number."""
    motors = kernels.tables.joints.motors
    inputs = at_time(kernels)
    limit, slow = motors.limit[motor], SLOW * motors.lag[motor]

    def wrench(_mbs, t, _item, _displacement, _rotation, _velocity, rate, *_rest):
        wanted = inputs(t).motors[motor]
        lag, width = wanted - rate[1], motors.lag[motor] * np.clip(abs(wanted) / slow, BRAKE, 1.0)
        return [0.0, 0.0, 0.0, 0.0, -limit * lag / np.hypot(lag, width), 0.0]

    nodes = [shoes.nodes[body] for body in motors.bodies[motor]]
    markers = [mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)) for node in nodes]
    return mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            name=name, markerNumbers=markers, springForceTorqueUserFunction=wrench
        )
    )


def at_time(kernels: CompiledSystem) -> Callable[[float], Inputs]:
    """Return loads and drive as a function of the time (s), of which a step asks many times."""
    return lru_cache(maxsize=4)(kernels.inputs)


def add_wrenches(mbs: "exu.MainSystem", kernels: CompiledSystem, markers: list[int]) -> None:
    """Add the loads of a machine at their markers, which are those behind the loads of its shoes."""
    loads = kernels.tables.loads
    inputs = at_time(kernels)
    for k in range(kernels.layout.shoes, len(loads.marker)):
        marker = markers[loads.marker[k]]

        def part(first: int, k: int = k) -> Any:
            return lambda _mbs, t, _load: inputs(t).loads[k, first : first + 3].tolist()

        mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=part(0)))
        mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVectorUserFunction=part(3)))
