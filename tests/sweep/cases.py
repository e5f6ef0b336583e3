"""Small cases and sweeps of them, which take a moment."""

from typing import Any

import numpy as np
import pandas as pd

from exudyn_crawler import Case, CaseFile, LoadCycle
from exudyn_crawler.sweep.answers import Answer
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.results import results_table
from exudyn_crawler.sweep.vary import Vary

STIFFNESS, DAMPING = "terrain.spring_stiffness", "terrain.spring_damping"
FORCE = Answer(quantity="joint_force")


def small_case(duration: float = 0.02, shoes: int = 3) -> CaseFile:
    """Three rigid shoes."""
    base = Case.translation()
    case = base.with_(
        name="small", track=base.track.with_(shoe_count=shoes), loads=LoadCycle.constant([450e3] * shoes)
    )
    return CaseFile(case=case, duration=duration)


def small_sweep(duration: float = 0.02, **changes: Any) -> Sweep:
    """Two stiffnesses of the small case."""
    given: dict[str, Any] = {
        "case": small_case(duration),
        "vary": (Vary(key=STIFFNESS, values=(1e7, 2e7)),),
        "answers": (FORCE,),
    }
    return Sweep(**given | changes)


def answered(sweep: Sweep, **columns: np.ndarray) -> pd.DataFrame:
    """Table of a sweep whose runs gave these answers; NaN is a run that failed."""
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    outcomes = {
        one.digest: {"status": "failed", "answers": {}, "reason": "it <b>sank</b>"}
        if any(value != value for value in row.values())
        else {"status": "done", "answers": row}
        for one, row in zip(sweep.planned, rows, strict=True)
    }
    return results_table(sweep, outcomes)
