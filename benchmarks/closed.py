"""Cost of closed tracks: whole runs less their start, and integration alone, medians of rounds of all.

And what one flexible shoe adds, which is less than such figures drift by: of every step of a run the least time
that it took in several ones, which other work on a machine disturbs least. These differ by process still, as
its memory lies. `python -m benchmarks.closed` prints the tables.
"""

import multiprocessing
import statistics
import time as clock
from concurrent.futures import ProcessPoolExecutor
from unittest import mock

import numpy as np
import pandas as pd

from benchmarks.growth import timed
from exudyn_crawler import Case, FlexibleShoes, simulate
from exudyn_crawler.case import ph4100c
from exudyn_crawler.run.solve.stages import Recorder
from exudyn_crawler.views.tables import print_table
from studies.closed import INTERVAL, ON_SPOT, TURNS, turning_case

START, DURATION = 0.02, 5.0
"""s, of the run that is taken off the whole one, and of that one."""
ROUNDS = 7
"""In which the cases take turns: other work on a machine comes and goes."""
PROCESSES, RUNS = 9, 5
"""Of the least times of steps; runs of a process take turns, too."""


def closed_cases() -> dict[str, Case]:
    """One track of rigid shoes, the same with a flexible one, two tracks straight and on the spot."""
    rigid = Case.closed()
    flexible = rigid.with_(
        shoe=rigid.shoe.of_mass(ph4100c.STRESS_SHOE_MASS),
        flexible=FlexibleShoes.ph4100c("coarse").with_(shoes=(8,)),
    )
    return {
        "38 rigid shoes": rigid,
        "the same, one flexible": flexible,
        "two tracks, straight": Case.shovel(),
        "two tracks, on the spot": turning_case(*TURNS[ON_SPOT]),
    }


def spent(case: Case, interval: float) -> float:
    """Processor s a simulated second of a run that stores at an interval (s), less its start."""
    case = case.with_({"solver.output_interval": interval})
    simulate(case, START, progress=False)  # loads what is compiled
    times = []
    for duration in (START, DURATION):
        begin = clock.process_time()
        simulate(case, duration, progress=False)
        times.append(clock.process_time() - begin)
    return (times[1] - times[0]) / (DURATION - START)


def step_times(case: Case) -> np.ndarray:
    """Wall s of every step of a run as it is made by default, and at the end of its history."""
    stamps: list[float] = []
    store = Recorder.store

    def stamped(recorder: Recorder, time: float) -> None:
        store(recorder, time)
        stamps.append(clock.perf_counter())

    with mock.patch.object(Recorder, "store", stamped):
        simulate(case, DURATION, progress=False)
    return np.diff([*stamps, clock.perf_counter()])


def least(_process: int) -> list[float]:
    """Wall s a simulated second of a rigid track and of one with a flexible shoe, by the least of every step."""
    rigid, flexible, *_ = closed_cases().values()
    runs = [(step_times(rigid), step_times(flexible)) for _ in range(RUNS)]
    return [float(np.min(times, axis=0).sum()) / DURATION for times in zip(*runs, strict=True)]


def print_added() -> None:
    """Print what one flexible shoe adds to a run."""
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, fresh, max_tasks_per_child=1) as pool:
        pairs = list(pool.map(least, range(PROCESSES)))
    added = [100.0 * (flexible / rigid - 1.0) for rigid, flexible in pairs]
    row = {
        "rigid shoes": statistics.median(rigid for rigid, _ in pairs),
        "one flexible": statistics.median(flexible for _, flexible in pairs),
        "adds, %": statistics.median(added),
        "least, %": min(added),
        "most, %": max(added),
    }
    print_table(pd.DataFrame([row]), f"One flexible shoe, s a simulated second, {PROCESSES} processes")


def main() -> None:
    """Print the tables."""
    rows = [
        {
            "what": name,
            "every step stored": spent(case, case.solver.step),
            "every 20 ms": spent(case, INTERVAL),
            "integration alone": timed(case, DURATION)[0]["processor ms a step"] / case.solver.step / 1e3,
        }
        for _ in range(ROUNDS)
        for name, case in closed_cases().items()
    ]
    medians = pd.DataFrame(rows).groupby("what", sort=False).median().reset_index()
    print_table(medians, "Closed tracks, processor s a simulated second")
    print_added()


if __name__ == "__main__":
    main()
