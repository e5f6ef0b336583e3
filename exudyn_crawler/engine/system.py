"""Multibody system of a case with Exudyn's own items, the second formulation.

Exudyn forms the equations of motion, with Euler parameters instead of angles and its own floating frames of
reference, and differentiates them numerically. The contact of shoes and ground is one user force that calls
the kernel of the compiled equations. States are those of the compiled equations. This formulation serves
every case without rollers, and as a check of the compiled equations.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.engine import bodies, drive, euler_parameters, spheres
from exudyn_crawler.errors import LeftMapError
from exudyn_crawler.ground import terrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.model import state, track_system
from exudyn_crawler.model.assemble import Assembly, assemble
from exudyn_crawler.model.diagnostics import NewtonError
from exudyn_crawler.model.exudyn import exu, integrator, items
from exudyn_crawler.model.forces.cells import CellWorkspace, OnCells, TrackOnCells
from exudyn_crawler.model.layout import layout_of

SHARPENING = 0.1
"""Tolerance of the iteration, fraction of the residual that ends a step: with the Jacobian of an earlier step
the iteration ends just below its tolerance, with a new one far below."""

FREE_ROTATION = 4
"""Index of the zero multiplier among the six of Exudyn's joint, whose rotation about y is free."""


class ExudynSystem(track_system.TrackSystem):
    """Multibody system of a case with Exudyn's items; ValueError for bodies beside the shoes.

    `static` holds the front shoe in x, y and about z instead of driving it, and keeps the loads of t = 0. It
    adds aids for the search for rest: friction on slopes, dashpots on uneven ground. `general` is Exudyn's
    contact, if the case uses it.
    """

    def __init__(self, case: Case, static: bool = False) -> None:
        if case.gear.bodies:
            kind = case.gear.kind
            raise ValueError(f"gear.kind must be 'dragged' for a system of Exudyn's items, got {kind!r}")
        assembly = assemble(case)
        super().__init__(case, assembly)
        self._coordinates = euler_parameters.BodyCoordinates(assembly.tables.bodies.reference)
        self.general: exu.GeneralContact | None = None
        self._cause = ""  # cause of an early end of a run
        self._assemble(assembly, static)
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
            self._drives = drive.add_drive(mbs, case, tables, shoes)
        mbs.Assemble()

    def _add_force(self, nodes: list[int], forces: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        """Add the ground's forces on a state's coordinates, by these and their rates, as one user force."""
        coordinates = self._coordinates

        def force(_mbs, _t, _item, q, q_t):
            places = np.array(q)
            return coordinates.forces_of_state(places, forces(*coordinates.to_state(places, np.array(q_t))))

        massless = exu.MatrixContainer()
        self.mbs.AddObject(items.ObjectGenericODE2("contact", nodes, massless, forceUserFunction=force))

    def after_step(self, report: Callable[[float], bool] | None) -> None:
        """Call a function after each step, see `TrackSystem`.

        Before the call cells store the step in their memory; after it the cells below the shoes are prepared.
        """
        cells = self.cells
        if cells is None or report is None:
            super().after_step(report)
            return

        def remembered(time: float) -> bool:
            state = np.stack(self.coordinates())
            cells.forces(*state[:2])
            cells.commit()
            goes_on = report(time)
            try:
                cells.cover(state)
            except LeftMapError as error:
                self._cause = str(error)
            return goes_on and not self._cause

        super().after_step(remembered)

    def _layout_of(self, assembly: Assembly) -> tuple[state.StateLayout, np.ndarray]:
        """Return the layout of the states, and the rows of their multipliers in Exudyn.

        Exudyn's other items follow the joints of the compiled equations. A state does not have the
        multipliers of the norms of Euler parameters.
        """
        data = self.mbs.systemData
        compiled = layout_of(self.case, assembly)
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
        return np.array(self.mbs.systemData.GetAECoordinates())[self._rows]

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
        speeds = self.case.drive.speed, self.case.drive.turn_rate
        for item, speed in zip(self._drives, speeds, strict=True):
            self.mbs.SetObjectParameter(item, "activeConnector", on and speed is not None)

    def solve(
        self, settings: "exu.SimulationSettings", next_end: Callable[[float], float] | None = None
    ) -> None:
        """Integrate between the times of the settings; see `TrackSystem.solve`."""
        newton = settings.timeIntegration.newton
        newton.numericalDifferentiation.doSystemWideDifferentiation = self.general is not None
        tolerance = newton.absoluteTolerance
        solver = integrator(self.mbs, next_end)
        newton.absoluteTolerance = SHARPENING * tolerance
        try:
            if not solver.SolveSystem(self.mbs, settings):
                raise self._failure(solver)
        except exu.InternalError as error:  # a matrix is not finite
            raise self._failure(solver) from error
        finally:
            newton.absoluteTolerance = tolerance
        if self._cause:
            raise NewtonError(np.zeros(self.layout.equation_count), False, self._cause)

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
        residual = np.concatenate((self._coordinates.wrenches(q, forces / scale), gaps[self._rows]))
        return NewtonError(residual, bool(solver.conv.linearSolverFailed))
