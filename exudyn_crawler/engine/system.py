"""Multibody system of a case with Exudyn's own items, the second formulation.

Exudyn forms the equations of motion, with Euler parameters instead of angles and its own floating frames of
reference, and differentiates them numerically. The forces of ground, wheels, teeth and arms are one user
force, which calls the kernels of the compiled equations. States are those of the compiled equations. This
formulation is the check of the compiled equations.
"""

import dataclasses
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.engine import bodies, drive, euler_parameters, machine, spheres
from exudyn_crawler.engine.kernel_forces import KernelForces
from exudyn_crawler.errors import LeftMapError
from exudyn_crawler.ground import terrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.model import state, track_system
from exudyn_crawler.model.assemble import Assembly, assemble
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.diagnostics import NewtonError
from exudyn_crawler.model.exudyn import exu, integrator, items, sparse
from exudyn_crawler.model.forces.cells import CellWorkspace, OnCells, TrackOnCells
from exudyn_crawler.model.gear import GearForces
from exudyn_crawler.model.layout import layout_of

SHARPENING = 0.1
"""Tolerance of the iteration, fraction of the residual that ends a step: with the Jacobian of an earlier step
the iteration ends just below its tolerance, with a new one far below."""

PULLS, SAME_PULL = 50, 1e-10
"""Greatest number of repetitions of the initial multipliers, and their relative change that ends them."""

FREE_ROTATION = 4
"""Index of the zero multiplier among the six of Exudyn's joint, whose rotation about y is free."""


class ExudynSystem(track_system.TrackSystem):
    """Multibody system of a case with Exudyn's items.

    `static` holds the front shoe in x, y and about z instead of driving it, and keeps the loads of t = 0. It
    adds aids for the search for rest: friction on slopes, dashpots on uneven ground. It serves shoes alone; a
    machine on them raises ValueError. `general` is Exudyn's contact, if the case uses it.
    """

    def __init__(self, case: Case, static: bool = False) -> None:
        if static and case.gear.bodies:
            kind = case.gear.kind
            raise ValueError(f"gear.kind must be 'dragged' for a rest of Exudyn's items, got {kind!r}")
        assembly = assemble(case)
        super().__init__(case, assembly)
        table = assembly.tables.bodies
        size = (
            6 * len(table.mass)
            + self.contact.coordinates.size
            + int((table.modal >= 0).sum()) * len(assembly.tables.modes.stiffness)
        )
        self._coordinates = euler_parameters.BodyCoordinates(table.reference, table.coordinate, size)
        # the forces of a machine, by the compiled equations of the same tables
        self._kernels = CompiledSystem(case, assembly) if case.gear.bodies else None
        self.general: exu.GeneralContact | None = None
        self._cause = ""  # cause of an early end of a run
        self._solver: Any = None  # that integrates, else None
        self._covered = 0.0  # time for which the cells are covered, s
        self._assemble(assembly, static)
        if not static:
            self.switch_drive(True)
        self.layout, self._rows = self._layout_of(assembly)

    def _assemble(self, assembly: Assembly, static: bool) -> None:
        """Add all items."""
        mbs = self.mbs
        case = self.case
        tables = assembly.tables
        contact = self.contact
        gravity = case.gravity_vector()
        # coordinates come in the order of the nodes
        nodes = bodies.add_shoe_nodes(mbs, tables)
        ground = []
        if isinstance(contact.coordinates, terrain.UnitCoordinates):
            ground = bodies.add_units(mbs, case)
        elif contact.coordinates.size:
            ground = bodies.add_terrain_modes(mbs, tables, gravity)
        shoes = bodies.add_shoes(mbs, tables, nodes, gravity)
        self._shoe_bodies = shoes.bodies
        if self._kernels is not None:
            self._assemble_machine(assembly, self._kernels, shoes, [*nodes, *ground, *shoes.modal_nodes])
            return
        for (name, _), pin in zip(assembly.rows, tables.joints.pins.markers, strict=False):
            ends = [shoes.markers[end] for end in pin]
            mbs.CreateGenericJoint(name, ends, constrainedAxes=[1, 1, 1, 1, 0, 1])
        drive.add_loads(mbs, case, tables, shoes, static)
        if isinstance(contact, PairGroundContact):
            self._add_force([*nodes, *ground, *shoes.modal_nodes], contact.forces)
        elif isinstance(contact, CellGroundContact):
            work = CellWorkspace.allocate(tables.forces.cells, contact.ground.shoes)
            self.cells = TrackOnCells(contact.ground, OnCells(tables.bodies, tables.forces.cells, work))
            self._add_force([*nodes, *shoes.modal_nodes], self.cells.forces)
        else:
            self.general = spheres.add_spheres(mbs, case, shoes.bodies, ground, static)
        if static:
            drive.add_hold(mbs, case, tables, shoes)
        else:
            self._drives = drive.add_drive(mbs, tables, shoes, drive.speeds_of(case.drive))
        mbs.Assemble()

    def _assemble_machine(
        self, assembly: Assembly, kernels: CompiledSystem, shoes: bodies.Shoes, nodes: list[int]
    ) -> None:
        """Add joints, loads and forces of a machine on its tracks."""
        mbs = self.mbs
        tables = assembly.tables
        joints = tables.joints
        names = [name for name, _ in assembly.rows]
        pins = len(joints.pins.markers)
        springs = machine.add_pins(mbs, names[:pins], joints.pins, shoes.markers)
        inputs = machine.at_time(kernels)
        self._drives = drive.add_drive(mbs, tables, shoes, lambda time: inputs(time).speeds)
        holds = len(joints.holds.coordinates)
        machine.add_holds(mbs, names[pins + machine.DRIVES :][:holds], joints.holds.coordinates, shoes)
        motors = machine.add_motors(mbs, names[pins + machine.DRIVES + holds :], kernels, shoes)
        machine.add_wrenches(mbs, kernels, shoes.markers)
        self.cells = kernels.cells
        forces = KernelForces(kernels, self._coordinates)
        system = weakref.proxy(self)  # the engine does not free what its functions refer to
        moved = self._drives[0]

        def force(mbs, t, _item, q, q_t):
            at = t, np.array(q), np.array(q_t)
            system._cover(*at)
            data = mbs.systemData
            return forces.forces(*at, data.GetAECoordinates()[data.GetObjectLTGAE(moved)[0]])

        def stiffness(_mbs, t, _item, q, q_t, position, velocity):
            at = t, np.array(q), np.array(q_t)
            system._cover(*at)
            return sparse(forces.stiffness(*at, position, velocity))

        mbs.AddObject(
            items.ObjectGenericODE2(
                "kernels",
                nodes,
                exu.MatrixContainer(),
                forceUserFunction=force,
                jacobianUserFunction=stiffness,
            )
        )
        mbs.Assemble()
        self._reactions = machine.Reactions(
            tables.markers.body[joints.pins.markers[:, 0]],
            [[shoes.markers[end] for end in pair] for pair in joints.pins.markers],
            springs,
            bool(joints.pins.in_plane),
            joints.holds.coordinates,
            motors,
        )

    def _add_force(self, nodes: list[int], forces: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        """Add the ground's forces on a state's coordinates, by these and their rates, as one user force."""
        coordinates = self._coordinates
        system = weakref.proxy(self)

        def force(_mbs, t, _item, q, q_t):
            places = np.array(q)
            system._cover(t, places, np.array(q_t))
            return coordinates.forces_of_state(places, forces(*coordinates.to_state(places, np.array(q_t))))

        massless = exu.MatrixContainer()
        self.mbs.AddObject(items.ObjectGenericODE2("contact", nodes, massless, forceUserFunction=force))

    def after_step(self, report: Callable[[float], bool] | None) -> None:
        """Call a function after each step, see `TrackSystem`; before the call cells store the step."""
        cells = self.cells
        if cells is None or report is None:
            super().after_step(report)
            return

        def remembered(time: float) -> bool:
            if self._cause:
                return False
            state = np.stack(self.coordinates())
            if self._kernels is None:
                cells.forces(*state[:2])
            else:
                self._kernels.residual(state, self._kernels.inputs(time))
            cells.commit()
            return report(time)

        super().after_step(remembered)

    def _cover(self, time: float, q: np.ndarray, q_t: np.ndarray) -> None:
        """Freeze the cells under the shoes where a step is predicted to end, as the compiled equations do.

        The first evaluation of a step up to a time (s) is at Exudyn's prediction, which has no accelerations:
        those of the last step are added.
        """
        solver = self._solver
        if self.cells is None or solver is None or time == self._covered:
            return
        self._covered = time
        data: Any = self.mbs.systemData
        start = exu.ConfigurationType.StartOfStep
        before = data.GetODE2Coordinates(start), data.GetODE2Coordinates_t(start)
        last = self._coordinates.to_state(*map(np.array, before), data.GetODE2Coordinates_tt(start))[2]
        h, beta = solver.it.currentStepSize, solver.newmarkBeta
        # changes of coordinates and rates by a change of the accelerations
        change = (1.0 - solver.alphaF) / (1.0 - solver.alphaM) * beta * h * h * last
        predicted = self._coordinates.to_state(q, q_t)
        rate = solver.newmarkGamma / (h * beta)
        try:
            self.cells.cover(np.stack((predicted[0] + change, predicted[1] + rate * change, last)))
        except LeftMapError as error:
            self._cause = str(error)

    def _layout_of(self, assembly: Assembly) -> tuple[state.StateLayout, np.ndarray]:
        """Return the layout of the states, and the rows of their multipliers in Exudyn.

        Exudyn's other items follow the joints of the compiled equations. A state does not have the
        multipliers of the norms of Euler parameters.
        """
        data = self.mbs.systemData
        compiled = layout_of(self.case, assembly)
        if self._kernels is not None:
            return compiled, machine.equations_of(self.mbs, assembly)
        norms = {row for body in self._shoe_bodies for row in data.GetObjectLTGAE(body)}
        rows: dict[str, list[int]] = {name: [] for name, _ in compiled.multipliers}
        for number in range(data.NumberOfObjects()):
            of_item = [row for row in data.GetObjectLTGAE(number) if row not in norms]
            if len(of_item) == 6:
                del of_item[FREE_ROTATION]
            rows[self.mbs.GetObject(number)["name"]] = of_item
        layout = dataclasses.replace(
            compiled,
            terrain=self.contact.coordinates.size,
            terrain_bodies=isinstance(self.contact.coordinates, terrain.UnitCoordinates),
            multipliers=tuple((name, len(of_item)) for name, of_item in rows.items() if len(of_item)),
            contact=compiled.contact if self.general is None else 6,
        )
        return layout, np.concatenate([*rows.values()]).astype(int)

    def coordinates(self) -> list[np.ndarray]:
        """Return the current coordinates, rates and accelerations, in the layout's order."""
        data: Any = self.mbs.systemData
        rates = data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()
        return self._coordinates.to_state(*rates)

    @property
    def multipliers(self) -> np.ndarray:
        """Multipliers of all constraints; see `TrackSystem`."""
        own = self._equations(np.array(self.mbs.systemData.GetAECoordinates()))
        if self._kernels is None:
            return own
        state = self.coordinates()[0]
        bodies = self._kernels.tables.bodies
        angles = bodies.reference[:, 3:] + state[bodies.coordinate[:, None] + np.arange(3, 6)]
        return self._reactions.multipliers(self.mbs, own, angles)

    def _equations(self, values: np.ndarray) -> np.ndarray:
        """Return the values of Exudyn's algebraic equations in the layout's order, zero where it has none."""
        return np.append(values, 0.0)[self._rows]

    def gear_forces(self, times: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> GearForces:
        """Return the forces of the gear; see `TrackSystem`."""
        if self._kernels is None:
            return super().gear_forces(times, q, q_t)
        return self._kernels.gear_forces(times, q, q_t)

    def set_initial(self, q: np.ndarray, q_t: np.ndarray | None = None) -> None:
        """Set the initial coordinates, and the initial rates; without rates the system starts at rest."""
        none = np.zeros_like(q)
        self._start(np.stack((q, none if q_t is None else q_t, none)))

    def _start(self, state: np.ndarray, multipliers: np.ndarray | None = None) -> None:
        data = self.mbs.systemData
        initial = exu.ConfigurationType.Initial
        q, q_t, q_tt = (values.tolist() for values in self._coordinates.of_state(*state))
        data.SetODE2Coordinates(q, initial)
        data.SetODE2Coordinates_t(q_t, initial)
        data.SetODE2Coordinates_tt(q_tt, initial)
        if self.general is not None:
            # Exudyn searched for touching spheres during assembly, when none was in the ground yet;
            # without an update the track would fall through the first step
            data.SetODE2Coordinates(q)
            self.general.UpdateContacts(self.mbs)
        if self.cells is not None:
            self.cells.put_down(state)
            try:
                self.cells.cover(state)
            except LeftMapError as error:
                raise NewtonError(np.zeros(self.layout.equation_count), False, str(error)) from error

    def stored_contacts(self) -> np.ndarray:
        """Return forces (N) and moments about origins (N m) of Exudyn's contact; see `TrackSystem`."""
        if self.general is None:
            return super().stored_contacts()
        forces = np.asarray(self.general.GetSystemODE2RhsContactForces(copy=True))
        wrenches = self._coordinates.wrenches(np.array(self.mbs.systemData.GetODE2Coordinates()), forces)
        return wrenches[: 6 * self.layout.shoes].reshape(-1, 6)

    def switch_drive(self, on: bool) -> None:
        """Switch the drive of the front shoe on or off."""
        asked = self.case.drive
        active = self.case.gear.active(on, on and asked.turn_rate is not None, asked.slip is not None)
        for item, acts in zip(self._drives, active, strict=True):
            self.mbs.SetObjectParameter(item, "activeConnector", bool(acts))

    def solve(
        self, settings: "exu.SimulationSettings", next_end: Callable[[float], float] | None = None
    ) -> None:
        """Integrate between the times of the settings; see `TrackSystem.solve`."""
        newton = settings.timeIntegration.newton
        newton.numericalDifferentiation.doSystemWideDifferentiation = self.general is not None
        starts = settings.timeIntegration.generalizedAlpha.computeInitialAccelerations
        if starts and self._kernels is not None:
            self._find_pull(settings)
        tolerance = newton.absoluteTolerance
        solver = integrator(self.mbs, next_end)
        newton.absoluteTolerance = SHARPENING * tolerance
        self._solver, self._covered = solver, settings.timeIntegration.startTime
        try:
            if not solver.SolveSystem(self.mbs, settings):
                raise self._failure(solver)
        except exu.InternalError as error:  # a matrix is not finite
            raise self._failure(solver) from error
        finally:
            self._solver = None
            newton.absoluteTolerance = tolerance
        if self._cause:
            raise NewtonError(np.zeros(self.layout.equation_count), False, self._cause)

    def _find_pull(self, settings: "exu.SimulationSettings") -> None:
        """Set the initial multipliers to those with which Exudyn computes them.

        Exudyn's initial accelerations follow from given forces, of which the pull of a drive is a multiplier.
        """
        data: Any = self.mbs.systemData
        initial = exu.ConfigurationType.Initial
        for _ in range(PULLS):
            solver: Any = exu.MainSolverImplicitSecondOrder()
            solver.InitializeSolver(self.mbs, settings)
            own = np.array(data.GetAECoordinates())
            solver.FinalizeSolver(self.mbs, settings)
            change = np.abs(own - data.GetAECoordinates(initial)).max()
            data.SetAECoordinates(own.tolist(), initial)
            if change <= SAME_PULL * np.abs(own).max():
                return

    def rest(self, settings: "exu.SimulationSettings") -> np.ndarray:
        """Return the coordinates at rest of a static system, from its initial ones; else `NewtonError`."""
        newton = settings.staticSolver.newton
        newton.numericalDifferentiation.doSystemWideDifferentiation = self.general is not None
        try:
            self.mbs.SolveStatic(settings)
        except (exu.SolverError, exu.InternalError) as error:  # the latter where a matrix is not finite
            raise self._failure(self.mbs.sys["staticSolver"]) from error
        return self.coordinates()[0]

    def _failure(self, solver: Any) -> NewtonError:
        """Return the error of a failed solver with its last residual, in the layout's equations."""
        q = np.array(self.mbs.systemData.GetODE2Coordinates())
        # the dynamic solver scales the equations of motion by the factor from accelerations to displacements
        scale = 1.0 if solver.IsStaticSolver() else solver.newmarkBeta * solver.it.currentStepSize**2
        forces, gaps = np.split(np.array(solver.GetSystemResidual()), [len(q)])
        residual = np.concatenate((self._coordinates.wrenches(q, forces / scale), self._equations(gaps)))
        return NewtonError(residual, bool(solver.conv.linearSolverFailed))
