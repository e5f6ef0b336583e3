"""Cost of closed tracks: whole runs less their start, and integration alone, medians of rounds of all.

`python -m benchmarks.closed` prints the table.
"""

import time as clock

import pandas as pd

from benchmarks.growth import timed
from exudyn_crawler import Case, FlexibleShoes, simulate
from exudyn_crawler.case import ph4100c
from exudyn_crawler.views.tables import print_table
from studies.closed import INTERVAL, ON_SPOT, TURNS, turning_case

START, DURATION = 0.02, 5.0
"""s, of the run that is taken off the whole one, and of that one."""
ROUNDS = 7
"""In which the cases take turns: other work on a machine comes and goes."""


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


def main() -> None:
    """Print the table."""
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


if __name__ == "__main__":
    main()
