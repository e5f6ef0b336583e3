"""System with compiled equations: Exudyn integrates them in time, and this module solves each step.

Exudyn's generalized-alpha method predicts a step, accepts or halves it and sets the next one. Its system is a
single object with the coordinates alone.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.errors import LeftMapError
from exudyn_crawler.ground import packed, terrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.rows import NO_DERIVATIVES, Weights
from exudyn_crawler.model import elimination, gear, newton, track_system
from exudyn_crawler.model.assemble import Assembly, assemble
from exudyn_crawler.model.diagnostics import NewtonError, in_units
from exudyn_crawler.model.equations import matrix, residual
from exudyn_crawler.model.exudyn import add_coordinates, exu, integrator, predict
from exudyn_crawler.model.forces.cells import OnCells, TrackOnCells
from exudyn_crawler.model.inputs import Inputs, TimedInputs
from exudyn_crawler.model.joints.pin import ROWS
from exudyn_crawler.model.layout import layout_of
from exudyn_crawler.model.tables import SYSTEM, System, Workspace

KEEPS_MATRIX = {
    "dragged": (),
    "rolled": ("cells",),
    "closed": ("units", "cells"),
    "machine": ("units", "cells"),
}
"""Ground on which a step begins with the factored matrix of the last one, by the kind of gear.

There most steps take one iteration with it; elsewhere a new matrix pays.
"""

LAW_ITERATIONS, ROUNDING = 100, 1e-12
"""Greatest number of iterations for forces of play at a given state, and their relative error."""

AT_START = exu.ConfigurationType.Initial, exu.ConfigurationType.Current
"""Configurations of Exudyn's system that have the state of a start."""


class CompiledSystem(track_system.TrackSystem):
    """Multibody system of a case with compiled equations of its `tables`; `mbs` has the coordinates alone.

    `work` is the result of a residual; `block` holds both for compiled functions; `scratch` is the last
    residual and the values of the fronts.
    """

    contact: PairGroundContact | CellGroundContact

    def __init__(self, case: Case, assembly: Assembly) -> None:
        contact = assembly.contact
        reduced = isinstance(contact.coordinates, terrain.TerrainModes)
        if not (reduced and isinstance(contact, PairGroundContact | CellGroundContact)):
            raise ValueError(
                "the case must have contact.model 'pair' or 'cells' and terrain_formulation 'reduced'"
            )
        super().__init__(case, assembly)
        self.tables = assembly.tables
        self.layout = layout_of(case, assembly)
        size = self.layout.coordinate_count
        multipliers = self.tables.multipliers
        add_coordinates(self.mbs, "track", size)
        self.mbs.Assemble()
        self._driven = True
        self._state = np.zeros((3, size))
        self._multipliers = np.zeros(multipliers)
        self.scratch = (np.zeros(size + multipliers), np.zeros(self.tables.fronts.size))
        if isinstance(contact, CellGroundContact):
            self.work = Workspace.allocate(self.tables, 0, contact.ground.shoes)
            on = OnCells(self.tables.bodies, self.tables.forces.cells, self.work.forces.cells)
            self.cells = TrackOnCells(contact.ground, on)
        else:
            self.work = Workspace.allocate(self.tables, contact.greatest_count, packed.nothing(ShoePoints))
        self.block = packed.pack(System(self.tables, self.work), SYSTEM)
        self.timed_inputs = TimedInputs(case, len(self.tables.loads.marker))
        self._limits = newton.Limits(0.0, 0, False)
        self._singular = False
        self._cause = ""  # of a failure, where it is known
        # weights of the factored matrix with which the next step begins; None where that makes its own
        self._factored: Weights | None = None
        self.put_down()

    def gear_forces(self, times: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> gear.GearForces:
        """Return the forces of the gear; see `TrackSystem`."""
        count = self.layout.shoes
        shoes = self.case.gear.shoes_by_strips(self.tables.bodies.modal[:count] >= 0)
        forces = gear.GearForces.allocate(len(times), count, len(shoes), self.work)
        coordinates = np.ascontiguousarray(q)
        rates = np.ascontiguousarray(q_t)
        gear.write_gear_forces(self.block, coordinates, rates, shoes, forces)
        return forces

    def switch_drive(self, on: bool) -> None:
        """Drive the front shoe from now on, or leave it free; a side frame is always driven."""
        self._driven = on

    def inputs(self, time: float) -> Inputs:
        """Return loads and drive at a time, s."""
        return self.timed_inputs.at(time, self._driven)

    def put_down(self) -> None:
        """Start slip on cells at the positions of the shoes before they settle."""
        if self.cells is not None:
            state = np.zeros_like(self._state)
            state[0] = self.first_guess()
            self.cells.put_down(state)

    def set_initial(self, q: np.ndarray, q_t: np.ndarray | None = None) -> None:
        """Start from coordinates, and from rest or from rates."""
        self._state[0] = q
        self._state[1] = 0.0 if q_t is None else q_t
        self._state[2] = 0.0
        self._multipliers[:] = 0.0
        self._hand_over(*AT_START)

    def _start(self, state: np.ndarray, multipliers: np.ndarray) -> None:
        self._state[:] = state
        self._multipliers[:] = multipliers
        if self.cells is not None:
            self.cells.put_down(self._state)
        self._hand_over(*AT_START)

    def coordinates(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the current coordinates, rates and accelerations; see `TrackSystem`."""
        data: Any = self.mbs.systemData
        return data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()

    @property
    def multipliers(self) -> np.ndarray:
        """Multipliers of all constraints; see `TrackSystem`."""
        return self._multipliers

    @property
    def motion(self) -> np.ndarray:
        """Coordinates, rates and accelerations at the start, or after the last step: (3, coordinates)."""
        return self._state.copy()

    def solve(
        self, settings: "exu.SimulationSettings", next_end: Callable[[float], float] | None = None
    ) -> None:
        """Integrate between the times of the settings; see `TrackSystem.solve`."""
        # a run that goes on from here later has no matrix, either
        self._factored = None
        newton_settings = settings.timeIntegration.newton
        most = newton_settings.maxIterations
        self._limits = newton.Limits(newton_settings.absoluteTolerance, most, False)
        if settings.timeIntegration.generalizedAlpha.computeInitialAccelerations:
            self.accelerate(self.inputs(settings.timeIntegration.startTime))
            settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
        solver = integrator(self.mbs, next_end)
        solver.SetUserFunctionNewton(self.mbs, self._newton)
        if not solver.SolveSystem(self.mbs, settings):
            raise self.failure()

    def failure(self) -> NewtonError:
        """Return the error of the last attempted step."""
        return NewtonError(in_units(self.layout, self.scratch[0]), self._singular, self._cause)

    def cover(self, state: np.ndarray) -> None:
        """Freeze the cells under the shoes at a state; raise `NewtonError` if a shoe leaves the map."""
        self._cause = ""
        if self.cells is None:
            return
        try:
            self.cells.cover(state)
        except LeftMapError as error:
            self._cause = str(error)
            raise self.failure() from error

    def residual(
        self,
        state: np.ndarray,
        inputs: Inputs,
        multipliers: np.ndarray | None = None,
        weights: Weights = NO_DERIVATIVES,
    ) -> np.ndarray:
        """Return the residual of all equations at coordinates, rates and accelerations (3, coordinates)."""
        out = np.empty_like(self.scratch[0])
        applied = np.zeros_like(self._multipliers) if multipliers is None else multipliers
        residual(self.block, state, applied, inputs, weights, out)
        return out

    def forces_of_play(self, state: np.ndarray, inputs: Inputs) -> np.ndarray:
        """Return the multipliers of links with play that their contacts give at a state, zero for all others.

        A row of play is the law only where its multiplier is the law's force (`model.joints.play`).
        """
        plays = self.tables.joints.plays
        rows = slice(plays.first, plays.first + ROWS * len(plays.markers))
        count = state.shape[1]
        multipliers = np.zeros_like(self._multipliers)
        for _ in range(LAW_ITERATIONS if len(plays.markers) else 0):
            change = self.residual(state, inputs, multipliers)[count:][rows]
            multipliers[rows] -= change
            if np.abs(change).max() <= ROUNDING * np.abs(multipliers[rows]).max():
                break
        return multipliers

    def step(
        self,
        state: np.ndarray,
        multipliers: np.ndarray,
        inputs: Inputs,
        weights: Weights,
        limits: newton.Limits,
    ) -> tuple[bool, int]:
        """Cover the cells and solve the equations of a step in place, from its prediction; see `newton.step`.

        Return whether Newton's method converged, and its iterations.
        """
        try:
            self.cover(state)
        except NewtonError:
            return False, 0
        try:
            outcome = newton.step(self.block, state, multipliers, inputs, weights, limits, self.scratch)
        except np.linalg.LinAlgError:
            self._singular = True
            return False, 0
        self._singular = False
        return outcome.converged, outcome.iterations

    def _newton(self, solver: Any, _mbs: "exu.MainSystem", settings: "exu.SimulationSettings") -> bool:
        """Predict and solve a step; if it fails, Exudyn calls it again with half the step."""
        predict(solver, self.mbs, settings, self._state)
        h = solver.it.currentStepSize
        beta = solver.newmarkBeta
        gamma = solver.newmarkGamma
        start = self._multipliers.copy()
        weights = Weights(
            1.0,
            gamma / (h * beta),
            (1.0 - solver.alphaM) / ((1.0 - solver.alphaF) * beta * h * h),
            False,
            beta * h / gamma,
        )
        starts_factored = self._factored == weights
        if starts_factored or self.cells is not None:
            # which cells load and which unload is seen best with the accelerations as they were; an old
            # matrix then has the less to do
            last: Any = self.mbs.systemData.GetODE2Coordinates_tt(exu.ConfigurationType.StartOfStep)
            self._state += np.multiply.outer(weights[:3], last / weights.acceleration)
        limits = self._limits._replace(factored=starts_factored)
        inputs = self.inputs(solver.it.currentTime)
        converged, iterations = self.step(self._state, self._multipliers, inputs, weights, limits)
        keeps_matrix = self.case.terrain.model in KEEPS_MATRIX[self.case.gear.kind]
        self._factored = weights if keeps_matrix and converged and iterations == 1 else None
        if not converged:
            self._multipliers[:] = start
            return False
        self._store()
        return True

    def accept(self, time: float, state: np.ndarray, multipliers: np.ndarray) -> None:
        """Take over a step up to a time (s) that was solved elsewhere, at its last residual; see `step`."""
        self._state[:] = state
        self._multipliers[:] = multipliers
        data: Any = self.mbs.systemData
        data.SetTime(time)
        self._store()

    def _store(self) -> None:
        """Store the solved step in the cells' memory and in Exudyn's system."""
        if self.cells is not None:
            self.cells.commit()
        self._hand_over(exu.ConfigurationType.Current)

    def accelerate(self, inputs: Inputs) -> None:
        """Write the accelerations and multipliers of a track at its start under loads and drive.

        The factored matrix of accelerations stays in `scratch`.
        """
        self._state[2] = 0.0
        self.cover(self._state)
        self._multipliers[:] = self.forces_of_play(self._state, inputs)
        weights = Weights(0.0, 0.0, 1.0, False, 1.0)
        values = self.scratch[1]
        out = self.residual(self._state, inputs, self._multipliers, weights)
        matrix(self.block, weights, values)
        fronts = self.tables.fronts
        elimination.eliminate(fronts, values)
        # at rest constraints have no gap, and their rates do not change by themselves; what a law gives acts
        count = self._state.shape[1]
        out[count:][self.work.joints.share != 1.0] = 0.0
        elimination.solve(fronts, values, out)
        self._state[2] = -out[:count]
        self._multipliers -= out[count:]
        self._hand_over(*AT_START)

    def _hand_over(self, *configurations: "exu.ConfigurationType") -> None:
        """Write coordinates, rates and accelerations into Exudyn's system."""
        data: Any = self.mbs.systemData
        for to in configurations:
            # into Exudyn's own memory, not a copy: what sets coordinates takes them number by number
            data.GetODE2Coordinates(to, False)[:] = self._state[0]
            data.GetODE2Coordinates_t(to, False)[:] = self._state[1]
            data.GetODE2Coordinates_tt(to, False)[:] = self._state[2]

    @property
    def pin_rows(self) -> int:
        """Number of the pins' equations, with those of their friction."""
        return self.tables.joints.drive.first


def compiled_system(case: Case) -> CompiledSystem:
    """Build the compiled equations of a case."""
    return CompiledSystem(case, assemble(case))
