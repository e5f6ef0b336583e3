"""Run of a case from its static equilibrium: time integration by stages, and causes of an early end."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from threadpoolctl import threadpool_limits

from exudyn_crawler.case import Case, RunningGear, Solver
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.checks import warn_implausible
from exudyn_crawler.case.parameters.contact import SphereContact
from exudyn_crawler.engine import formulation
from exudyn_crawler.errors import INTERRUPTED, SimulationStopped
from exudyn_crawler.ground import rotations, sphere_contact
from exudyn_crawler.machines import case_file
from exudyn_crawler.model import compiling, flexible_shoes, state
from exudyn_crawler.model.diagnostics import NewtonError
from exudyn_crawler.model.exudyn import exu, newton_settings
from exudyn_crawler.model.track_system import TrackSystem
from exudyn_crawler.results.history.history import History
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.folder.progress import COMPILE, COMPILING, REDUCE, heartbeat, progress_bar
from exudyn_crawler.run.solve import stages
from exudyn_crawler.run.solve.start import begin, warn_unbalanced
from exudyn_crawler.run.solve.tension import tensioned
from fem import interrupts


def solver_settings(solver: Solver) -> "exu.SimulationSettings":
    """Return Exudyn's settings for a run, without times; see `set_times`."""
    settings = newton_settings(solver.residual, solver.maximum_iterations)
    settings.solution.sensors.active = False
    time = settings.timeIntegration
    # a stage starts from the accelerations at the end of the stage before
    time.generalizedAlpha.resetAccelerations = False
    time.adaptiveStepRecoverySteps = 1
    time.adaptiveStepRecoveryIterations = solver.maximum_iterations
    time.generalizedAlpha.spectralRadius = solver.spectral_radius
    # Exudyn's numerical Jacobian costs far more than an iteration: a new one only if iterations slow down
    time.newton.useModifiedNewton = True
    time.newton.modifiedNewtonJacUpdatePerStep = False
    return settings


def set_times(
    settings: "exu.SimulationSettings", solver: Solver, start: float, end: float, quiet: bool = False
) -> Callable[[float], float]:
    """Set the times of a stage in Exudyn's settings, and return `stages.step_ends`.

    A quiet stage has longer steps. The steps of the settings are slightly too long if a stage is not a
    multiple of them. The ends of steps then shorten them.
    """
    time = settings.timeIntegration
    step = max(solver.step, solver.quiet_step) if quiet else solver.step
    time.startTime = start
    time.endTime = end
    time.numberOfSteps = max(1, math.floor((end - start) / step + stages.SAME))
    time.minimumStepSize = min(solver.minimum_step, end - start)
    return stages.step_ends(start, end, step, solver.output_interval)


def integrate(
    system: TrackSystem,
    duration: float,
    progress: bool | None = None,
    checkpoints: Checkpoints | None = None,
    ground_times: Sequence[float] = (),
) -> History:
    """Integrate a built system from its initial state; see `simulate`."""
    case = system.case
    settings = solver_settings(system.case.solver)
    recorder = stages.Recorder(system, duration, ground_times, checkpoints)
    reason = ""
    with progress_bar(case.name, duration, progress) as tell, _watched(system, recorder, tell) as watch:
        for number, (start, end) in enumerate(pairwise(recorder.ends)):
            if number < recorder.first:
                continue
            system.switch_drive(case.drive.drives_after(start))
            next_end = set_times(settings, case.solver, start, end, stages.is_quiet(case, start))
            settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = number == 0
            reason = _solve(system, settings, next_end, watch)
            if number == 0 and not recorder.nothing:
                # not within the engine's steps, which pass on no errors but their own
                warn_unbalanced(system, recorder.first_state)
            if reason or watch.waiting:
                break
            recorder.end_stage(number)
    if watch.waiting:
        reason = INTERRUPTED
    if reason:
        raise SimulationStopped(recorder.time, reason, None if recorder.nothing else recorder.history())
    return recorder.history()


LOOK = 0.02
"""Time between two checks of a closed chain, s: a lug of the M113's pitch takes five times as long over a
tooth at 1.5 m/s."""


class ChainWatch:
    """Monitor of the chains of closed tracks, by rows of states; it names faults in words."""

    def __init__(self, case: Case, layout: state.StateLayout) -> None:
        self.case, self.layout, self.closed = case, layout, case.part(Closed)
        profile = self.closed.tumbler.profile(case.track)
        self._teeth = profile.gaps
        self._addendum = profile.addendum
        _, self._lug = self.closed.lugs(case.track)[0]
        self._gaps = np.full(case.track.shoe_count, -1)
        self._ahead = case.gear.links(case.track)[:, 1] - 1
        self._shoes = case.gear.shoe_reference(case)
        self._frame = case.part(RunningGear).frame_start(case)
        self._tumblers = case.part(Closed).tumbler_reference(case)
        self._middles = np.repeat(case.gear.middles, case.gear.loop(case.track).shoe_count)
        pins = [name for name, _ in layout.multipliers if " pin of link " in name]
        self._links = np.array([int(name.rpartition(" ")[2]) - 1 for name in pins])
        # multipliers of every pin: along the ground, and normal to that and to the pin
        self._reactions = np.array([layout.first_multiplier(name) for name in pins])[:, None] + [0, 2]
        self.next_look = 0.0

    def fault(self, row: np.ndarray) -> str:
        """Return the shoe at fault and the likely cause; empty without a fault."""
        self.next_look = float(self.layout.part(row, "time")) + LOOK
        shoes = self.layout.part(row, "shoes") + self._shoes
        tension = self._tension(row)
        cause = self._broken(tension) or self._off(row, shoes) or self._folded(shoes)
        return cause or self._jumped(row, shoes, tension)

    def _tension(self, row: np.ndarray) -> np.ndarray:
        """Return the force of every link in the chain's plane, N."""
        forces = np.zeros((self.case.track.shoe_count, 2))
        np.add.at(forces, self._links, self.layout.part(row, "multipliers")[self._reactions])
        return np.hypot(*forces.T)

    def _broken(self, tension: np.ndarray) -> str:
        limit = self.closed.tension_limit
        link = int(tension.argmax())
        if limit is None or tension[link] <= limit:
            return ""
        return (
            f"link {link + 1}-{self._ahead[link] + 1} broke: its tension of {tension[link]:.4g} N is beyond "
            f"gear.tension_limit = {limit:.4g} N; likely a chain too taut for its wheels "
            "(idler.slack, idler.take_up), or a load that is too great"
        )

    def _off(self, row: np.ndarray, shoes: np.ndarray) -> str:
        frame = self.layout.part(row, SIDE_FRAME)
        limit = self.closed.offset_limit
        turn = rotations.rotation_matrices(frame[3:])
        aside = (shoes[:, :3] - frame[:3] - self._frame) @ turn[:, 1] - self._middles
        step = np.abs(aside - aside[self._ahead])
        shoe = int(np.maximum(np.abs(aside), step).argmax())
        if max(abs(aside[shoe]), step[shoe]) <= limit:
            return ""
        return (
            f"shoe {shoe + 1} came off sideways: it is {aside[shoe]:+.4f} m from the track's middle and "
            f"{step[shoe]:.4f} m from shoe {self._ahead[shoe] + 1}, beyond gear.offset_limit = "
            f"{limit:.4g} m; likely a side force that the flanges do not hold (guide_height, "
            "guide_stiffness), or a chain too slack to stay between them"
        )

    def _folded(self, shoes: np.ndarray) -> str:
        bend = shoes[:, 4] - shoes[self._ahead, 4]
        limit = self.closed.fold_limit
        bend[self._ahead < np.arange(len(bend))] += 2.0 * math.pi
        link = int(np.abs(bend).argmax())
        if abs(bend[link]) <= limit:
            return ""
        return (
            f"the chain folded: shoes {link + 1} and {self._ahead[link] + 1} are at {bend[link]:+.3f} rad, "
            f"beyond gear.fold_limit = {limit:.4g} rad; likely a chain too slack (idler.slack, "
            "idler.take_up), or one that piles up where it is pushed"
        )

    def _jumped(self, row: np.ndarray, shoes: np.ndarray, tension: np.ndarray) -> str:
        """Return the fault of a lug in another gap than before or by its neighbours, or in none."""
        tumblers = np.array([self.layout.part(row, name) for name in self.case.gear.tumblers])
        tumblers = np.repeat(tumblers + self._tumblers, len(self._middles) // len(tumblers), axis=0)
        lugs = shoes[:, :3] + rotations.rotation_matrices(shoes[:, 3:]) @ self._lug - tumblers[:, :3]
        x, _, z = np.einsum("sji,sj->is", rotations.rotation_matrices(tumblers[:, 3:]), lugs)
        radius = np.hypot(x, z)
        angle = np.arctan2(z, x)
        inside = radius < self._addendum
        gaps = np.where(inside, np.rint(angle * self._teeth / (2.0 * np.pi)) % self._teeth, -1.0).astype(int)
        after = gaps[self._ahead]
        other = inside & (self._gaps >= 0) & (gaps != self._gaps)
        other |= (
            inside & (after >= 0) & ((after - gaps) % int(self._teeth) != self.closed.tumbler.gaps_per_shoe)
        )
        self._gaps = gaps
        on = inside.reshape(self.case.gear.tracks, -1).any(axis=1)
        if on.all() and not other.any():
            return ""
        # the shoe nearest to the tumbler, for a track without shoes on its tumbler
        off = np.where(np.repeat(on, len(x) // len(on)), np.inf, radius).argmin()
        shoe = 1 + int(other.argmax() if other.any() else off)
        return (
            f"shoe {shoe} jumped a tooth of the tumbler, at tensions of {tension.min():.3g} to "
            f"{tension.max():.3g} N; likely a chain too slack to stay on it (idler.slack, idler.take_up), "
            "worn, or pulled harder than such teeth hold (tumbler.reach, tumbler.depth)"
        )


@dataclass
class _Watch:
    """Causes of an early end of a run: interrupting signals, and faults of its shoes in words."""

    waiting: list[int]
    chain: ChainWatch | None
    fault: str = ""


@contextmanager
def _watched(
    system: TrackSystem, recorder: stages.Recorder, tell: Callable[[float], None]
) -> Iterator[_Watch]:
    """Store the states after each step within the block, and end the run after a step with a cause.

    An interrupt waits for the end of its step: Exudyn does not pass on all interrupts within its own calls.
    """
    case = system.case
    watch = _Watch([], ChainWatch(case, system.layout) if case.gear.loops else None)

    def after_step(time: float) -> bool:
        recorder.store(time)
        tell(time)
        if watch.chain is not None:
            if time >= watch.chain.next_look:
                watch.fault = watch.chain.fault(system.state())
        elif isinstance(system.contact, sphere_contact.SphereGroundContact) and (
            sunken := system.contact.sunken(system.layout.part(system.state(), "coordinates"))
        ):
            watch.fault = (
                f"spheres of shoes {sunken} sank through the ground; they need a "
                f"contact.radius greater than {case.part(SphereContact).radius} m, or flatter ground"
            )
        return not (watch.fault or watch.waiting)

    system.after_step(after_step)
    try:
        with interrupts.interrupts_wait() as watch.waiting:
            yield watch
    except KeyboardInterrupt:
        if not watch.waiting:
            raise
    finally:
        system.after_step(None)


def _solve(
    system: TrackSystem,
    settings: "exu.SimulationSettings",
    next_end: Callable[[float], float],
    watch: _Watch,
) -> str:
    """Integrate one stage; return the reason of an early stop, else empty."""
    reason = ""
    try:
        system.solve(settings, next_end)
    except NewtonError as failed:
        least = system.case.solver.minimum_step
        fault = failed.fault(system.layout)
        reason = failed.cause or f"Newton's method failed at the least step {least:g} s; {fault}"
        if watch.chain is not None and (wrong := watch.chain.fault(system.state())):
            reason = f"{wrong}; {reason}"
    return watch.fault or reason


def compiled(case: Case, progress: bool | None = None) -> None:
    """Compile the equations, at the first start on a computer."""
    if case.is_compiled:
        shown = heartbeat(f"{case.name}: {COMPILE}", COMPILING, progress)
        with shown, threadpool_limits(1, user_api="blas"):
            compiling.compile_equations()


def solved_for_tension(case: Case, progress: bool | None = None) -> Case:
    """Return the case with the take-up for its chains' tension at rest; unchanged if the case gives it."""
    if not case.gear.is_set_by_tension:
        return case
    compiled(case, progress)
    with threadpool_limits(1, user_api="blas"):
        return tensioned(case)


def started(case: Case, progress: bool | None = None) -> TrackSystem:
    """Return the system of a case at the start of any run, whole or by steps.

    Its idlers are at the take-up for the chains' tension at rest, and its flexible shoe is reduced. It is at
    rest under the loads at t = 0. EquilibriumError if there is no such rest.
    """
    case = solved_for_tension(case, progress)
    if case.flexible is not None:
        with heartbeat(f"{case.name}: {REDUCE}", show=progress):
            flexible_shoes.whole_reduction(case)  # large enough for several threads, unlike later work
    compiled(case, progress)
    with threadpool_limits(1, user_api="blas"):
        system = formulation.track_system(case)
        begin(system)
    return system


def simulate(
    case: Case,
    duration: float,
    progress: bool | None = None,
    checkpoints: Checkpoints | None = None,
    ground_times: Sequence[float] = (),
) -> History:
    """Run a case from static equilibrium for a duration (s), or from the last of the checkpoints.

    A run consists of stages (`stage_times`). Each stage starts from the end of the one before, in the same
    process or, after a kill, in a later one. Both give the same numbers. The history's case has the take-up
    for its chains' tension at rest.

    `progress` shows a bar. None shows one on a terminal and a line every 10 s elsewhere. `checkpoints` store
    every stage but the last; the run continues after the stored ones. At the rising `ground_times` (s), and
    at the end, the history has the memory of a ground of cells.

    Before the run an `ImplausibleWarning` tells values outside of those of known machines and grounds.
    TypeError if `case` is not a case. ValueError if `duration` is not positive and finite, or the run would
    take too much memory. ValueError also if the drive takes the track off the terrain, or checkpoints have
    other parameters.

    EquilibriumError if the track finds no rest before t = 0. SimulationStopped, with the history so far, on
    interrupts, or if a step fails at its least size. SimulationStopped also if spheres of the second contact
    model sink through the ground, or a closed chain breaks, folds, comes off or jumps a tooth.
    """
    case_file.check_run(case, duration)
    warn_implausible(case, duration)
    case = solved_for_tension(case, progress)
    if checkpoints is not None:
        checkpoints.load(case)
    system = started(case, progress)
    # matrices of a step are so small that threads wait for each other, and rounding depends on their number
    with threadpool_limits(1, user_api="blas"):
        return integrate(system, duration, progress, checkpoints, ground_times)
