"""A track whose equations are compiled: Exudyn integrates them, and each step is solved here.

Exudyn's generalized-alpha method predicts a step, accepts or halves it and says what comes next; its system
is a single object that has the coordinates and nothing else.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.profile import StepProfile
from exudyn_crawler.ground.contact import pair_ground_contact
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pair_contact import PairGroundContact
from exudyn_crawler.ground.pair_stiffness import TouchingPairs
from exudyn_crawler.ground.rotations import moments_on_angles
from exudyn_crawler.model.compiled.elimination import eliminate, solve
from exudyn_crawler.model.compiled.equations import STIFFNESS, evaluate
from exudyn_crawler.model.compiled.inputs import table_of, values_at
from exudyn_crawler.model.compiled.integrator import coordinates_only, predict
from exudyn_crawler.model.compiled.joints import ROWS
from exudyn_crawler.model.compiled.matrix import assemble
from exudyn_crawler.model.compiled.model import track_model
from exudyn_crawler.model.compiled.newton import step
from exudyn_crawler.model.compiled.records import Inputs, Memory, Model, Weights
from exudyn_crawler.model.compiled.rollers import TOUCHED, Rolling, SideFrame
from exudyn_crawler.model.compiled.undercarriage import FrameInputs
from exudyn_crawler.model.drive_point import DrivePoint, drive_point
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.failure import NewtonError
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe
from exudyn_crawler.model.integrated import Integrated
from exudyn_crawler.model.loads import grips
from exudyn_crawler.model.state import RATES, StateLayout, pin_name
from exudyn_crawler.model.terrain import reduced_coordinates

ENGINE_ROWS = 6
"""Multipliers that a state keeps of a pin: the one of the free rotation, always zero, among them."""
HELD = [0, 1, 2, 3, 5]
"""Which of them constrain."""


class CompiledSystem(Integrated):
    """Multibody system of a case by compiled equations; a `formulation.TrackSystem`.

    Attributes
    ----------
    mbs : exudyn.MainSystem
        With the coordinates alone.
    case, contact, floating, point, layout :
        As of `model.system.System`.
    """

    def __init__(
        self, case: Case, contact: PairGroundContact, floating: FloatingShoe | None, point: DrivePoint
    ) -> None:
        self.case, self.contact, self.floating, self.point = case, contact, floating, point
        model, names = track_model(case, contact, floating, point)
        self._model, self._sizes = plain(model), model.sizes
        turning = case.drive.turn_rate is not None
        self.layout = StateLayout(
            shoes=model.sizes.shoes,
            terrain=model.sizes.terrain,
            flexible_shoes=() if case.flexible is None else tuple(case.flexible.shoes),
            modes=model.sizes.modes,
            multipliers=(
                *((pin_name(side, link), ENGINE_ROWS) for link, side in names),
                ("drive", 1),
                *((("turn", 1),) if turning else ()),
            ),
            frame=model.sizes.frame,
        )
        size, multipliers = self.layout.coordinate_count, ROWS * model.sizes.pins + 2
        self.container = exu.SystemContainer()
        self.mbs = coordinates_only(self.container, size)
        self._on = case.undercarriage is None
        self._state = np.zeros((3, size))
        self._multipliers = np.zeros(multipliers)
        self._scratch = (np.zeros(size + multipliers), np.zeros(model.fronts.size))
        self._memory = self._room(contact, model.side)
        self._frame_inputs = FrameInputs(case)
        self._loads = table_of([case.loads.profile(number) for number in case.track.shoes])
        turn = case.drive.turn_rate or StepProfile.constant(0.0)
        self._speeds = table_of([case.drive.speed, turn, case.loads.side_shift])
        self._gravity, self._down = tuple(case.gravity_vector().tolist()), case.terrain.down
        masses = np.where(contact.flexible_rows >= 0, model.flexible.mass, model.rigid.mass)
        self._grip = grips(case, masses)
        self._turning = turning
        self._limits = (0.0, 0)
        self._singular = False

    def _room(self, contact: PairGroundContact, side: SideFrame | tuple[()]) -> tuple:
        """Memory of evaluations."""
        sizes = self._sizes
        places = side.rollers.places if side else np.empty((0, 0, 3))
        return plain(
            Memory(
                contact.unit_reference.copy(),
                np.zeros_like(contact.unit_reference),
                tuple(TouchingPairs.room(contact.greatest_count, sizes.modes)),
                np.zeros((sizes.shoes, 3)),
                np.zeros((sizes.shoes, 3, 3)),
                np.zeros((sizes.shoes, 3, sizes.modes)),
                np.zeros(ROWS * sizes.pins + 2),
                np.zeros((sizes.pins, 2, ROWS, 6 + sizes.modes)),
                np.zeros((2, 6 + sizes.modes)),
                overlap_workspace(),
                tuple(Rolling.room(len(places), places.shape[1], sizes.modes)) if side else (),
            )
        )

    @property
    def treads(self) -> Callable[[float, NDArray, NDArray], tuple[NDArray, NDArray, NDArray]] | None:
        """As of `formulation.TrackSystem`."""
        return self._treads if self.layout.frame else None

    def _treads(self, time: float, q: NDArray, q_t: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        state = np.stack((q, q_t, np.zeros_like(q)))
        residual, none = np.empty_like(self._scratch[0]), np.zeros_like(self._multipliers)
        weights = (0.0, 0.0, 0.0, False, 1.0)
        evaluate(self._model, state, none, self._inputs(time), weights, self._memory, residual)
        found = Rolling(*Memory(*self._memory).rolling)
        shape = (len(found.rear), -1, TOUCHED, 3)
        touching = (found.depth > 0.0)[:, None]
        forces, feet = -found.force * touching, found.foot * touching
        return forces.reshape(shape), feet.reshape(shape), found.rear.copy()

    def sunken(self) -> list[int]:
        """None: the pair law pushes a shoe up from any depth."""
        return []

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free; under a side frame it always is."""
        self._on = on and not self.layout.frame

    def set_initial(self, q: NDArray) -> None:
        """Start from rest at the coordinates `q`."""
        self._state[0], self._state[1:] = q, 0.0
        self._multipliers[:] = 0.0
        self._hand_over(exu.ConfigurationType.Initial)

    def set_state(self, row: NDArray) -> None:
        """Start from a row as of `state`; its time goes into the solver's settings."""
        for rate, name in enumerate(RATES):
            self._state[rate] = self.layout.part(row, f"coordinates{name}")
        kept = self.layout.part(row, "multipliers")
        pins = kept[: ENGINE_ROWS * self._sizes.pins].reshape(-1, ENGINE_ROWS)
        drives = kept[ENGINE_ROWS * self._sizes.pins :]
        self._multipliers[:] = [*pins[:, HELD].ravel(), *drives, *[0.0] * (2 - len(drives))]
        self._hand_over(exu.ConfigurationType.Initial)

    def state(self) -> NDArray:
        """Current state in one row, laid out as `layout` says."""
        data, sizes = self.mbs.systemData, self._sizes
        pins = np.zeros((sizes.pins, ENGINE_ROWS))
        pins[:, HELD] = self._multipliers[:-2].reshape(-1, ROWS)
        drives = self._multipliers[-2 : None if self._turning else -1]
        parts: dict[str, ArrayLike] = {
            "time": data.GetTime(),
            "coordinates": data.GetODE2Coordinates(),
            "coordinates rate": data.GetODE2Coordinates_t(),
            "coordinates acceleration": data.GetODE2Coordinates_tt(),
            "multipliers": np.concatenate((pins.ravel(), drives)),
        }
        return self.layout.pack(parts)

    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings; errors as of `formulation.TrackSystem.solve`."""
        newton = settings.timeIntegration.newton
        self._limits = (newton.absoluteTolerance, newton.maxIterations)
        if settings.timeIntegration.generalizedAlpha.computeInitialAccelerations:
            self._accelerate(settings.timeIntegration.startTime)
            settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
        # Exudyn's stub gives a solver's methods without self
        solver: Any = exu.MainSolverImplicitSecondOrder()
        solver.SetUserFunctionNewton(self.mbs, self._newton)
        if not solver.SolveSystem(self.mbs, settings):
            raise self.failure()

    def failure(self) -> NewtonError:
        """Error of the last step that was tried."""
        return NewtonError(self.in_layout(self._scratch[0]), self._singular)

    @property
    def multipliers(self) -> NDArray:
        """Of pins, drive and turn: N and N m."""
        return self._multipliers

    @property
    def pin_rows(self) -> int:
        """Number of the pins' equations."""
        return ROWS * self._sizes.pins

    def pulled_place(self, q: NDArray) -> float:
        """Displacement along x of the point that the drive moves, m, with that of its place in the shoe."""
        front = q[6 * self.layout.shoes - 6 : 6 * self.layout.shoes]
        modal = q[len(q) - self.point.rows.shape[1] :]
        return float(front[0] + self.point.arm(front[3:], modal)[0])

    def at_rest(self, q: NDArray, multipliers: NDArray) -> tuple[NDArray, NDArray]:
        """Residual (coordinates and pins) at rest at t = 0 without the drive, and the drive's direction.

        Parameters
        ----------
        q : array (coordinates,)
        multipliers : array (pin_rows,)
            N and N m.

        Returns
        -------
        residual : array (coordinates + pin_rows,)
            As of `equations.evaluate`.
        direction : array (coordinates,)
            Generalized force of a unit force of the drive.
        """
        given = Inputs(*self._inputs(0.0))
        given.drive[:, 0] = 0.0
        state = np.zeros_like(self._state)
        state[0] = q
        none, residual = (0.0, 0.0, 0.0, False, 1.0), np.empty_like(self._scratch[0])
        both = np.concatenate((multipliers, np.zeros(2)))
        evaluate(self._model, state, both, tuple(given), none, self._memory, residual)
        if self._down[2] > -1.0:
            shoes = residual[: 6 * self.layout.shoes].reshape(-1, 6)
            angles = q[: shoes.size].reshape(-1, 6)[:, 3:]
            shoes[:, :3] -= self._grip[0]
            shoes[:, 3:] -= moments_on_angles(angles, self._grip[1])
        own = Memory(*self._memory).drive[0]
        direction = np.zeros(len(q))
        direction[6 * self.layout.shoes - 6 : 6 * self.layout.shoes] = own[:6]
        if self.point.rows.shape[1]:
            direction[-self.point.rows.shape[1] :] = own[6:]
        return residual[:-2], direction

    def creep(
        self, q: NDArray, multipliers: NDArray, pace: tuple[float, float], limits: tuple[float, int]
    ) -> tuple[NDArray, NDArray, int] | None:
        """One step without inertia from coordinates and multipliers, under the loads of t = 0.

        Parameters
        ----------
        pace : tuple
            Length of the step (s), and force over momentum (1/s) that slows every body.
        limits : tuple
            Residual (N, root mean square) that ends the search, and most iterations.

        Returns
        -------
        tuple, optional
            Coordinates, multipliers and iterations; None if the step is too long to be found.
        """
        h, drag = pace
        self._state[0], self._state[1:] = q, 0.0
        self._multipliers[:] = multipliers
        weights, inputs = (1.0, 1.0 / h, drag / h, False, h), self._inputs(0.0)
        try:
            converged, iterations, *_ = step(
                self._model,
                self._state,
                self._multipliers,
                inputs,
                weights,
                limits,
                self._memory,
                self._scratch,
            )
            self._singular = False
        except np.linalg.LinAlgError:
            converged, self._singular = False, True
        if not (converged and np.isfinite(self._state).all()):
            return None
        return self._state[0].copy(), self._multipliers.copy(), iterations

    def calls(self) -> dict[str, list[tuple[Any, tuple]]]:
        """Compiled functions with arguments as a run calls them, by what they make."""
        residual, values = self._scratch
        inputs, weights = self._inputs(0.0), (0.0, 0.0, 1.0, False, 1.0)
        fronts = tuple(Model(*self._model).fronts)
        both = self._model, self._state
        return {
            "residual": [(evaluate, (*both, self._multipliers, inputs, weights, self._memory, residual))],
            "derivative": [
                (assemble, (*both, inputs, weights, 0, self._memory, values)),
                (eliminate, (fronts, values)),
                (solve, (fronts, values, residual)),
            ],
        }

    def in_layout(self, residual: NDArray) -> NDArray:
        """Residual with or without the drive's, in the order and the units of the layout's equations."""
        coordinates, off = np.split(residual, [self.layout.coordinate_count])
        equations = np.zeros(self.layout.equation_count)
        equations[: len(coordinates)] = coordinates
        pins = np.zeros((self._sizes.pins, ENGINE_ROWS))
        pins[:, HELD] = off[: self.pin_rows].reshape(-1, ROWS) / STIFFNESS
        equations[len(coordinates) : len(coordinates) + pins.size] = pins.ravel()
        drives = off[self.pin_rows :][: 1 + self._turning] / (1.0 if self.layout.frame else STIFFNESS)
        equations[len(coordinates) + pins.size :][: len(drives)] = drives
        return equations

    def _newton(self, solver: Any, _mbs: "exu.MainSystem", settings: "exu.SimulationSettings") -> bool:
        """Predict and solve a step; Exudyn calls it anew with half the step where it fails."""
        predict(solver, self.mbs, settings, self._state)
        h, beta, gamma = solver.it.currentStepSize, solver.newmarkBeta, solver.newmarkGamma
        start = self._multipliers.copy()
        weights = Weights(
            1.0,
            gamma / (h * beta),
            (1.0 - solver.alphaM) / ((1.0 - solver.alphaF) * beta * h * h),
            False,
            beta * h / gamma,
        )
        try:
            converged, *_ = step(
                self._model,
                self._state,
                self._multipliers,
                self._inputs(solver.it.currentTime),
                tuple(weights),
                self._limits,
                self._memory,
                self._scratch,
            )
            self._singular = False
        except np.linalg.LinAlgError:
            converged, self._singular = False, True
        if not converged:
            self._multipliers[:] = start
            return False
        self._hand_over(exu.ConfigurationType.Current)
        return True

    def _inputs(self, time: float) -> tuple:
        sizes, speeds = np.zeros(self._sizes.shoes), np.zeros(3)
        values_at(tuple(self._loads), time, sizes)
        values_at(tuple(self._speeds), time, speeds)
        drive = np.column_stack(([self._on, self._on and self._turning], speeds[:2]))
        frame = self._frame_inputs.at(time)
        return self._gravity, np.outer(sizes, self._down), float(speeds[2]), drive, *frame

    def _accelerate(self, time: float) -> None:
        """Accelerations and multipliers of a track at rest."""
        self._state[2], self._multipliers[:] = 0.0, 0.0
        residual, values = self._scratch
        inputs, weights = self._inputs(time), (0.0, 0.0, 1.0, False, 1.0)
        model = self._model
        TouchingPairs(*Memory(*self._memory).touching).stiffness.fill(0.0)
        contacts = evaluate(model, self._state, self._multipliers, inputs, weights, self._memory, residual)
        assemble(model, self._state, inputs, weights, contacts, self._memory, values)
        fronts = tuple(Model(*model).fronts)
        eliminate(fronts, values)
        # at rest constraints are off by nothing, and their rates do not change by themselves; a frame's
        # balance along x is no constraint
        n = self._state.shape[1]
        residual[n : n + self.pin_rows if self.layout.frame else None] = 0.0
        solve(fronts, values, residual)
        self._state[2] = -residual[:n]
        self._multipliers[:] = -residual[n:]
        self._hand_over(exu.ConfigurationType.Initial)

    def _hand_over(self, to: "exu.ConfigurationType") -> None:
        data = self.mbs.systemData
        data.SetODE2Coordinates(self._state[0], to)
        data.SetODE2Coordinates_t(self._state[1], to)
        data.SetODE2Coordinates_tt(self._state[2], to)


def compiled_system(case: Case) -> CompiledSystem:
    """Build the compiled equations of a case."""
    floating = None if case.flexible is None else floating_shoe(case)
    coordinates = reduced_coordinates(case)
    chosen = [] if case.flexible is None else [number - 1 for number in case.flexible.shoes]
    underside = None if floating is None else floating.underside
    contact = pair_ground_contact(case, coordinates, underside, chosen)
    is_front = case.track.shoe_count - 1 in chosen
    point = drive_point(case, floating.reduced if floating is not None and is_front else None)
    return CompiledSystem(case, contact, floating, point)
