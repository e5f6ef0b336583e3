"""Both formulations of the equations of motion side by side, and how their cost grows.

Each pair of runs is made in the same minutes, from the same rest; the first step of a process, which loads or
compiles, is left out. `python -m benchmarks.growth` prints the tables, `python -m benchmarks.growth FOLDER`
also writes them as growth.csv and growth.png for docs/speed.md.
"""

import resource
import statistics
import sys
import time as clock
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from exudyn_crawler import Case, FlexibleShoes, LoadCycle, Terrain
from exudyn_crawler.engine.formulation import track_system
from exudyn_crawler.run.solve.simulation import set_times, solver_settings
from exudyn_crawler.run.solve.start import begin
from exudyn_crawler.views.style import STYLE, save_figure
from exudyn_crawler.views.tables import print_table
from studies.stress import with_modes

RUNS = 3
START = 0.1
"""s that are run before the clocks start."""
PULL = 386.4e3
"""N a shoe."""


@threadpool_limits.wrap(limits=1, user_api="blas")
def timed(case: Case, duration: float) -> tuple[dict[str, float], NDArray]:
    """Wall and processor milliseconds a step of one run from rest on one thread, and its last coordinates."""
    system = track_system(case)
    if case.is_compiled:
        begin(system)
    else:
        # both start at one rest: they hold the front shoe at different points, 0.1 um across the track
        system.set_initial(*begin(track_system(case.with_(formulation="compiled"))))
    settings = solver_settings(case.solver)
    set_times(settings, case.solver, 0.0, START)
    steps = 0

    def count(_time: float) -> bool:
        nonlocal steps
        steps += 1
        return True

    system.after_step(count)
    system.solve(settings)
    system.set_state(system.state())
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    set_times(settings, case.solver, START, START + duration)
    steps, wall, processor = -1, clock.perf_counter(), clock.process_time()  # the first call is of the start
    system.solve(settings)
    wall, processor = clock.perf_counter() - wall, clock.process_time() - processor
    spent = {"wall ms a step": 1e3 * wall / steps, "processor ms a step": 1e3 * processor / steps}
    return spent, system.layout.part(system.state(), "coordinates")


def beside(case: Case, duration: float, engine: bool = True) -> dict[str, object]:
    """Return the medians of both formulations and their ratio, or of the compiled one alone."""
    names = ("compiled", "engine") if engine else ("compiled",)
    found: dict[str, list[float]] = {name: [] for name in names}
    ends: dict[str, NDArray] = {}
    for _ in range(RUNS if engine else 1):
        for name in names:
            spent, ends[name] = timed(case.with_(formulation=name), duration)
            found[name].append(spent["processor ms a step"])
    row: dict[str, object] = {
        f"{name}, ms a step": statistics.median(values) for name, values in found.items()
    }
    if engine:
        ratios = [b / a for a, b in zip(found["compiled"], found["engine"], strict=True)]
        row["engine over compiled"] = statistics.median(ratios)
        shoes = slice(0, 6 * case.track.shoe_count)
        row["apart, m and rad"] = float(np.abs(ends["compiled"] - ends["engine"])[shoes].max())
    return row


def longer(shoes: int) -> Case:
    """Straight propel of a track of so many shoes on 7 m units that reach as far."""
    case = Case.translation()
    track = case.track.with_(shoe_count=shoes)
    length = track.pitch * shoes + track.first_com[0] + 8.0
    units = case.part(Terrain)
    terrain = units.with_(columns=int(np.ceil(length / units.unit_length)))
    return case.with_(track=track, terrain=terrain, loads=LoadCycle.constant([PULL] * shoes))


def flexible(numbers: tuple[int, ...], modes: str | None = None) -> Case:
    """Propel with these flexible shoes of the coarse mesh; modes as of `studies.stress.with_modes`."""
    case = Case.stress("coarse")
    if not numbers:
        return case.with_(flexible=None)
    shoes = FlexibleShoes.ph4100c("coarse").with_(shoes=numbers)
    return case.with_(flexible=shoes if modes is None else with_modes(shoes, modes))


def units(columns: int, rows: int) -> Case:
    """Rigid propel on so many 1 m units, or on 50 of 7 m."""
    if columns * rows == 50:
        return Case.translation()
    return Case.stress("coarse").with_(
        flexible=None, terrain=Terrain.stress().with_(columns=columns, rows=rows)
    )


def growths() -> Iterator[dict[str, object]]:
    """Yield a row for each case: growing quantity, its number, and time of a step."""
    for duration in (0.5, 1.0, 2.0, 4.0):
        yield {"what": "simulated s", "number": duration} | beside(Case.translation(), duration)
    for shoes in (6, 13, 26):
        yield {"what": "shoes", "number": shoes} | beside(longer(shoes), 1.0)
    six = (6, 7, 8, 11, 12, 13)
    for numbers in ((), (13,), six, tuple(range(1, 14))):
        yield {"what": "flexible shoes", "number": len(numbers)} | beside(flexible(numbers), 0.2)
    for modes in ("0 fixed", "12 fixed", "34 fixed", "all"):
        case = flexible((13,), modes)
        count = case.part(FlexibleShoes).mode_count
        yield {"what": "modes", "number": count} | beside(case, 0.1, engine=count < 60)
    for columns, rows in ((10, 5), (19, 13), (40, 25)):
        yield {"what": "units", "number": columns * rows} | beside(units(columns, rows), 0.5)


def figure(table: pd.DataFrame) -> Figure:
    """Milliseconds a step over each number, both formulations."""
    names = list(dict.fromkeys(table["what"]))
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(11.0, 2.8))
        for axes, name in zip(drawn.subplots(1, len(names), sharey=True), names, strict=True):
            rows = table[table["what"] == name]
            for formulation, marker in (("compiled", "o"), ("engine", "s")):
                axes.plot(rows["number"], rows[f"{formulation}, ms a step"], marker=marker, label=formulation)
            axes.set(xlabel=name, yscale="log")
        drawn.axes[0].yaxis.set_major_formatter("{x:g}")
        drawn.axes[0].set_ylabel("processor ms a step")
        drawn.axes[0].legend(loc="upper left")
    return drawn


def main(folder: Path | None = None) -> None:
    """Print the table, and write it with its figure into a folder."""
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame(growths())
    print_table(table, "A step in both formulations")
    print(f"greatest memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")
    if folder is not None:
        table.to_csv(folder / "growth.csv", index=False, float_format="%.4g")
        save_figure(figure(table), folder / "growth.png", overwrite=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
