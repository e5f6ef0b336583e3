"""Memory of a long duty: ``python -m benchmarks.long_duty [SECONDS [SHOES]]``, or ``SECONDS sand``.

Rigid shoes (default: three) travel to and fro; or the machine over 24 rigid shoes on LETE sand, with all
results and the page. Stages go to disk as they end, so that memory should not grow with the simulated time.
Prints the process's memory at checkpoints, and its growth a simulated second by a straight line over the
second half. Extrapolates the memory of an hour by this line.
"""

import math
import resource
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from exudyn_crawler import Case, CaseFile, Drive, History, LoadCycle, StepProfile, run_case
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.machines import Outputs
from exudyn_crawler.run.folder.checkpoints import Checkpoint, Checkpoints
from exudyn_crawler.views.tables import print_table

SHOES, PERIOD, STAGE = 3, 4.0, 2.5
"""Number; s, of the way to and fro and of a stage."""
HALF = (5.0, 36.0, 4.0)
"""s, in which the machine on sand gets under way, goes on and stops, and then goes back."""
HOUR = 3600.0
ROWS = 40
"""Of the printed table, at most."""


def duty(duration: float, shoes: int) -> Case:
    """Track that goes forth and back at 5 cm/s."""
    base = Case.translation()
    times = np.arange(0.0, duration + PERIOD, 0.5 * PERIOD)
    speeds = 0.05 * np.where(np.arange(len(times)) % 2, 1.0, -1.0)
    speeds[0] = 0.0
    return base.with_(
        name="long duty",
        track=base.track.with_(shoe_count=shoes),
        loads=LoadCycle.propel(shoes),
        drive=Drive(speed=StepProfile(times=tuple(times), values=tuple(speeds)), on=((0.0, duration),)),
        solver=base.solver.with_(checkpoint_interval=STAGE),
    )


def on_sand(duration: float) -> Case:
    """Machine that goes 4 m to and fro every 90 s over 24 rigid shoes, stored every 20 ms."""
    base = Case.rolled().on_cells(BekkerSoil.lete_sand())
    whole = math.ceil(duration / sum(HALF))
    times = np.cumsum([0.0, *HALF * whole])
    speeds = [
        0.0,
        *(sign * one for sign in whole // 2 * (0.1, -0.1) + whole % 2 * (0.1,) for one in (1, 1, 0)),
    ]
    return base.with_(
        name="long duty",
        drive=base.drive.with_(speed=StepProfile(times=tuple(times), values=tuple(speeds))),
        solver=base.solver.with_(step=0.01, output_interval=0.02, checkpoint_interval=10.0),
    )


def memory() -> float:
    """Resident memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


def run(case_file: CaseFile) -> tuple[pd.DataFrame, int]:
    """Memory over simulated time: columns time in s and MB; and the bytes of the history in memory."""
    found: list[tuple[float, float]] = []
    save = Checkpoints.save

    def noted(self: Checkpoints, *stage: Any) -> Checkpoint:
        kept = save(self, *stage)
        found.append((kept.time, memory()))
        return kept

    Checkpoints.save = noted  # type: ignore[method-assign, assignment]
    try:
        with tempfile.TemporaryDirectory() as folder:
            history: History = run_case(case_file, folder, progress=False).history
            size = history.dataset.nbytes
            found.append((case_file.duration, memory()))
    finally:
        Checkpoints.save = save  # type: ignore[method-assign]
    return pd.DataFrame(found, columns=["time in s", "MB"]), size


def main() -> None:
    """Run, and tell."""
    duration = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    if sys.argv[2:] == ["sand"]:
        case_file = CaseFile(case=on_sand(duration), duration=duration)
    else:
        case = duty(duration, int(sys.argv[2]) if len(sys.argv) > 2 else SHOES)
        parts = ("figures", "pictures", "paraview", "tables", "forces", "page")
        nothing = Outputs().with_(**dict.fromkeys(parts, False))
        case_file = CaseFile(case=case, duration=duration, outputs=nothing)
    shoes = case_file.case.track.shoe_count
    table, size = run(case_file)
    shown = table.iloc[[*range(0, len(table) - 1, 1 + len(table) // ROWS), len(table) - 1]]
    print_table(
        shown, f"{shoes} rigid shoes, {duration:g} s; the last row is after the history was assembled"
    )
    late = table[:-1][table["time in s"][:-1] > 0.5 * duration]
    growth = float(np.polyfit(late["time in s"], late["MB"], 1)[0])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(
        f"growth while running: {1e3 * growth:.1f} kB a simulated second; peak of the process {peak:.0f} MB"
    )
    print(f"history in memory: {size / 1e6:.0f} MB, read from disk when asked for beyond 1000 MB")
    print(f"an hour at this growth: {table['MB'].iloc[-2] + growth * (HOUR - duration):.0f} MB")


if __name__ == "__main__":
    main()
