"""Integration of a user's model with its tracks by Exudyn's generalized-alpha method."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from threadpoolctl import threadpool_limits

from exudyn_crawler.case import Case
from exudyn_crawler.coupled.step import CoupledStep
from exudyn_crawler.coupled.tracks import tracks_of
from exudyn_crawler.coupled.user_model import UserModel
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.model.exudyn import exu, integrator
from exudyn_crawler.run.solve import simulation
from exudyn_crawler.run.solve.stages import SAME
from fem.interrupts import interrupts_wait


def dynamic_settings(case: Case, end_time: float, start_time: float = 0.0) -> "exu.SimulationSettings":
    """Return Exudyn's settings of a case's solver between two times (s), for `solve_dynamic`.

    Sensors write at the case's output interval; no solution file is written.
    """
    settings = simulation.solver_settings(case.solver)
    simulation.set_times(settings, case.solver, start_time, end_time)
    settings.timeIntegration.numberOfSteps = math.ceil((end_time - start_time) / case.solver.step - SAME)
    settings.solution.sensors.active = True
    settings.solution.sensors.writePeriod = case.solver.output_interval
    return settings


@threadpool_limits.wrap(limits=1, user_api="blas")
def solve_dynamic(mbs: "exu.MainSystem", settings: "exu.SimulationSettings") -> None:
    """Integrate a user's model with its tracks; it takes the place of ``mbs.SolveDynamic(settings)``.

    The first call starts from the rest of the tracks, with the accelerations that the whole model has there,
    each later one from the end of the one before. The cases of the tracks give the residual that is allowed
    for them; the user's constraints, and those between both, are closed within 1e-10 m and rad. Exudyn's user
    function before a step is called once for each step, also for one that fails and is tried with half its
    size.

    Parameters
    ----------
    mbs : exudyn.MainSystem
        The user's model with tracks (`add_track`), assembled.
    settings : exudyn.SimulationSettings
        Times, step, method and output, as for `SolveDynamic`; `dynamic_settings` returns those of a case.

    Raises
    ------
    ValueError
        If the model has no track, or one that cannot be solved with tracks.
    SimulationStopped
        If a step fails at its least size.
    """
    tracks = tracks_of(mbs)
    _check(mbs, settings, len(tracks))
    blocks = [track.block for track in tracks]
    model = UserModel(mbs, [track.car for track in tracks])
    step = CoupledStep(model, blocks)
    solver = integrator(mbs)
    solver.SetUserFunctionNewton(mbs, step.newton)
    time = settings.timeIntegration
    acceleration = time.generalizedAlpha
    wanted = acceleration.computeInitialAccelerations, acceleration.resetAccelerations
    if acceleration.computeInitialAccelerations and not all(block.has_moved for block in blocks):
        with _silent(settings):
            step.accelerate(time.startTime, settings)
    acceleration.computeInitialAccelerations = acceleration.resetAccelerations = False
    try:
        # Exudyn would treat an interrupt within its calls as an error of its own
        with interrupts_wait() as waiting, _user_functions(mbs, step, waiting):
            done = solver.SolveSystem(mbs, settings)
    finally:
        acceleration.computeInitialAccelerations, acceleration.resetAccelerations = wanted
    model.keep()
    for block in blocks:
        block.restart()
    if not done:
        now = mbs.systemData.GetTime()
        raise SimulationStopped(now, f"a step failed at its least size: {step.fault()}", None)


def _check(mbs: "exu.MainSystem", settings: "exu.SimulationSettings", tracks: int) -> None:
    """Raise ValueError for a model or settings that cannot be solved with tracks."""
    if not tracks:
        raise ValueError("mbs must have a track: call add_track before mbs.Assemble()")
    if settings.timeIntegration.generalizedAlpha.useIndex2Constraints:
        raise ValueError("timeIntegration.generalizedAlpha.useIndex2Constraints must be False with tracks")


@contextmanager
def _silent(settings: "exu.SimulationSettings") -> Iterator[None]:
    """Write no solution and no sensors."""
    outputs = settings.solution.file, settings.solution.sensors
    wanted = outputs[0].write, outputs[1].active
    outputs[0].write = outputs[1].active = False
    try:
        yield
    finally:
        outputs[0].write, outputs[1].active = wanted


@contextmanager
def _user_functions(mbs: "exu.MainSystem", step: CoupledStep, waiting: Sequence[int]) -> Iterator[None]:
    """Call the user's function before a step once only, and accept a step before the function after it.

    Exudyn would call the first one again for a step that failed and is tried with half its size. A waiting
    interrupt ends the run after a step.
    """
    before: Any = mbs.GetPreStepUserFunction()
    after: Any = mbs.GetPostStepUserFunction()
    called: list[float] = []

    def once(mbs: "exu.MainSystem", time: float) -> bool:
        start = mbs.systemData.GetTime(exu.ConfigurationType.StartOfStep)
        if start in called:
            return True
        called[:] = [start]
        return bool(before["function"](mbs, time))

    def accepted(mbs: "exu.MainSystem", time: float) -> bool:
        step.accept()
        for track in tracks_of(mbs):
            track.store_frame(time)
        goes_on = bool(after["function"](mbs, time)) if after else True
        return goes_on and not waiting

    if before:
        mbs.SetPreStepUserFunction(once)
    mbs.SetPostStepUserFunction(accepted)
    try:
        yield
    finally:
        if before:
            mbs.SetPreStepUserFunction(before["function"])
        # Exudyn's stub does not know that zero is none
        no_function: Any = 0
        mbs.SetPostStepUserFunction(after["function"] if after else no_function)
