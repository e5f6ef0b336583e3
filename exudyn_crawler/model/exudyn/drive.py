"""Loads and drive of the shoes in Exudyn, and what holds the track at rest."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.exudyn import bodies, euler_parameters
from exudyn_crawler.model.forces.loads import static_friction
from exudyn_crawler.model.tables import Tables

X = np.array([1.0, 0.0, 0.0])

Direction = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""Of a rotation matrix and modal coordinates: force, moment about the frame's origin and modal forces."""


def add_loads(mbs: "exu.MainSystem", case: Case, markers: list[int], static: bool) -> None:
    """Machine loads along gravity, each in two shares, unequal where it shifts to a side.

    There are two `markers` a shoe, at `SIDES` of the load's place. `static` keeps the loads as they are at t
    = 0: Exudyn's static solver asks for those at 1 s.
    """
    shift, down = case.loads.side_shift, case.terrain.down
    shares = [(profile, side) for profile in case.loads.of_shoes for side in bodies.SIDES]
    for marker, (profile, side) in zip(markers, shares, strict=True):

        @lru_cache(maxsize=4)  # a step asks for the same time again and again
        def force(time: float, profile: StepProfile = profile, side: float = side) -> list[float]:
            return (0.5 * profile.value(time) * (1.0 + side * shift.value(time)) * down).tolist()

        changes = not static and max(len({*profile.values}), len({*shift.values})) > 1
        over_time = (lambda _mbs, t, _load, force=force: force(t)) if changes else 0
        mbs.CreateForce(itemNumber=marker, loadVector=force(0.0), loadVectorUserFunction=over_time)


def add_hold(
    mbs: "exu.MainSystem", case: Case, shoes: bodies.Shoes, masses: np.ndarray, dashpots: bool
) -> int:
    """Keep the front shoe at rest in x, y and about z, with `static_friction` on all shoes on a slope.

    It is held where the drive will act: from another place the run would start with a jolt. `dashpots` damp
    the shoes on their contact critically; at rest they do nothing.
    """
    ends = [mbs.CreateGround(), shoes.markers[-1]]
    joint = mbs.CreateGenericJoint("hold of the front shoe", ends, constrainedAxes=[1, 1, 0, 0, 0, 1])
    if case.terrain.down[2] > -1.0:
        for node, force, moment in zip(shoes.nodes, *static_friction(case, masses), strict=True):
            mbs.CreateForce(itemNumber=node, loadVector=force)
            mbs.CreateTorque(itemNumber=node, loadVector=moment)
    if dashpots:
        shoe, ground = case.shoe, mbs.CreateGround()
        damping = 2.0 * np.sqrt(shoe.mass * case.mean_load / case.settled_penetration)
        arms = np.array([1.0, 1.0, 1.0, 0.5 * shoe.width, 0.5 * shoe.length, 0.5 * shoe.width])
        for node in shoes.nodes:
            mbs.CreateRigidBodySpringDamper(
                itemNumbers=[ground, node], damping=np.diag(damping * arms**2), useIntrinsicFormulation=False
            )
    return joint


def add_drive(mbs: "exu.MainSystem", case: Case, tables: Tables, shoes: bodies.Shoes) -> list[int]:
    """Prescribe the velocity along x of the drive's point and the front shoe's rate about its own z axis.

    On velocity level a halved step leaves no error in the acceleration.
    """
    node, k = shoes.nodes[-1], tables.joints.drive
    bends = tables.bodies.modal[tables.markers.body[k]] >= 0
    place, rows = tables.markers.position[k], tables.markers.displacement[k][:, : None if bends else 0]
    nodes = [node, shoes.modal_nodes[-1]] if bends else [mbs.AddNode(items.NodePointGround()), node]
    markers = [mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=one)) for one in nodes]

    def along_x(R: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return X, np.cross(R @ (place + rows @ z), X), rows.T @ R[0]

    def about_z(R: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.zeros(3), R[:, 2], 0.0 * z

    turn = case.drive.turn_rate or StepProfile.constant(0.0)
    return [
        _prescribe(mbs, name, markers, rows.shape[1] if bends else euler_parameters.SIZE, direction, speed)
        for name, direction, speed in (("drive", along_x, case.drive.speed), ("turn", about_z, turn))
    ]


def _prescribe(
    mbs: "exu.MainSystem", name: str, markers: list[int], last: int, direction: Direction, speed: StepProfile
) -> int:
    """Prescribe the speed in a direction; the second of the markers has `last` coordinates."""
    value = lru_cache(maxsize=4)(speed.value)

    def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
        e, z = np.split(np.array(q)[3:], [euler_parameters.SIZE - 3])  # with those of reference
        force, moment, modal = direction(euler_parameters.matrices_of(e), z)
        return np.concatenate((force, euler_parameters.rate_matrix(e).T @ moment, modal))[None, :]

    def gap(mbs, t, item, q, q_t, velocity_level):
        return jacobian(mbs, t, item, q, q_t, velocity_level) @ np.array(q_t) - float(value(t))

    return mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            name=name,
            markerNumbers=markers,
            scalingMarker1=np.zeros((1, last)),
            constraintUserFunction=gap,
            jacobianUserFunction=jacobian,
            velocityLevel=True,
        )
    )
