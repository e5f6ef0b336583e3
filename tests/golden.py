"""Short runs whose numbers are kept: what a change of the code alone must not move.

``python -m tests.golden`` writes them anew, with names only those of these runs; do so only with a change
that means to move them, and say in the changelog why it does.
"""

import json
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from exudyn_crawler import Case, Drive, History, StepProfile, recover_stresses, simulate
from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.gear.running_gear import Bogie
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from studies.grounds import plain, uneven_case
from tests.rolled import small_case

KEPT = Path(__file__).with_name("golden.json")
SPEED = StepProfile(times=(0, 0.2), values=(0, 0.1))
"""m/s: from rest to the papers' speed 25 times as fast as theirs, so that a short run slips."""
TURN = StepProfile(times=(0, 0.2), values=(0, 0.02))
PULLED = StepProfile(times=(0.05, 0.1), values=(0, 0.4))
"""Slip that a drawbar holds."""
SAMPLES = 12


def _driven(case: Case, **changes: object) -> Case:
    return case.with_(drive=case.drive.with_(speed=SPEED), **changes)


def _turned(case: Case) -> Case:
    return case.with_(drive=Drive(speed=SPEED, turn_rate=TURN))


def _flexible() -> Case:
    case = _driven(Case.stress("coarse"))
    return case.with_(flexible=case.flexible.with_(shoes=(7, 13)))


def _on_sand(case: Case) -> Case:
    return case.on_cells(BekkerSoil.lete_sand(), cell=0.2)


def _on_arms() -> Case:
    """Half a machine on seven trailing arms, which a drawbar holds back."""
    case = Case.closed()
    gear = case.gear
    moment = 0.5 * gear.carried_mass * case.gravity / len(gear.rollers)  # of an even load on 0.5 m
    arms = tuple(
        Arm(
            roller=number,
            pivot=(x + 0.5, 0.2),
            mass=500.0,
            inertia=(20.0, 60.0, 60.0, 0.0, 0.0, 0.0),
            torque=moment,
            stiffness=10.0 * moment,
            damping=1e4,
        )
        for number, x in enumerate(gear.rollers, start=1)
    )
    speed = StepProfile(times=(0, 0.1), values=(0, 0.3))
    drive = Drive(speed=speed, slip=PULLED, drawbar_height=0.5)
    return _on_sand(case.with_({"gear.arms": arms}).with_(drive=drive))


def _on_bogies() -> Case:
    """A bogie that comes down from a ridge, so that it turns; the pivot is off its middle and its COM."""
    bogie = Bogie(
        rollers=(1, 2),
        pivot=(-0.9, 0.2),
        com=(0.1, 0.3),
        mass=2e3,
        inertia=(100.0, 800.0, 800.0, 0.0, 0.0, 0.0),
    )
    ridge = Heights(parts=(Ridge(x=11.4, height=0.06, width=0.3, flank=0.4),))
    case = small_case(bogies=(bogie,)).on_cells(RockFloor.hard_floor(), ridge)
    speed = StepProfile(times=(0, 0.2), values=(0, 0.4))
    solver = case.solver.with_(step=5e-4, output_interval=5e-4)
    return case.with_(drive=case.drive.with_(speed=speed), solver=solver)


CASES: dict[str, tuple[Callable[[], Case], float]] = {
    "pair": (lambda: _driven(plain(Case.translation())), 0.3),
    "leaning": (lambda: _turned(Case.turning("uneven")), 0.2),
    "turning": (lambda: _turned(plain(Case.turning())), 0.2),
    "constrained": (lambda: _driven(plain(Case.translation()), terrain_formulation="constrained"), 0.1),
    "spheres": (lambda: _driven(uneven_case("rough")), 0.1),
    "flexible": (_flexible, 0.1),
    "closed": (lambda: _driven(Case.closed()), 0.1),
    "machine": (lambda: _driven(Case.shovel()), 0.1),
    "machine on sand": (lambda: _driven(_on_sand(Case.shovel())), 0.05),
    "arms": (_on_arms, 0.15),
    "bogies": (_on_bogies, 0.3),
}
"""Case and duration (s) of every kept run: each contact model, terrain formulation, shoe and gear."""


def numbers(history: History) -> dict[str, list[float]]:
    """Of every variable over time: its greatest magnitude, its root mean square and values at the end."""
    found = {}
    for name, values in history.dataset.data_vars.items():
        if "time" in values.dims:
            end = np.nan_to_num(values.isel(time=-1).values.astype(float)).ravel()
            all_times = np.nan_to_num(values.values.astype(float))
            some = end[np.linspace(0, end.size - 1, min(SAMPLES, end.size)).astype(int)]
            found[str(name)] = [np.abs(all_times).max(), np.sqrt(np.mean(all_times**2)), *some]
    return {name: [float(value) for value in values] for name, values in found.items()}


@cache
def history_of(name: str) -> History:
    """History of one of the kept runs."""
    make, duration = CASES[name]
    return simulate(make(), duration, progress=False)


def run(name: str) -> dict[str, list[float]]:
    """Numbers of one of the kept runs, with its peak stresses where shoes are flexible."""
    history = history_of(name)
    found = numbers(history)
    if history.case.flexible is not None:
        peaks = recover_stresses(history, [0.0, CASES[name][1]]).dataset.peak_von_mises
        for shoe in peaks.shoe.values:
            highest = np.sort(peaks.sel(shoe=shoe).values)[-5:]
            found[f"peak von Mises of shoe {shoe}"] = highest.tolist()
    return found


def write(kept: dict[str, dict[str, list[float]]]) -> None:
    """Write the numbers of runs, a variable per line."""
    runs = []
    for name, found in kept.items():
        lines = [f"  {json.dumps(variable)}: {json.dumps(values)}" for variable, values in found.items()]
        runs.append(f" {json.dumps(name)}: {{\n" + ",\n".join(lines) + "\n }")
    KEPT.write_text("{\n" + ",\n".join(runs) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    only = sys.argv[1:] or list(CASES)
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    write({name: run(name) if name in only else kept[name] for name in CASES})
