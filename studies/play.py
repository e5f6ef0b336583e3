"""Play of pins in their bores: side forces and moments of links with their range, and what it costs.

The same motions with ideal joints, with softer ones, and with play: straight travel, a turn on the spot, and
straight travel of an excavator on sand.
"""

import time as clock
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from exudyn_crawler import Case, History, StepProfile, read_case
from exudyn_crawler.case import Drive
from exudyn_crawler.files import writable_folder
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.assemble import assemble
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.newton import Limits
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.run.solve.simulation import integrate
from exudyn_crawler.run.solve.start import begin
from exudyn_crawler.run.solve.tension import take_up_of, tensioned
from studies.running import save

ROUNDS = 3
"""Number of times that all runs take turns; the least processor time of each counts."""
AFTER = 0.3
"""Time from which forces count, s: speeds are constant."""
IDEAL = "ideal"
STIFFNESS, DAMPING = 5e9, 1e6
"""N/m and N s/m of a pin in its bore (assumed)."""


class Motion(NamedTuple):
    """Motion of a machine."""

    make: Callable[[], Case]
    duration: float  # s
    joints: tuple[str, ...]


def _straight() -> Case:
    """Return half of a shovel that reaches 0.3 m/s in 0.3 s."""
    return Case.closed().with_(drive=Drive(speed=StepProfile(times=(0.0, AFTER), values=(0.0, 0.3))))


def _turn() -> Case:
    """Return a shovel that turns on the spot and reaches 0.03 rad/s in 0.3 s."""
    still, turn = (StepProfile(times=(0.0, AFTER), values=(0.0, end)) for end in (0.0, 0.03))
    return Case.shovel().with_(drive=Drive(speed=still, turn_rate=turn))


def _excavator() -> Case:
    """Return a PC300LC of the library with ideal pins on sand, which reaches 0.6 m/s in 0.3 s."""
    library = files("exudyn_crawler.machines.datasheet") / "library"
    case = read_case(str(library / "pc300lc.toml"), ['track.pin.kind="ideal"']).case
    return case.with_({"drive.speed.times": (0.0, AFTER), "drive.speed.values": (0.0, 0.6)})


def _ideal(case: Case) -> Case:
    """Return a case with ideal joints as it is."""
    return case


def _softer(case: Case) -> Case:
    """Return a case with ten times the compliance of its joints."""
    return case.with_({"gear.compliance": 10.0 * case.gear.pin_compliance})


def _play(width: float, stiffness: float = STIFFNESS) -> Callable[[Case], Case]:
    """Return what gives a case the same play along and across its pins, m."""
    values = {"radial": width, "axial": width, "stiffness": stiffness, "damping": DAMPING}
    return lambda case: case.with_({"gear.play": values})


JOINTS: dict[str, Callable[[Case], Case]] = {
    IDEAL: _ideal,
    "ten times the compliance": _softer,
    "play 0 mm": _play(0.0),
    "play 1 mm": _play(1e-3),
    "play 3 mm": _play(3e-3),
    "play 1 mm, soft": _play(1e-3, 0.1 * STIFFNESS),
}


MOTIONS = {
    "straight": Motion(_straight, 2.0, tuple(JOINTS)),
    "turn": Motion(_turn, 1.0, tuple(JOINTS)),
    # in soft bores its chain gets too long for the sag of its maker
    "excavator": Motion(_excavator, 2.0, (IDEAL, "play 0 mm", "play 1 mm", "play 3 mm")),
}


class CountingSystem(CompiledSystem):
    """Compiled equations that count steps and iterations of Newton's method."""

    steps = iterations = 0

    def step(
        self,
        state: np.ndarray,
        multipliers: np.ndarray,
        inputs: Inputs,
        weights: Weights,
        limits: Limits,
    ) -> tuple[bool, int]:
        """Solve a step as `CompiledSystem` does, and count it."""
        converged, iterations = super().step(state, multipliers, inputs, weights, limits)
        self.steps += 1
        self.iterations += iterations
        return converged, iterations


class Spent(NamedTuple):
    """Cost of a run."""

    start: float  # processor time of the search for take-up and rest, s
    run: float  # processor time of the motion, s
    iterations: float  # a step of the motion


@threadpool_limits.wrap(limits=1, user_api="blas")
def timed(case: Case, duration: float) -> tuple[History, Spent]:
    """Run a case from its take-up and rest on, without what earlier runs have found."""
    take_up_of.cache_clear()
    times = [clock.process_time()]
    case = tensioned(case)
    system = CountingSystem(case, assemble(case))
    begin(system)
    times.append(clock.process_time())
    # settling on cells takes steps, too
    steps, iterations = system.steps, system.iterations
    history = integrate(system, duration, progress=False)
    times.append(clock.process_time())
    each = (system.iterations - iterations) / (system.steps - steps)
    return history, Spent(times[1] - times[0], times[2] - times[1], each)


def loads_of_links(history: History) -> dict[str, float]:
    """Return side force (kN) and moment (kN m) of all links at constant speed: rms and greatest."""
    late = history.dataset.sel(time=history.time > AFTER)
    across = np.abs(late.joint_force.sel(axis="y").values)
    moment = np.linalg.norm(late.joint_torque.transpose(..., "axis").values, axis=-1)
    row = {}
    for name, values in (("across", across), ("moment", moment)):
        row[f"{name}, rms"] = 1e-3 * float(np.sqrt(np.mean(values**2)))
        row[f"{name}, greatest"] = 1e-3 * float(values.max())
    return row


def study(out: Path | None = None, say: Callable[[str], None] = quiet) -> pd.DataFrame:
    """Tabulate loads of links and costs by motion and joints; `out` gets `play.csv`.

    Forces are in kN, moments in kN m. The columns "run" and "whole" are processor times over those of ideal
    joints, without and with the search for take-up and rest.
    """
    folder = None if out is None else writable_folder(out)
    rows = []
    for name, motion in MOTIONS.items():
        cases = {joints: JOINTS[joints](motion.make()) for joints in motion.joints}
        timed(cases[IDEAL], AFTER)  # loads what is compiled
        loads: dict[str, dict[str, float]] = {}
        spent: dict[str, list[Spent]] = {joints: [] for joints in cases}
        for _ in range(ROUNDS):
            for joints, case in cases.items():
                say(f"{name}: {joints}")
                history, cost = timed(case, motion.duration)
                loads[joints] = loads_of_links(history)
                spent[joints].append(cost)
        for joints, costs in spent.items():
            row = {"motion": name, "joints": joints, **loads[joints], "iterations": costs[0].iterations}
            ideal = spent[IDEAL]
            row["run"] = min(cost.run for cost in costs) / min(cost.run for cost in ideal)
            row["whole"] = min(cost.start + cost.run for cost in costs) / min(
                cost.start + cost.run for cost in ideal
            )
            rows.append(row)
    table = pd.DataFrame(rows)
    save(folder, play=table)
    return table
