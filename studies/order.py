"""Order of convergence of smooth motions of each gear, with the step and the integrator's spectral radius."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from exudyn_crawler import Case, StepProfile
from exudyn_crawler.case.parameters.terrain import SoilLaw
from exudyn_crawler.files import writable_folder
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.model.state import StateLayout
from exudyn_crawler.model.track_system import TrackSystem
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.run.solve.simulation import set_times, solver_settings, started
from studies.library import case_files
from studies.running import save

SLOW = StepProfile(times=(0.0, 1.0), values=(0.0, 0.1))
"""m/s: the drive's ramp goes on over the whole motion."""
BEGIN = 0.1
"""Time after which the motion is compared, s: what is left of the search for rest has died away."""
BEFORE = 5e-4
"""Step up to that time, s."""
RESIDUAL = 1e-6
"""Least residual that rounding lets Newton's method reach, N. It leaves 0.1 to 2 N of multipliers."""
RADII = (0.6, 0.9)
"""Spectral radii of the integrator at infinite frequency; the smaller one damps more."""
STEPS = (4e-3, 2e-3, 1e-3, 5e-4)
"""s, each half of the one before."""
PARTS = {"coordinates": "coordinates", "rates": "coordinates rate", "multipliers": "multipliers"}
"""Parts of a state by their columns."""
DIFFERENCE = "multipliers differ by, N"
"""Column of the greatest difference of multipliers between the two finer steps."""


class Smooth(NamedTuple):
    """Smooth motion: the maker of its case, and its length, s, a multiple of the longest step."""

    make: Callable[[], Case]
    length: float


def vehicle_on_arms() -> Case:
    """Return the library's M113, on the sand of its datasheet."""
    return case_files(["m113"])["m113_straight"].case


def closed_on(law: SoilLaw) -> Case:
    """Return the closed track on cells with a soil law."""
    return Case.closed().on_cells(law)


ROUGH = RockFloor.hard_floor().with_(friction=5.0)
"""Floor on which nothing slides: friction stays below its bound."""

MOTIONS = {
    "dragged": Smooth(Case.translation, 0.16),
    "rolled": Smooth(Case.rolled, 0.08),
    "closed": Smooth(Case.closed, 0.08),
    "machine": Smooth(Case.shovel, 0.08),
    "closed on hard floor": Smooth(partial(closed_on, RockFloor.hard_floor()), 0.04),
    "closed on rough hard floor": Smooth(partial(closed_on, ROUGH), 0.04),
    "closed on sand": Smooth(partial(closed_on, BekkerSoil.lete_sand()), 0.04),
    "vehicle on arms on sand": Smooth(vehicle_on_arms, 0.04),
}
"""Motion of each gear, on the papers' ground if its name has none."""


def states_at_end(
    case: Case, length: float, counts: Sequence[int], radius: float
) -> tuple[np.ndarray, StateLayout]:
    """Return the states at the end of a motion of `length` (s) from `BEGIN` by numbers of steps.

    Rows are the states of each number in `counts`; their layout comes with them. All have the same start.
    """
    solver = case.solver.with_(residual=RESIDUAL, spectral_radius=radius)
    system = started(
        case.with_(drive=case.drive.with_(speed=SLOW), solver=solver, name=f"{case.name}, order"),
        progress=False,
    )
    begin = _go_on(system, 0.0, BEGIN, BEFORE)
    memory = {name: values.copy() for name, values in system.memory().items()}
    rows = []
    for count in counts:
        system.set_state(begin, memory)
        rows.append(_go_on(system, BEGIN, BEGIN + length, length / count))
    return np.array(rows), system.layout


def _go_on(system: TrackSystem, start: float, end: float, step: float) -> np.ndarray:
    """Integrate between two times by steps, all in s, and return the state."""
    solver = system.case.solver.with_(step=step, output_interval=1.0)
    settings = solver_settings(solver)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = start == 0.0
    system.solve(settings, set_times(settings, solver, start, end))
    return system.state()


def orders(states: np.ndarray, layout: StateLayout, part: str) -> np.ndarray:
    """Return the orders of a part of states (n, size), each with half the step of the one before: (n - 2,).

    The order is log2 of the norms' ratio of successive differences.
    """
    norms = np.linalg.norm(np.diff(layout.part(states, part), axis=0), axis=1)
    return np.log2(norms[:-1] / norms[1:])


def study(
    out: Path | None = None, names: Sequence[str] = tuple(MOTIONS), say: Callable[[str], None] = quiet
) -> pd.DataFrame:
    """Tabulate the orders of motions by name; `out` gets `order.csv`.

    Columns motion, spectral radius, and "steps, ms": the three steps of an order; those of `PARTS`;
    and `DIFFERENCE`. Raises `ValueError` for an unknown motion.
    """
    if unknown := set(names) - set(MOTIONS):
        raise ValueError(f"motions must be among {', '.join(MOTIONS)}, got {', '.join(sorted(unknown))}")
    folder = None if out is None else writable_folder(out)
    rows = []
    for name in names:
        say(name)
        make, length = MOTIONS[name]
        for radius in RADII:
            counts = [round(length / step) for step in STEPS]
            states, layout = states_at_end(make(), length, counts, radius)
            found = {column: orders(states, layout, part) for column, part in PARTS.items()}
            apart = np.abs(np.diff(layout.part(states, "multipliers"), axis=0)).max(axis=1)
            for k in range(len(STEPS) - 2):
                steps = ", ".join(f"{1e3 * step:g}" for step in STEPS[k : k + 3])
                row = {"motion": name, "spectral radius": radius, "steps, ms": steps}
                row |= {column: values[k] for column, values in found.items()}
                rows.append(row | {DIFFERENCE: apart[k + 1]})
    table = pd.DataFrame(rows)
    save(folder, order=table)
    return table
