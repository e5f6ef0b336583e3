"""Multibody system of a case of Exudyn's own items: the other formulation.

Exudyn forms the equations of motion, with Euler parameters in place of angles and its own floating frames of
reference, and differentiates them numerically; the contact of shoes and ground is one user force that calls
the kernel of the compiled equations. States are those of the compiled equations. It carries every case
without rollers; the compiled equations are checked against it.
"""

import dataclasses
import math
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.ground import contact, rotations, sphere_contact, terrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.model import build, compiled_system, state, track_system
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.exudyn import bodies, drive, euler_parameters
from exudyn_crawler.model.forces.cells import CellWorkspace, OnCells, TrackOnCells

CELL = 1.0
"""m, least side of the cells of the engine's search tree."""
NO_FRICTION = 1e-12
"""In place of zero: without friction Exudyn leaves out the normal forces' moment on the units."""


def add_spheres(
    mbs: "exu.MainSystem", case: Case, bodies: Sequence[int], unit_nodes: Sequence[int], static: bool
) -> "exu.GeneralContact":
    """Spheres of a case on the bodies of its shoes, and faces of its units, two triangles each.

    Damping and friction are those of `case.sphere_contact()`, the stiffness is `case.sphere_stiffness`.
    `static` leaves friction out: at rest there is none, and on the way to it the track would creep.
    """
    spheres, terrain, centers = (
        case.sphere_contact(),
        case.unit_terrain(),
        sphere_contact.sphere_centers(case),
    )
    friction = NO_FRICTION if static else max(spheres.friction, NO_FRICTION)
    contact = mbs.AddGeneralContact()
    contact.frictionProportionalZone = spheres.friction_speed
    contact.SetFrictionPairings(np.array([[friction]]))
    contact.computeContactForces = True
    contact.sphereSphereContact = False
    # otherwise an edge pushes with half the force, as if two triangles shared it
    contact.excludeDuplicatedTrigSphereContactPoints = True
    (x0, x1), (y0, y1) = terrain.bounds
    tops = terrain.top_heights
    sides = [math.ceil((high - low) / CELL) for low, high in terrain.bounds]
    contact.SetSearchTreeCellSize([*(max(1, side) for side in sides), 1])
    contact.SetSearchTreeBox([x0, y0, tops.min() - 1.0], [x1, y1, tops.max() + 1.0])
    # the stiffnesses of both partners act in series, their dampings add
    law: dict[str, Any] = {
        "contactStiffness": 2.0 * case.sphere_stiffness,
        "contactDamping": 0.5 * spheres.damping / spheres.count,
        "frictionMaterialIndex": 0,
    }
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width]) - sphere_contact.face_inset(case)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    for node, top, slope in zip(unit_nodes, tops, terrain.slopes, strict=True):
        z = 0.5 * terrain.unit_height + top + slope * corners[:, 0]
        contact.AddTrianglesRigidBodyBased(
            rigidBodyMarkerIndex=mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)),
            pointList=np.column_stack((corners, z)).tolist(),
            triangleList=[[0, 1, 2], [0, 2, 3]],
            **law,
        )
    for body in bodies:
        for center in centers:
            marker = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=center))
            contact.AddSphereWithMarker(markerIndex=marker, radius=spheres.radius, **law)
    return contact


SHARPENING = 0.1
"""Of the residual that ends a step: with the Jacobian of an earlier step the iteration ends just below it,
with a new one far below."""

PIN_ROWS = [0, 1, 2, 3, 5]
"""Multipliers of a pin among the six of Exudyn's joint, whose free rotation has one that is zero."""


class ExudynSystem(track_system.TrackSystem):
    """Multibody system of a case of Exudyn's items; a ValueError if it is rolled.

    `static` holds the front shoe in x, y and about z instead of driving it, keeps loads as they are at t = 0,
    and adds what helps to find a rest: friction on slopes, dashpots on uneven ground. `general` is Exudyn's
    contact, where it makes the forces.
    """

    def __init__(self, case: Case, static: bool = False) -> None:
        if case.is_rolled:
            raise ValueError("the case must not be rolled for a system of Exudyn's items")
        parts = build.parts_of(case)
        super().__init__(case, parts)
        self._coordinates = euler_parameters.BodyCoordinates(parts.tables.bodies.reference)
        self.general: exu.GeneralContact | None = None
        joints = self._assemble(parts, static)
        self.layout, self._rows = self._layout_of(parts, joints)
        if not static:
            self.switch_drive(True)

    def _assemble(self, parts: build.Parts, static: bool) -> list[int]:
        """Add all items; gives the joints that the compiled equations have, too."""
        mbs, case, tables, gravity = self.mbs, self.case, parts.tables, self.case.gravity_vector()
        # coordinates come in the order of the nodes
        nodes, ground = bodies.add_shoe_nodes(mbs, tables), []
        if isinstance(self.contact.coordinates, terrain.UnitCoordinates):
            ground = bodies.add_units(mbs, case)
        elif self.contact.coordinates.size:
            ground = bodies.add_terrain_modes(mbs, tables.terrain, gravity)
        shoes = bodies.add_shoes(mbs, tables, nodes, bodies.points_of(tables), gravity)
        self._shoe_bodies = shoes.bodies
        joints = []
        for p, (link, side) in enumerate(parts.pins):
            ends = shoes.markers[2 * p : 2 * p + 2]
            joints.append(
                mbs.CreateGenericJoint(state.pin_name(side, link), ends, constrainedAxes=[1, 1, 1, 1, 0, 1])
            )
        drive.add_loads(mbs, case, shoes.markers[2 * len(joints) : -1], static)
        if isinstance(self.contact, contact.PairGroundContact):
            self._add_force([*nodes, *ground, *shoes.modal_nodes], self.contact.forces)
        elif isinstance(self.contact, CellGroundContact):
            work = CellWorkspace.allocate(tables.cells, self.contact.ground.shoes)
            self._cells = TrackOnCells(self.contact.ground, OnCells(tables.bodies, tables.cells, work))
            self._add_cells(self._cells, [*nodes, *shoes.modal_nodes])
        else:
            self.general = add_spheres(mbs, case, shoes.bodies, ground, static)
        if static:
            bounces = self.general is not None and not case.terrain.is_even
            self._drives = [drive.add_hold(mbs, case, shoes, tables.bodies.mass, dashpots=bounces)]
        else:
            self._drives = drive.add_drive(mbs, case, tables, shoes)
        mbs.Assemble()
        return joints + self._drives

    def _add_force(self, nodes: list[int], forces: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        """Forces of the ground on all coordinates of a state, at these and their rates, as one user force."""
        coordinates = self._coordinates

        def force(_mbs, _t, _item, q, q_t):
            own = np.array(q)
            return coordinates.forces_of_state(own, forces(*coordinates.to_state(own, np.array(q_t))))

        massless = exu.MatrixContainer()
        self.mbs.AddObject(
            items.ObjectGenericODE2(
                name="contact", nodeNumbers=nodes, massMatrix=massless, forceUserFunction=force
            )
        )

    def _add_cells(self, cells: TrackOnCells, nodes: list[int]) -> None:
        """Ground of cells under the shoes, covered and committed about each step."""
        reference = self.contact.shoe_reference
        # the engine keeps these functions, and they would keep the system
        system = weakref.proxy(self)

        def forces(q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
            wrenches, modal = cells.press(np.stack((q, q_t)))
            angles = reference[:, 3:] + q[: reference.size].reshape(-1, 6)[:, 3:]
            wrenches[:, 3:] = rotations.moments_on_angles(angles, wrenches[:, 3:])
            return np.concatenate((wrenches.ravel(), modal.ravel()))

        def cover(_mbs, _time):
            cells.cover(np.stack(system.coordinates()))
            return True

        self._add_force(nodes, forces)
        self.mbs.SetPreStepUserFunction(cover)

    def after_step(self, report: Callable[[float], bool] | None) -> None:
        """As of `TrackSystem`; cells remember each step first."""
        cells, ends = self._cells, report
        if cells is None or ends is None:
            super().after_step(ends)
            return

        def remembered(time: float) -> bool:
            cells.press(np.stack(self.coordinates()))
            cells.commit()
            return ends(time)

        super().after_step(remembered)

    def _layout_of(self, parts: build.Parts, joints: list[int]) -> tuple[state.StateLayout, np.ndarray]:
        """Layout of the states, and where Exudyn has their multipliers.

        Behind the joints of the compiled equations come Exudyn's other items; the norm of Euler parameters
        is none of the state's.
        """
        data, multipliers, rows = self.mbs.systemData, [], []
        norms = {row for body in self._shoe_bodies for row in data.GetObjectLTGAE(body)}
        others = set(range(data.NumberOfObjects())) - {*map(int, joints)}
        for k, number in enumerate([*joints, *sorted(others)]):
            of_item = [row for row in data.GetObjectLTGAE(number) if row not in norms]
            if k < len(parts.pins):
                of_item = [of_item[row] for row in PIN_ROWS]
            if of_item:
                multipliers.append((self.mbs.GetObject(number)["name"], len(of_item)))
                rows += of_item
        layout = compiled_system.layout_of(self.case, parts.tables, parts.pins)
        layout = dataclasses.replace(
            layout,
            terrain=self.contact.coordinates.size,
            terrain_bodies=isinstance(self.contact.coordinates, terrain.UnitCoordinates),
            multipliers=tuple(multipliers),
            contact=layout.contact if self.general is None else 6,
        )
        return layout, np.array(rows, dtype=int)

    def coordinates(self) -> list[np.ndarray]:
        """Current coordinates, rates and accelerations, in the layout's order."""
        data = self.mbs.systemData
        rates = (data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt())
        return self._coordinates.to_state(*map(np.array, rates))

    @property
    def multipliers(self) -> np.ndarray:
        """As of `TrackSystem`."""
        return np.array(self.mbs.systemData.GetAECoordinates())[self._rows]

    def set_initial(self, q: np.ndarray) -> None:
        """Start from rest at the coordinates `q`, on cells at that to which these settle there."""
        if self._cells is not None:
            twin = compiled_system.compiled_system(self.case)
            q = twin.settled(q)
            self._cells.ground.restore(twin.memory())
        self._start(np.stack((q, np.zeros_like(q), np.zeros_like(q))))

    def _start(self, state: np.ndarray, multipliers: np.ndarray | None = None) -> None:
        data, initial = self.mbs.systemData, exu.ConfigurationType.Initial
        own, own_t, own_tt = (values.tolist() for values in self._coordinates.of_state(*state))
        data.SetODE2Coordinates(own, initial)
        data.SetODE2Coordinates_t(own_t, initial)
        data.SetODE2Coordinates_tt(own_tt, initial)
        if self.general is not None:
            # Exudyn looked for touching spheres when it assembled the system, with none in the ground yet,
            # and would let the track fall through the first step
            data.SetODE2Coordinates(own)
            self.general.UpdateContacts(self.mbs)
        if self._cells is not None:
            self._cells.put_down(state)
            self._cells.cover(state)

    def stored_contacts(self) -> np.ndarray:
        """As of `TrackSystem`; of Exudyn's contact forces (N) and moments about the origins (N m)."""
        if self.general is None:
            return super().stored_contacts()
        forces = np.asarray(self.general.GetSystemODE2RhsContactForces(copy=True))
        return self._coordinates.wrenches(np.array(self.mbs.systemData.GetODE2Coordinates()), forces)

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""
        turns = self.case.drive.turn_rate is not None
        for item, is_on in zip(self._drives, (on, on and turns), strict=True):
            self.mbs.SetObjectParameter(item, "activeConnector", is_on)

    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings; errors as of `TrackSystem.solve`."""
        newton = settings.timeIntegration.newton
        newton.numericalDifferentiation.doSystemWideDifferentiation = self.general is not None
        tolerance = newton.absoluteTolerance
        newton.absoluteTolerance = SHARPENING * tolerance
        try:
            self.mbs.SolveDynamic(settings)
        except (exu.SolverError, exu.InternalError) as error:  # the latter where a matrix is not finite
            raise self._failure("dynamicSolver") from error
        finally:
            newton.absoluteTolerance = tolerance

    def rest(self, settings: "exu.SimulationSettings") -> np.ndarray:
        """Coordinates at rest of a system built for statics, from its initial ones, or a `NewtonError`."""
        differences = settings.staticSolver.newton.numericalDifferentiation
        differences.doSystemWideDifferentiation = self.general is not None
        try:
            self.mbs.SolveStatic(settings)
        except exu.SolverError as error:
            raise self._failure("staticSolver") from error
        return self.coordinates()[0]

    def _failure(self, name: str) -> track_system.NewtonError:
        """What a solver left behind that failed, in the layout's equations."""
        solver: Any = self.mbs.sys[name]
        residual = np.array(solver.GetSystemResidual())
        own = np.array(self.mbs.systemData.GetODE2Coordinates())
        if not solver.IsStaticSolver():
            # the solver multiplies the equations of motion by what makes accelerations of displacements
            residual[: len(own)] /= solver.newmarkBeta * solver.it.currentStepSize**2
        forces, gaps = self._coordinates.forces_to_state(own, residual[: len(own)]), residual[len(own) :]
        return track_system.NewtonError(
            np.concatenate((forces, gaps[self._rows])), bool(solver.conv.linearSolverFailed)
        )
