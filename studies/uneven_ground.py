"""Track over uneven ground: a step, a ramp or random roughness.

No paper reports this study. The papers' rigid track goes straight over units of different heights, with the
second contact model.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

from exudyn_crawler import CaseFile
from exudyn_crawler.case_run import CaseRun
from studies import DURATION
from studies.grounds import GROUNDS, uneven_case
from studies.running import Running, study_runs


def study(
    out: Path | None = None,
    grounds: Sequence[str] = tuple(GROUNDS),
    *,
    duration: float = DURATION,
    **how: Unpack[Running],
) -> dict[str, CaseRun]:
    """Run the track over some of `GROUNDS` for a duration (s), in folders in `out`; return runs by ground.

    Each run's figure `ground` shows its end. Raises `ValueError` before anything runs for an unknown ground
    or a bad duration. Other errors are those of `study_runs`.
    """
    files = {ground: CaseFile(case=uneven_case(ground), duration=duration) for ground in grounds}
    with study_runs(out, files, **how) as runs:
        return runs
