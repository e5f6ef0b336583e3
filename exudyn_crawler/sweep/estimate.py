"""How long the runs of a sweep take and what they leave, before they are run."""

import os
from collections.abc import Iterable

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.parameters.size import NUMBER, stored_numbers
from exudyn_crawler.sweep.storage import Outcome
from exudyn_crawler.sweep.worker import DONE

BEGIN = 0.5
"""s of a run beside its steps: rest, files, record."""
STEP, STEP_FLEXIBLE = {True: 0.6e-3, False: 1.2e-3}, {True: 0.1e-3, False: 2.0e-3}
"""s a step of 13 rigid shoes, half of it for the history, and more of it a flexible shoe, with compiled
equations and without (docs/speed.md, docs/sweeps.md)."""
SHOES = 13
ROLLED, ROLLED_FLEXIBLE = 2.5, 1.0e-3
"""How many times as much a step of rigid shoes takes that a side frame rolls over, and s more of a flexible
one there."""
RECOVERY = 1.0e-3
"""s a stored time of a flexible shoe, whose stresses are recovered."""
PACKED = 0.75
"""Size of a history on disk to that in memory."""


def run_time(case_file: CaseFile) -> float:
    """Wall time of a run by a rule of thumb, s; a reduction, done once, is not in it."""
    case, solver = case_file.case, case_file.case.solver
    flexible = 0 if case.flexible is None else len(case.flexible.shoes)
    compiled = case.is_compiled
    step, more = STEP[compiled] * case.track.shoe_count / SHOES, STEP_FLEXIBLE[compiled]
    if case.propel == "rolled":
        step, more = ROLLED * step, ROLLED_FLEXIBLE
    step += more * flexible
    stored = case_file.duration / max(solver.output_interval, solver.step)
    return BEGIN + case_file.duration / solver.step * step + RECOVERY * flexible * stored


def run_bytes(case_file: CaseFile) -> float:
    """Size of what a run leaves, about."""
    solver = case_file.case.solver
    stored = case_file.duration / max(solver.output_interval, solver.step)
    return PACKED * NUMBER * stored * stored_numbers(case_file.case) + 20e3


def estimate(case_file: CaseFile, missing: int, workers: int | None, found: Iterable[Outcome]) -> str:
    """Time and disk space of the missing runs in a line.

    Parameters
    ----------
    found : iterable
        Outcomes that are there; finished runs tell how long one takes.
    """
    times = [float(one["wall_time_s"]) for one in found if one.get("status") == DONE]
    each = sum(times) / len(times) if times else run_time(case_file)
    whence = f"as {len(times)} finished ones took" if times else "by a rule of thumb"
    count = workers or os.cpu_count() or 1
    whole = each * missing / min(count, max(missing, 1))
    size = run_bytes(case_file) * missing
    return (
        f"{missing} runs of about {each:.2g} s each ({whence}): {_time(whole)} on {count} workers, "
        f"{each * missing / 3600:.2g} core hours, {size / 1e9:.2g} GB"
    )


def _time(seconds: float) -> str:
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
