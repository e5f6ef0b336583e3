"""Contact, friction and joint forces, sinkage and terrain deformation of a crawler track.

Reproduces the F-paper ("Contact and Joint Forces Modeling and Simulation of Crawler-Formation Interactions")
on the two runs of the K-paper: the extremes and means of contact and joint forces, penetration, slip and
terrain deformation that it states, and its figures of shoes 1, 4, 7, 10 and 13, of shoe 7 where it crosses
from unit to unit, and of shoe 10 and link 10-11 turning against translation.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler import CaseFile, History
from exudyn_crawler.results.history.history import common_phases
from exudyn_crawler.run.folder.folder import matching_history
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.views.figures import (
    CONTACT_SCALARS,
    CONTACT_VECTORS,
    JOINT_VECTORS,
    Panel,
    history_series,
    link_names,
    overlay,
    panel_figure,
    shoe_names,
)
from exudyn_crawler.views.style import save_figure
from exudyn_crawler.views.tables import write_table
from studies.defaults import DURATION
from studies.force_comparison import compare_forces, turning_ratios
from studies.kinematics import CASES, case_files
from studies.running import Compared, Running, compare_cases

CROSSING_SHOE = 7
"""Shoe that stands on two units, which the F-paper draws apart."""
COMPARED_SHOE, COMPARED_JOINT = 10, 10
"""Shoe and link that the F-paper draws turning against translation."""


def study(
    out: Path | None = None,
    cases: Sequence[str] = tuple(CASES),
    *,
    duration: float = DURATION,
    reuse: Path | None = None,
    strict: bool = True,
    **how: Unpack[Running],
) -> Compared:
    """Run the cases, or take their histories, and compare their forces with the paper.

    As `kinematics.study`; `out` gets `turning_ratios.csv`, too. Histories in `reuse`, the folder of a study,
    take the place of runs with the same parameters; if `strict`, one that is missing is a FileNotFoundError,
    one of other parameters a ValueError.
    """
    files = case_files(cases, duration)
    sources = {name: _source(one, reuse, strict, how.get("say", quiet)) for name, one in files.items()}
    return compare_cases(files, out, compare_forces, write_results, sources, **how)


def _source(case_file: CaseFile, reuse: Path | None, strict: bool, say: Callable[[str], None]) -> Path | None:
    """Folder whose history takes the place of a run, if there is one that fits."""
    if reuse is None:
        return None
    try:
        matching_history(reuse, case_file)
    except (FileNotFoundError, ValueError) as error:
        if strict:
            raise
        if not isinstance(error, FileNotFoundError):
            say(f"{case_file.case.name}: running anew, since {error}")
        return None
    return reuse


def write_results(histories: Mapping[str, History], out: Path) -> None:
    """Draw what the F-paper draws beside the curves of each run; turning against translation as a table."""
    figures = {
        f"{name} shoe {CROSSING_SHOE} crossing": crossing_figure(one) for name, one in histories.items()
    }
    if len(histories) > 1:
        figures |= turning_figures(histories)
        ratios = turning_ratios(histories["translation"], histories["turning"])
        write_table(ratios, out / "turning_ratios.csv", overwrite=True)
    for title, figure in figures.items():
        save_figure(figure, out / f"{title.replace(' ', '_')}.png", overwrite=True)


def crossing_figure(history: History, shoe: int = CROSSING_SHOE) -> Figure:
    """Contacts of one shoe drawn apart, a curve for every volume with a unit that it meets."""
    forces = history.contact_force
    curves: dict[str, dict[str, xr.DataArray]] = {"penetration": {}, "normal": {}, "contact": {}}
    for index in np.flatnonzero(history.contact_shoe.values == shoe):
        unit = f"unit {int(history.contact_unit[index])}"
        if finger := int(history.contact_finger[index]):
            unit += f", finger {finger}"
        curves["penetration"][unit] = history.penetration.isel(contact=index)
        curves["normal"][unit] = history.normal_force.isel(contact=index).sel(axis="z")
        curves["contact"][unit] = forces.isel(contact=index).sel(axis="x")
    panels = [
        Panel.of("penetration depth", curves["penetration"]),
        Panel.of("z normal force", curves["normal"]),
        Panel.of("x contact force", curves["contact"]),
    ]
    title = f"{history.case.name}: shoe {shoe} crossing units"
    return panel_figure(title, panels, common_phases(history))


def turning_figures(histories: Mapping[str, History]) -> dict[str, Figure]:
    """Cases against each other: contact of one shoe, reactions of one link; by a name that can be a file."""
    found = {case: history_series(one) for case, one in histories.items()}
    shoe, link = shoe_names([COMPARED_SHOE])[0], link_names([COMPARED_JOINT])[0]

    def against(label: str, item: str) -> list[Panel]:
        return overlay({case: one[label] for case, one in found.items()}, [item])

    panels = {f"{shoe} {label}": against(label, shoe) for label in CONTACT_VECTORS}
    panels[f"{shoe} sinkage and friction torque"] = [
        panel for label in CONTACT_SCALARS for panel in against(label, shoe)
    ]
    panels |= {f"link {COMPARED_JOINT} {label}": against(label, link) for label in JOINT_VECTORS}
    phases = common_phases(*histories.values())
    return {name: panel_figure(name, one, phases) for name, one in panels.items()}


if __name__ == "__main__":
    from exudyn_crawler.cli import run_script

    run_script("studies.commands:forces")
