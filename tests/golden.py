"""Short runs whose numbers are kept: what a change of the code alone must not move.

``python -m tests.golden`` writes them anew; do so only with a change that means to move them, and say in the
changelog why it does.
"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from exudyn_crawler import Case, Drive, History, StepProfile, recover_stresses, simulate
from studies.grounds import plain, uneven_case

KEPT = Path(__file__).with_name("golden.json")
SPEED = StepProfile(times=(0, 0.2), values=(0, 0.1))
"""m/s: from rest to the papers' speed 25 times as fast as theirs, so that a short run slips."""
TURN = StepProfile(times=(0, 0.2), values=(0, 0.02))
SAMPLES = 12


def _driven(case: Case, **changes: object) -> Case:
    return case.with_(drive=case.drive.with_(speed=SPEED), **changes)


def _turned(case: Case) -> Case:
    return case.with_(drive=Drive(speed=SPEED, turn_rate=TURN))


def _flexible() -> Case:
    case = _driven(Case.stress("coarse"))
    return case.with_(flexible=case.flexible.with_(shoes=(7, 13)))


CASES: dict[str, tuple[Callable[[], Case], float]] = {
    "pair": (lambda: _driven(plain(Case.translation())), 0.3),
    "leaning": (lambda: _turned(Case.turning("uneven")), 0.2),
    "turning": (lambda: _turned(plain(Case.turning())), 0.2),
    "constrained": (lambda: _driven(plain(Case.translation()), terrain_formulation="constrained"), 0.1),
    "spheres": (lambda: _driven(uneven_case("rough")), 0.1),
    "flexible": (_flexible, 0.1),
}
"""Case and duration (s) of every kept run: each contact model, terrain formulation and kind of shoe."""


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


def run(name: str) -> dict[str, list[float]]:
    """Numbers of one of the kept runs, with its peak stresses where shoes are flexible."""
    make, duration = CASES[name]
    history = simulate(make(), duration)
    found = numbers(history)
    if history.case.flexible is not None:
        peaks = recover_stresses(history, [0.0, duration]).dataset.peak_von_mises
        for shoe in peaks.shoe.values:
            highest = np.sort(peaks.sel(shoe=shoe).values)[-5:]
            found[f"peak von Mises of shoe {shoe}"] = highest.tolist()
    return found


if __name__ == "__main__":
    KEPT.write_text(json.dumps({name: run(name) for name in CASES}, indent=1) + "\n", encoding="utf-8")
