"""Kinematics of a crawler track, straight and turning.

Reproduces the motion of the rigid shoes over 10 s of the K-chapter ("Multi-Body Kinematics Simulation
Modeling and Analysis of Shovel Crawler Performance in Rugged Surface Mining Terrains") and the K-paper
("Multi-Body Dynamic Modeling and Simulation of Crawler-Formation Interactions in Surface Mining Operations -
Crawler Kinematics"). It has the prescribed motion of shoe 13 (equations 27 and 29), and the stated extremes
and means of displacements, velocities, accelerations and angular motion. It draws their figures of shoes 1,
4, 7, 10 and 13, and of shoe 10 turning against translation.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Unpack

from exudyn_crawler import Case, CaseFile, History
from exudyn_crawler.results.history.history import common_phases
from exudyn_crawler.views.figures import KINEMATICS, history_series, overlay, panel_figure
from exudyn_crawler.views.style import save_figure
from studies import DURATION
from studies.comparison import compare_kinematics
from studies.running import Compared, Running, compare_cases

CASES = {"translation": Case.translation, "turning": Case.turning}  # cases of the rigid studies by name
COMPARED_SHOE = 10  # shoe that the K-chapter draws turning against translation


def case_files(names: Sequence[str] = tuple(CASES), duration: float = DURATION) -> dict[str, CaseFile]:
    """Return the cases of the rigid studies over a duration (s); `ValueError` for an unknown one or none."""
    if not names or set(names) - set(CASES):
        raise ValueError(f"cases must be among {', '.join(CASES)}, got {list(names)}")
    return {name: CaseFile(case=CASES[name](), duration=duration) for name in names}


def study(
    out: Path | None = None,
    cases: Sequence[str] = tuple(CASES),
    *,
    duration: float = DURATION,
    **how: Unpack[Running],
) -> Compared:
    """Run the cases and compare them with the papers, see `compare_kinematics`.

    See `case_files` for the cases. `out` gets their folders, `comparison.csv` and figures. Errors are those
    of `case_files` and `study_runs`.
    """
    return compare_cases(case_files(cases, duration), out, compare_kinematics, write_figures, **how)


def write_figures(histories: Mapping[str, History], out: Path) -> None:
    """Draw one shoe turning against translation, a figure for each quantity."""
    if len(histories) < 2:
        return
    by_case = {case: history_series(history) for case, history in histories.items()}
    phases = common_phases(*histories.values())
    shoe = f"shoe {COMPARED_SHOE}"
    for quantity, label in KINEMATICS.items():
        panels = overlay({case: series[label] for case, series in by_case.items()}, [shoe])
        name = f"{shoe} {quantity}.png".replace(" ", "_")
        save_figure(panel_figure(f"{shoe}: {quantity}", panels, phases), out / name, overwrite=True)
