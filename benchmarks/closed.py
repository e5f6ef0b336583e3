"""Cost of closed tracks: whole runs less their start, and integration alone, medians of rounds of all.

And what one flexible shoe adds, which is less than these drift by: the least time that every step took in
several runs, which other work disturbs least, in several processes, whose memory lies differently.
`python -m benchmarks.closed` prints the tables.
"""

import multiprocessing
import statistics
import time as clock
from concurrent.futures import ProcessPoolExecutor
from unittest import mock

import numpy as np
import pandas as pd

from benchmarks.growth import timed
from exudyn_crawler import Case, FlexibleShoes, LoadCycle, simulate
from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.run.solve.stages import Recorder
from exudyn_crawler.views.tables import print_table
from studies.closed import INTERVAL, ON_SPOT, TURNS, turning_case

START, DURATION = 0.02, 5.0
"""s, of the run that is taken off the whole one, and of that one."""
ROUNDS = 7
"""In which the cases take turns: other work on a machine comes and goes."""
SHOES, PROCESSES, RUNS = (38, 40), 6, 5
"""Of the least times of steps; runs of a process take turns, too."""


def longer_loop(case: Case, shoes: int) -> Case:
    """Return a closed track with a number of shoes; tumbler and idler move apart by the added length."""
    frame = case.part(Closed)
    more = 0.25 * (shoes - case.track.shoe_count) * case.track.pitch
    (rear, height), (front, low) = frame.tumbler.place, frame.idler.place
    return case.with_(
        track=case.track.with_(shoe_count=shoes),
        loads=LoadCycle.constant([0.0] * shoes),
        gear=frame.with_(
            tumbler=frame.tumbler.with_(place=(rear - more, height)),
            idler=frame.idler.with_(place=(front + more, low)),
        ),
    )


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
    """Return the wall time (s) of every step of a default run, and of the end of its history."""
    stamps: list[float] = []
    store = Recorder.store

    def stamped(recorder: Recorder, time: float) -> None:
        store(recorder, time)
        stamps.append(clock.perf_counter())

    with mock.patch.object(Recorder, "store", stamped):
        simulate(case, DURATION, progress=False)
    return np.diff([*stamps, clock.perf_counter()])


def least(shoes: int) -> list[float]:
    """Wall s a simulated second by the least time of every step, of rigid shoes and of one flexible."""
    rigid, flexible = (longer_loop(case, shoes) for case in list(closed_cases().values())[:2])
    runs = [(step_times(rigid), step_times(flexible)) for _ in range(RUNS)]
    return [float(np.min(times, axis=0).sum()) / DURATION for times in zip(*runs, strict=True)]


def added(shoes: int) -> dict[str, float]:
    """What one flexible shoe adds to a run: medians of processes, and the range of the share."""
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, fresh, max_tasks_per_child=1) as pool:
        pairs = list(pool.map(least, [shoes] * PROCESSES))
    shares = [100.0 * (flexible / rigid - 1.0) for rigid, flexible in pairs]
    return {
        "shoes": shoes,
        "rigid": statistics.median(rigid for rigid, _ in pairs),
        "one flexible": statistics.median(flexible for _, flexible in pairs),
        "adds, %": statistics.median(shares),
        "least, %": min(shares),
        "most, %": max(shares),
    }


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
    shares = pd.DataFrame([added(shoes) for shoes in SHOES])
    print_table(shares, "One flexible shoe, s a simulated second by the least time of every step")


if __name__ == "__main__":
    main()
