"""Loads and drive of the shoes in Exudyn, and the hold of the track at rest."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from exudyn_crawler.case import Case, StepProfile, statics
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.engine import bodies, euler_parameters
from exudyn_crawler.model.exudyn import EulerParameters2G, EulerParameters2RotationMatrix, exu, items
from exudyn_crawler.model.forces.loads import static_friction
from exudyn_crawler.model.tables import Tables

X = np.array([1.0, 0.0, 0.0])


def add_loads(mbs: "exu.MainSystem", case: Case, tables: Tables, shoes: bodies.Shoes, static: bool) -> None:
    """Add machine loads along gravity, each in two shares for its shift: at its place and a metre beside it.

    `static` keeps the loads of t = 0, since Exudyn's static solver uses those at 1 s.
    """
    loads = tables.loads
    shift = case.loads.side_shift
    down = case.terrain.down
    shares = (lambda time: 1.0 - shift.value(time)), shift.value
    for profile, *ends in zip(case.loads.of_shoes, loads.marker, loads.beside, strict=True):
        for end, share in zip(ends, shares, strict=True):

            @lru_cache(maxsize=4)  # a step evaluates the same time many times
            def force(time, profile=profile, share=share):
                return (profile.value(time) * share(time) * down).tolist()

            over_time = 0 if static else lambda _mbs, t, _load, force=force: force(t)
            marker = shoes.markers[end]
            mbs.CreateForce(itemNumber=marker, loadVector=force(0.0), loadVectorUserFunction=over_time)


def add_hold(mbs: "exu.MainSystem", case: Case, tables: Tables, shoes: bodies.Shoes) -> None:
    """Hold the front shoe in x, y and about z, with `static_friction` on all shoes on a slope.

    The hold acts at the point of the drive; at another point the run would start with a jolt. Dashpots damp
    shoes on spheres on uneven ground critically; they have no force at rest.
    """
    shoe = case.shoe
    ground = mbs.CreateGround()
    ends = [ground, shoes.markers[tables.joints.drive.marker]]
    mbs.CreateGenericJoint("hold of the front shoe", ends, constrainedAxes=[1, 1, 0, 0, 0, 1])
    damping = 2.0 * np.sqrt(shoe.mass * statics.mean_load(case) / statics.settled_penetration(case))
    arms = np.array([1.0, 1.0, 1.0, 0.5 * shoe.width, 0.5 * shoe.length, 0.5 * shoe.width])
    for node, force, moment in zip(shoes.nodes, *static_friction(case, tables.bodies.mass), strict=True):
        mbs.CreateForce(itemNumber=node, loadVector=force)
        mbs.CreateTorque(itemNumber=node, loadVector=moment)
        if case.contact.model == "spheres" and not case.terrain.is_even:
            mbs.CreateRigidBodySpringDamper(
                itemNumbers=[ground, node], damping=np.diag(damping * arms**2), useIntrinsicFormulation=False
            )


def add_drive(
    mbs: "exu.MainSystem",
    tables: Tables,
    shoes: bodies.Shoes,
    speeds: Callable[[float], Sequence[float] | np.ndarray],
) -> list[int]:
    """Prescribe the velocity along x of the drive's point, and a body's rate about its own z axis.

    The body is the front shoe. On a machine that rolls, the point is in its side frame. `speeds` gives both
    speeds (m/s and rad/s) at a time (s). `ExudynSystem.switch_drive` makes them active.

    Constraints are on velocity level, so that a halved step leaves no error in the acceleration.
    """
    place = tables.markers.position[tables.joints.drive.marker]
    shapes = tables.markers.displacement[tables.joints.drive.marker]
    ground = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=mbs.AddNode(items.NodePointGround())))
    moved = tables.markers.body[tables.joints.drive.marker], tables.joints.drive.turning

    def directions(q: list[float]) -> np.ndarray:
        """Return the factors (2, coordinates) of both in coordinates' rates; `q` includes the reference."""
        e, z = np.split(np.array(q)[3:], [euler_parameters.SIZE - 3])
        R = EulerParameters2RotationMatrix(e)
        G = EulerParameters2G(e)
        rows = shapes[:, : len(z)]
        arm = R @ (place + rows @ z)
        turned = np.array((0.0, arm[2], -arm[1]))  # arm x X; NumPy's product is slower than all the rest
        along_x = np.concatenate((X, turned @ G, R[0] @ rows))
        about_z = np.concatenate((0.0 * X, R[:, 2] @ G, 0.0 * z))
        return np.stack((along_x, about_z))

    def prescribe(name: str, row: int) -> int:
        def gap(_mbs, t, _item, q, q_t, _velocity_level):
            return directions(q)[[row]] @ np.array(q_t) - speeds(t)[row]

        body = items.MarkerObjectODE2Coordinates(objectNumber=shoes.bodies[moved[row]])
        return mbs.AddObject(
            items.ObjectConnectorCoordinateVector(
                name=name,
                markerNumbers=[mbs.AddMarker(body), ground],
                scalingMarker0=np.zeros((1, 1)),  # declares one equation
                constraintUserFunction=gap,
                jacobianUserFunction=lambda _mbs, _t, _item, q, _q_t, _level: directions(q)[[row]],
                velocityLevel=True,
                activeConnector=False,
            )
        )

    return [prescribe("drive", 0), prescribe("turn", 1)]


def speeds_of(drive: Drive) -> Callable[[float], tuple[float, float]]:
    """Return both speeds of a drive as a function of the time (s), of which a step asks many times."""
    turn = drive.turn_rate or StepProfile.constant(0.0)
    return lru_cache(maxsize=4)(lambda time: (float(drive.speed.value(time)), float(turn.value(time))))
