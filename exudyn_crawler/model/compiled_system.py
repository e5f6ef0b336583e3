"""A system whose equations are compiled: Exudyn integrates them, and each step is solved here.

Exudyn's generalized-alpha method predicts a step, accepts or halves it and says what comes next; its system
is a single object that has the coordinates and nothing else.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.ground import packed, pairs, terrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.cells.kernel import ShoePoints
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.rotations import NO_DERIVATIVES, Weights, moments_on_angles
from exudyn_crawler.model import build, elimination, gear, joints, newton, state, track_system
from exudyn_crawler.model.engine import add_coordinates, exu, predict
from exudyn_crawler.model.equations import STIFFNESS, matrix, residual
from exudyn_crawler.model.forces.cells import OnCells, TrackOnCells
from exudyn_crawler.model.forces.loads import profiles_of, static_friction, values_at
from exudyn_crawler.model.tables import SYSTEM, Inputs, System, Tables, Workspace

DRAG, CLOSED_DRAG = 100.0, 8.0
"""1/s, force over momentum that slows every body in creeping, so that shoes slip slowly; of a closed chain,
whose runs swing slowly and stand no still shoes."""
FIRST_DRAG, MOST_DRAG = 1e5, 1e9
"""1/s, with which a closed chain starts to creep; it falls by half with every step that is found with some
ease. Slow shoes hardly slip, and no damping is felt: from where it was assembled nothing else is found."""
FIRST_STEP, SLOWED_STEP, LONGEST_STEP, LEAST_STEP = 5e-3, 0.05, 0.2, 1e-7
"""s, of creeping; the second one of a chain whose drag still falls."""
FEW, SOME, MANY = 8, 12, 25
"""Iterations below which the next step of creeping is longer, below which drag falls, and most of them."""
SETTLING, UNEVEN_SETTLING, SETTLING_LIMITS = 4.0, 60.0, (1e-2, MANY)
"""s in which shoes creep to their rest on cells that remember them, and dragged ones that tilt on edges of
uneven ones; limits as of `creep`."""


def layout_of(case: Case, tables: Tables, pins: list[tuple[int, str]]) -> state.StateLayout:
    """Layout of the states of a case; `pins` name link (from 1) and side of each."""
    turned = state.TUMBLERS[case.tracks] if case.is_closed else ()
    turned += state.IDLERS[case.tracks] if case.has_tensioners else ()
    others = turned if case.running_gear is None else (state.SIDE_FRAME, *turned)
    on_cells = len(tables.cells.flexible) > 0
    names = [*(f"shoe {number}" for number in case.track.shoes), *others]
    return state.StateLayout(
        shoes=case.track.shoe_count,
        terrain=tables.terrain.heave.shape[1],
        flexible_shoes=() if case.flexible is None else tuple(case.flexible.shoes),
        modes=len(tables.modes.stiffness),
        contact=(pairs.RESULTS if on_cells else 0) + (tables.cells.nodes.size if case.flexible else 0),
        multipliers=(
            *(
                (
                    state.pin_name(side, link) if link > 0 else state.BEARING.format(turned[-link - 1]),
                    joints.ROWS,
                )
                for link, side in pins
            ),
            ("drive", 1),
            ("turn", 1),
            *(
                (f"hold of {names[b]} ({state.BODY_COORDINATES[k]})", 1)
                for b, k in tables.joints.holds.tolist()
            ),
            *((state.MOTOR.format(one), 1) for one in turned),
        ),
        bodies=others,
    )


class CompiledSystem(track_system.TrackSystem):
    """Multibody system of a case by compiled equations of its `tables`; `mbs` has the coordinates alone."""

    contact: PairGroundContact | CellGroundContact

    def __init__(self, case: Case, parts: build.Parts) -> None:
        contact = parts.contact
        reduced = isinstance(contact.coordinates, terrain.TerrainModes)
        if not (reduced and isinstance(contact, PairGroundContact | CellGroundContact)):
            raise ValueError(
                "the case needs contact.model 'pair' or 'cells' and terrain_formulation 'reduced'"
            )
        super().__init__(case, parts)
        self.tables = parts.tables
        self.layout = layout_of(case, self.tables, parts.pins)
        size, multipliers = self.layout.coordinate_count, self.tables.multiplier_count
        add_coordinates(self.mbs, "track", size)
        self.mbs.Assemble()
        self._driven = True
        self._state = np.zeros((3, size))
        self._multipliers = np.zeros(multipliers)
        self._scratch = (np.zeros(size + multipliers), np.zeros(self.tables.fronts.size))
        if isinstance(contact, CellGroundContact):
            self._work = Workspace.allocate(self.tables, 0, contact.ground.shoes)
            on = OnCells(self.tables.bodies, self.tables.cells, self._work.cells)
            self._cells = TrackOnCells(contact.ground, on)
        else:
            self._work = Workspace.allocate(self.tables, contact.greatest_count, packed.nothing(ShoePoints))
        self._block = packed.pack(System(self.tables, self._work), SYSTEM)
        machine = [StepProfile.constant(0.0)] * 6 if case.machine is None else case.machine.components
        turn = case.drive.turn_rate or StepProfile.constant(0.0)
        applied = [*case.loads.of_shoes, case.drive.speed, turn, case.loads.side_shift, *machine]
        self._applied = plain(profiles_of(applied))
        self._resistances = np.zeros(1) if case.running_gear is None else case.running_gear.resistances
        self._middles = case.track_middles
        self._gravity, self._down = tuple(case.gravity_vector().tolist()), case.terrain.down
        self._limits = (0.0, 0)
        self._singular = False
        # weights of the factored matrix with which the next step begins; None where that makes its own
        self._factored: Weights | None = None
        # speed (m/s) with rate of turning (rad/s), and wrench on the side frame (6,) in place of the case's
        self.commands: Callable[[float], tuple[np.ndarray, np.ndarray]] | None = None
        if self._cells is not None:
            self._put_down(self._cells)

    def gear_forces(self, times: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> gear.GearForces:
        """As of `TrackSystem`."""
        n = self.layout.shoes
        some = np.flatnonzero(self.tables.bodies.modal[:n] >= 0) if self.case.is_closed else np.arange(n)
        found = gear.GearForces.allocate(len(times), n, len(some), self._work)
        speeds = np.array([self._applied_at(time)[1] for time in times])
        drags = self._drags(self._speeds_of_tracks(speeds))
        at = np.ascontiguousarray(q), np.ascontiguousarray(q_t)
        gear.write_gear_forces(self._block, *at, drags, some, tuple(found))
        return found

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free; a side frame is always moved."""
        self._driven = on or self.case.running_gear is not None

    def set_initial(self, q: np.ndarray) -> None:
        """Start from rest at the coordinates `q`; a side frame has its speed."""
        self._state[0], self._state[1:] = self.settled(q), 0.0
        if self.case.undercarriage is not None:
            first = self.tables.bodies.coordinate[self.tables.pull.frame]
            self._state[1, first] = self.case.drive.speed.value(0.0)
        self._multipliers[:] = 0.0
        self._hand_over(exu.ConfigurationType.Initial)

    def settled(self, q: np.ndarray) -> np.ndarray:
        """Rest near to one `q` on fresh ground, after cells have remembered that shoes were put down there.

        Cells that two shoes share remember the deeper one; other ground leaves `q` as it is.
        """
        cells = self._cells
        if cells is None:
            return q
        self._put_down(cells)
        self._state[0] = q
        cells.cover(self._state)
        self.residual(self._state, self.inputs(0.0))
        cells.commit()
        # what holds the front shoe without a drive is the ground alone
        self.switch_drive(self.case.drive.drives_after(0.0))
        tilts = self.case.running_gear is None and not self.case.terrain.is_even
        return self.creep(q, UNEVEN_SETTLING if tilts else SETTLING, SETTLING_LIMITS, cells.commit)

    def creep(
        self,
        q: np.ndarray,
        duration: float,
        limits: tuple[float, int],
        accepted: Callable[[], None] = lambda: None,
    ) -> np.ndarray:
        """Coordinates to which all bodies creep from `q` in a time (s), without inertia, under first loads.

        A force in proportion to the momentum slows them; the time counts from where that drag is least.
        `limits` are the residual (N, root mean square) that ends a step's search, and most iterations;
        `accepted` is called after every step. A `NewtonError` if steps become too short.
        """
        closed = self.case.is_closed
        least = CLOSED_DRAG if closed else DRAG
        drag, h = (FIRST_DRAG, SLOWED_STEP) if closed else (DRAG, FIRST_STEP)
        time, multipliers, inputs = 0.0, np.zeros_like(self._multipliers), self.inputs(0.0)
        inputs = inputs._replace(speeds=np.zeros(2), motors=np.zeros_like(inputs.motors))
        while time < duration:
            self._state[0], self._state[1:], self._multipliers[:] = q, 0.0, multipliers
            if self._cells is not None:
                self._cells.cover(self._state)
            weights = Weights(1.0, 1.0 / h, drag / h, False, h)
            converged, iterations = self._step(inputs, weights, (*limits, False))
            if converged and np.isfinite(self._state).all():
                accepted()
                q, multipliers = self._state[0].copy(), self._multipliers.copy()
                if drag > least:
                    drag = max(least, 0.5 * drag) if iterations < SOME else drag
                else:
                    time += h
                    h = min(1.5 * h, LONGEST_STEP) if iterations < FEW else h
            elif least < drag < MOST_DRAG:
                drag *= 4.0
            else:
                h *= 0.25
                if h < LEAST_STEP:
                    raise self.failure()
        return q

    def _put_down(self, cells: TrackOnCells) -> None:
        """Let slip count from where shoes are put down before they go to their rest."""
        self._state[0], self._state[1:] = self.first_guess(), 0.0
        cells.put_down(self._state)

    def _start(self, state: np.ndarray, multipliers: np.ndarray) -> None:
        self._state[:], self._multipliers[:] = state, multipliers
        if self._cells is not None:
            self._cells.put_down(self._state)
        self._hand_over(exu.ConfigurationType.Initial)

    def coordinates(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As of `TrackSystem`."""
        data: Any = self.mbs.systemData
        return data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()

    @property
    def multipliers(self) -> np.ndarray:
        """As of `TrackSystem`."""
        return self._multipliers

    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings; errors as of `TrackSystem.solve`."""
        # a run that goes on from here later has no matrix, either
        self._factored = None
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

    def failure(self) -> track_system.NewtonError:
        """Error of the last step that was tried."""
        return track_system.NewtonError(self.in_units(self._scratch[0]), self._singular)

    @property
    def pin_rows(self) -> int:
        """Number of the pins' equations."""
        return joints.ROWS * len(self.tables.joints.pins)

    def residual(
        self,
        state: np.ndarray,
        inputs: Inputs,
        multipliers: np.ndarray | None = None,
        weights: Weights = NO_DERIVATIVES,
    ) -> np.ndarray:
        """Residual of all equations at coordinates, rates and accelerations (3, coordinates)."""
        out = np.empty_like(self._scratch[0])
        applied = np.zeros_like(self._multipliers) if multipliers is None else multipliers
        residual(self._block, state, applied, tuple(inputs), tuple(weights), out)
        return out

    def pulled_place(self, q: np.ndarray) -> float:
        """Displacement along x of the point that the drive moves, m, with that of its place in the shoe."""
        front = q[6 * self.layout.shoes - 6 : 6 * self.layout.shoes]
        modal = q[len(q) - self.point.rows.shape[1] :]
        return float(front[0] + self.point.arm(front[3:], modal)[0])

    def at_rest(self, q: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residual at rest at t = 0 without the drive, and the drive's direction, as generalized force.

        Of coordinates and the pins' multipliers (pin_rows,), N and N m. Gives arrays (coordinates +
        pin_rows,), as of `equations.residual`, and (coordinates,).
        """
        state = np.zeros_like(self._state)
        state[0] = q
        if self._cells is not None:
            self._cells.cover(state)
        both = np.concatenate((multipliers, np.zeros(2)))
        out = self.residual(state, self.inputs(0.0)._replace(active=np.zeros(2)), both)
        if self._down[2] > -1.0 and not self.sticks:
            shoes = out[: 6 * self.layout.shoes].reshape(-1, 6)
            angles = q[: shoes.size].reshape(-1, 6)[:, 3:]
            force, moment = static_friction(self.case, self.tables.bodies.mass[: len(shoes)])
            shoes[:, :3] -= force
            shoes[:, 3:] -= moments_on_angles(angles, moment)
        along = self._work.jacobian[self.pin_rows, 0]
        direction = np.zeros(len(q))
        direction[6 * self.layout.shoes - 6 : 6 * self.layout.shoes] = along[:6]
        if self.point.rows.shape[1]:
            direction[-self.point.rows.shape[1] :] = along[6:]
        return out[:-2], direction

    def calls(self) -> dict[str, list[tuple[Any, tuple]]]:
        """Compiled functions with arguments as a run calls them, by what they make."""
        out, values = self._scratch
        inputs, weights = tuple(self.inputs(0.0)), (0.0, 0.0, 1.0, False, 1.0)
        fronts = self.tables.fronts
        both, none = (self._block, self._state), (np.zeros((1, 0)), np.zeros(0, dtype=np.int64))
        found = tuple(gear.GearForces.allocate(1, self.layout.shoes, 0, self._work))
        return {
            "residual": [
                (residual, (*both, self._multipliers, inputs, weights, out)),
                (gear.write_gear_forces, (self._block, *self._state[:2, None], *none, found)),
            ],
            "matrix": [
                (matrix, (*both, inputs, weights, values)),
                (elimination.eliminate, (fronts, values)),
                (elimination.solve, (fronts, values, out)),
            ],
        }

    def in_units(self, out: np.ndarray) -> np.ndarray:
        """Residual with gaps in m and rad, of as many equations as it has, the others zero."""
        equations = np.zeros(self.layout.equation_count)
        equations[: len(out)] = out
        equations[self.layout.coordinate_count :] /= STIFFNESS
        return equations

    def _step(self, inputs: Inputs, weights: Weights, limits: tuple[float, int, bool]) -> tuple[bool, int]:
        """Whether Newton's method finds the step that the state predicts, and its iterations."""
        try:
            converged, iterations, *_ = newton.step(
                self._block,
                self._state,
                self._multipliers,
                tuple(inputs),
                tuple(weights),
                limits,
                self._scratch,
            )
            self._singular = False
        except np.linalg.LinAlgError:
            converged, iterations, self._singular = False, 0, True
        return converged, iterations

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
        kept = self._factored == weights
        if kept or self._cells is not None:
            # which cells load and which unload is seen best with the accelerations as they were; an old
            # matrix then has the less to do
            last: Any = self.mbs.systemData.GetODE2Coordinates_tt(exu.ConfigurationType.StartOfStep)
            self._state += np.multiply.outer(weights[:3], last / weights.acceleration)
        if self._cells is not None:
            self._cells.cover(self._state)
        limits = (*self._limits, kept)
        converged, iterations = self._step(self.inputs(solver.it.currentTime), weights, limits)
        keeps = self.case.is_closed or (self.case.is_rolled and self._cells is not None)
        self._factored = weights if keeps and converged and iterations == 1 else None
        if not converged:
            self._multipliers[:] = start
            return False
        if self._cells is not None:
            self._cells.commit()
        self._hand_over(exu.ConfigurationType.Current)
        return True

    def inputs(self, time: float) -> Inputs:
        """Loads and drive at a time, s."""
        n, (shoes, speeds, machine) = self.layout.shoes, self._applied_at(time)
        of_tracks = self._speeds_of_tracks(speeds)
        loads = np.zeros((len(self.tables.loads.marker), 6))
        loads[:n, :3] = np.outer(shoes, self._down)
        frame, drag, motors = self.case.undercarriage, np.zeros(1), np.zeros(0)
        if self.case.running_gear is not None:
            loads[n], drag = machine, self._drags(of_tracks)
        if frame is not None:
            loads[n + 1 :, 0] = -frame.end_tension, frame.end_tension
        turning = self._driven and self.case.drive.turn_rate is not None
        active = np.array([self._driven, turning], dtype=float)
        if self.case.closed_track is not None:
            active[:] = 0.0
            motors = np.zeros(len(self.tables.closed.motors))  # what keeps sliding idlers from spinning last
            motors[: len(of_tracks)] = of_tracks / self.case.closed_track.travel_per_angle(self.case.track)
        return Inputs(self._gravity, loads, float(speeds[2]), active, speeds[:2], drag, motors)

    def _applied_at(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Loads of the shoes, speed with rate of turning and side shift, wrench on the frame, at a time."""
        n, values = self.layout.shoes, np.zeros(self.layout.shoes + 9)
        values_at(self._applied, time, values)
        shoes, speeds, machine = values[:n], values[n : n + 3], values[n + 3 :]
        if self.commands is not None:
            speeds[:2], machine = self.commands(time)
        return shoes, speeds, machine

    def _speeds_of_tracks(self, speeds: np.ndarray) -> np.ndarray:
        """Speeds of the tracks (..., tracks), m/s: a turn makes the right one faster than the left one."""
        return speeds[..., :1] - speeds[..., 1:2] * self._middles

    def _drags(self, of_tracks: np.ndarray) -> np.ndarray:
        """Rolling resistance over normal force of all wheels (..., wheels), with the sign of the travel."""
        running_gear = self.case.running_gear
        assert running_gear is not None
        faded = np.hypot(of_tracks, running_gear.resistance_speed)
        drags = of_tracks[..., None] * self._resistances / faded[..., None]
        return drags.reshape(*of_tracks.shape[:-1], -1)

    def _accelerate(self, time: float) -> None:
        """Accelerations and multipliers of a track that starts."""
        self._state[2], self._multipliers[:] = 0.0, 0.0
        if self._cells is not None:
            self._cells.cover(self._state)
        inputs, weights, values = self.inputs(time), Weights(0.0, 0.0, 1.0, False, 1.0), self._scratch[1]
        out = self.residual(self._state, inputs, self._multipliers, weights)
        matrix(self._block, self._state, tuple(inputs), tuple(weights), values)
        fronts = self.tables.fronts
        elimination.eliminate(fronts, values)
        # at rest constraints have no gap, and their rates do not change by themselves
        n = self._state.shape[1]
        out[n:] = 0.0
        elimination.solve(fronts, values, out)
        self._state[2] = -out[:n]
        self._multipliers[:] = -out[n:]
        self._hand_over(exu.ConfigurationType.Initial)

    def _hand_over(self, to: "exu.ConfigurationType") -> None:
        data: Any = self.mbs.systemData
        places = data.GetODE2Coordinates, data.GetODE2Coordinates_t, data.GetODE2Coordinates_tt
        for place, row in zip(places, self._state, strict=True):
            # into Exudyn's own memory: what sets coordinates takes them number by number
            place(to, copy=False)[:] = row


def compiled_system(case: Case) -> CompiledSystem:
    """Build the compiled equations of a case."""
    return CompiledSystem(case, build.parts_of(case))
