"""Stress study: wall time of its parts, and error by fewer integrated modes.

Two windows, one of propel and one of loading, are integrated from the same state with the default modes and
with all 94. Their peak von Mises stresses are compared.
"""

import tempfile
import time as clock
from pathlib import Path

import numpy as np
import pandas as pd

from exudyn_crawler import Case, Drive, LoadCycle, simulate
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model
from exudyn_crawler.model.state import RATES
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.recovery import recover_stresses
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.views.figures import stress_figures
from exudyn_crawler.views.tables import print_table
from fem import ReducedBody, recover_extremes
from studies.sliding import integrated_from
from studies.stress import compare_stresses, with_modes

WINDOW = 0.1
"""s of each window."""


def loading_case(mesh: str) -> Case:
    """Dig to swing as in the S-paper's cycle, without the propel before it."""
    cycle = LoadCycle.shovel_cycle()
    start, _, dig, swing = (0.0, *(cycle.phases[k] for k in range(3)))
    phases = (dig.with_(end=start), swing.with_(end=swing.end - dig.end))
    return Case.stress(mesh).with_(loads=cycle.with_(phases=phases), drive=Drive.to_rest().with_(on=()))


def windows(mesh: str = "coarse") -> pd.DataFrame:
    """Peak von Mises stress (MPa) of each flexible shoe in both windows, default modes against all 94."""
    rows = []
    for name, case, start in (("propel", Case.stress(mesh), 3.0), ("loading", loading_case(mesh), 4.0)):
        flexible = case.part(FlexibleShoes)
        state, history = _state(case, start)
        few = _peaks(integrated_from(case, state, WINDOW))
        whole = case.with_(flexible=with_modes(flexible, "all"))
        begun = clock.perf_counter()
        many = _peaks(integrated_from(whole, _in_all_modes(history, state, whole), WINDOW))
        spent = clock.perf_counter() - begun
        rows += [
            {
                "window": f"{name} from {start:g} s",
                "shoe": shoe,
                "default": few[shoe],
                "all 94": many[shoe],
                "off": few[shoe] / many[shoe] - 1.0,
                "wall s of all 94": spent,
            }
            for shoe in flexible.shoes
        ]
    return pd.DataFrame(rows)


def _state(case: Case, time: float) -> tuple[np.ndarray, History]:
    """State row of a case at a time, and the history of this one instant."""
    with tempfile.TemporaryDirectory() as folder:
        kept = Checkpoints(Path(folder))
        simulate(case, time + case.solver.step, False, kept)
        state = kept.load(case)[-1].read().state
    return state, system_history(compiled_system(case), state[None])


def _in_all_modes(history: History, state: np.ndarray, whole: Case) -> np.ndarray:
    """Return the state of the track with all modes; further modes follow their loads statically."""
    units, flexible = unit_loads(history.case), history.case.part(FlexibleShoes)
    alone = History(history.case.with_(flexible=flexible.with_(static_fields=False)), history.dataset)
    few, all_modes = compiled_system(history.case).layout, compiled_system(whole).layout
    names = ["time", "multipliers"] + [f"{part}{rate}" for part in ("shoes", "terrain") for rate in RATES]
    parts = {name: few.part(state, name) for name in names}
    # stress is made of one mode more, that of the drive's node, which is not integrated
    turn = _products(units.whole, floating_shoe(whole).reduced, whole)
    parts["modes"] = np.concatenate(list(stress_basis(alone).coordinates.values())) @ turn
    for rate in RATES[1:]:
        parts[f"modes{rate}"] = few.part(state, f"modes{rate}") @ units.integrated.inside.T @ turn
    row = np.empty(all_modes.size)
    for name, values in parts.items():
        all_modes.part(row, name)[...] = values
    return row


def _products(first: ReducedBody, second: ReducedBody, case: Case) -> np.ndarray:
    """Products of two bodies' modes by mass: array (first, second)."""
    body, _ = shoe_model(case.part(FlexibleShoes), case.track)
    modes = [one.modes.reshape(-1, len(one.frequencies)) for one in (first, second)]
    return modes[0].T @ (body.mass_matrix @ modes[1])


def _peaks(history: History) -> dict[int, float]:
    basis = stress_basis(history)
    return {
        shoe: float(recover_extremes(basis.shapes.stress_modes, coordinates).highest.max()) / 1e6
        for shoe, coordinates in basis.coordinates.items()
    }


def study(duration: float = 40.0, mesh: str = "study") -> pd.DataFrame:
    """Wall seconds of each part of the study."""
    case = Case.stress(mesh)
    spent = {}
    begun = clock.perf_counter()

    def lap(name: str) -> None:
        nonlocal begun
        now = clock.perf_counter()
        spent[name] = now - begun
        begun = now

    static_equilibrium(case)
    lap("reduction and equilibrium")
    history = simulate(case, duration, False)
    lap("run")
    results = recover_stresses(history)
    lap("recovery")
    compare_stresses(history, results)
    stress_figures(history, results.dataset)
    lap("tables and figures")
    spent["total"] = sum(spent.values())
    return pd.DataFrame({"part": list(spent), "s": list(spent.values())})


def main() -> None:
    """Print the tables."""
    table = study()
    print_table(table, "Stress study: 40 s, study mesh, six flexible shoes, 30 modes each")
    print_table(windows(), f"Peak von Mises stress over {WINDOW:g} s, MPa, coarse mesh")


if __name__ == "__main__":
    main()
