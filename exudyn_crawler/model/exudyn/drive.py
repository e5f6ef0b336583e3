"""Loads and drive of the shoes in Exudyn, and what holds the track at rest."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.exudyn.bodies import SIDES, Shoes, coordinate_marker, hold
from exudyn_crawler.model.exudyn.euler_parameters import SIZE, matrices_of, rate_matrix
from exudyn_crawler.model.forces.loads import static_friction
from exudyn_crawler.model.tables import Tables

X = np.array([1.0, 0.0, 0.0])

Direction = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""Of a rotation matrix and modal coordinates: force, moment about the frame's origin and modal forces."""


def _at_time(function: Callable[[float], np.ndarray]) -> Callable[[float], float]:
    """Function of time as a number, cached: a step asks for the same time again and again."""

    @lru_cache(maxsize=4)
    def value(time: float) -> float:
        return float(function(time))

    return value


def add_loads(mbs: "exu.MainSystem", case: Case, markers: list[int], static: bool) -> None:
    """Machine loads along gravity, each in two shares, unequal where it shifts to a side.

    There are two `markers` a shoe, at `SIDES` of the load's place. `static` keeps the loads as they are at t
    = 0: Exudyn's static solver asks for those at 1 s.
    """
    shift, down = case.loads.side_shift, case.terrain.down
    shares = [(profile, side) for profile in case.loads.of_shoes for side in SIDES]
    for marker, (profile, side) in zip(markers, shares, strict=True):
        size = _at_time(_share(profile, shift, side))
        load = items.LoadForceVector(markerNumber=marker, loadVector=(size(0.0) * down).tolist())
        if not static and max(len({*profile.values}), len({*shift.values})) > 1:
            load.loadVectorUserFunction = _along(size, down)
        mbs.AddLoad(load)


def _share(profile: StepProfile, shift: StepProfile, side: float) -> Callable[[float], np.ndarray]:
    return lambda time: 0.5 * profile.value(time) * (1.0 + side * shift.value(time))


def _along(size: Callable[[float], float], down: np.ndarray) -> Callable[..., list[float]]:
    """Exudyn's user function of a load over time in a direction."""
    x, y, z = down.tolist()

    def force(_mbs, t, _load):
        now = size(t)
        return [now * x, now * y, now * z]

    return force


def add_slope_friction(mbs: "exu.MainSystem", case: Case, nodes: list[int], masses: np.ndarray) -> None:
    """`static_friction` on the shoes, for a rest on a slope."""
    for node, force, moment in zip(nodes, *static_friction(case, masses), strict=True):
        frame = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
        mbs.AddLoad(items.LoadForceVector(markerNumber=frame, loadVector=force.tolist()))
        mbs.AddLoad(items.LoadTorqueVector(markerNumber=frame, loadVector=moment.tolist()))


def add_dashpots(mbs: "exu.MainSystem", case: Case, nodes: list[int], fixed: int) -> None:
    """Dashpots that damp the shoes on their contact critically; at rest they do nothing."""
    damping = 2.0 * np.sqrt(case.shoe.mass * case.mean_load / case.settled_penetration)
    # the rate of an Euler parameter is half an angular velocity where a body lies level
    arms = {0: 1.0, 1: 1.0, 2: 1.0, 4: case.shoe.width, 5: case.shoe.length, 6: case.shoe.width}
    for node in nodes:
        for coordinate, arm in arms.items():
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, coordinate_marker(mbs, node, coordinate)],
                    damping=damping * arm**2,
                )
            )


class FrontShoe:
    """The front shoe, on which the drive acts."""

    def __init__(self, mbs: "exu.MainSystem", tables: Tables, shoes: Shoes) -> None:
        self._mbs, markers, k = mbs, tables.markers, tables.joints.drive
        is_rigid = tables.bodies.modal[markers.body[k]] < 0
        self._node, modal = shoes.nodes[-1], [] if is_rigid else shoes.modal_nodes[-1:]
        self._place, rows = markers.position[k], markers.displacement[k]
        self._rows = rows[:, : 0 if is_rigid else None]
        empty = [mbs.AddNode(items.NodePointGround())] if is_rigid else []
        self._markers = [
            mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node))
            for node in (*empty, self._node, *modal)
        ]
        self._last = SIZE if is_rigid else rows.shape[1]

    def drive(self, speed: StepProfile) -> int:
        """Prescribe the velocity along x of the point that the drive moves."""
        return self._prescribe("drive", self._along_x, speed)

    def turn(self, rate: StepProfile) -> int:
        """Prescribe the angular velocity about the shoe's own z axis."""
        return self._prescribe("turn", lambda R, z: (np.zeros(3), R[:, 2], 0.0 * z), rate)

    def holds(self, fixed: int) -> list[int]:
        """Keep the shoe at rest in x, y and about z.

        Along x it is held where the drive will act: from another place the run would start with a jolt.
        """
        name, start = "hold of the front shoe", self._place[0]
        start += self._mbs.GetNode(self._node)["referenceCoordinates"][0]

        def gap(_mbs, _t, _item, q, _q_t, _velocity_level):
            R = matrices_of(np.array(q[3:SIZE]))
            return [q[0] + float(R[0] @ self._point(np.array(q[SIZE:]))) - start]

        def turned(_mbs, _t, _item, q, _q_t, _velocity_level):
            return [float(matrices_of(np.array(q[3:SIZE]))[0, 1])]

        def turning(R: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            return np.zeros(3), np.cross(R[:, 1], X), 0.0 * z

        return [
            self._constrain(f"{name} (x)", self._along_x, gap, velocity_level=False),
            hold(self._mbs, fixed, self._node, 1, f"{name} (y)"),
            self._constrain(f"{name} (rotation about z)", turning, turned, velocity_level=False),
        ]

    def _point(self, z: np.ndarray) -> np.ndarray:
        return self._place + self._rows @ z

    def _along_x(self, R: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return X, np.cross(R @ self._point(z), X), self._rows.T @ R[0]

    def _row(self, direction: Direction, q: list[float]) -> np.ndarray:
        """Row of the Jacobian of a constraint, at coordinates that come with those of reference."""
        values = np.array(q)
        e = values[3:SIZE]
        force, moment, modal = direction(matrices_of(e), values[SIZE:])
        return np.concatenate((force, rate_matrix(e).T @ moment, modal))

    def _prescribe(self, name: str, direction: Direction, speed: StepProfile) -> int:
        """On velocity level a halved step leaves no error in the acceleration."""
        value = _at_time(speed.value)

        def gap(_mbs, t, _item, q, q_t, _velocity_level):
            return [float(self._row(direction, q) @ np.array(q_t)) - value(t)]

        return self._constrain(name, direction, gap, velocity_level=True)

    def _constrain(
        self, name: str, direction: Direction, gap: Callable[..., list[float]], velocity_level: bool
    ) -> int:
        """Constraint whose reaction acts in a direction."""

        def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
            return self._row(direction, q)[None, :]

        return self._mbs.AddObject(
            items.ObjectConnectorCoordinateVector(
                name=name,
                markerNumbers=self._markers,
                scalingMarker1=np.zeros((1, self._last)),
                constraintUserFunction=gap,
                jacobianUserFunction=jacobian,
                velocityLevel=velocity_level,
            )
        )
