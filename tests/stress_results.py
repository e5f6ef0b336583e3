"""Results of a stress study in its own form, from short real runs."""

import pandas as pd
import xarray as xr

from exudyn_crawler import Case, Drive, FatigueMaterial, History, LoadCycle, StepProfile, simulate
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.results.stress.recovery import recover_stresses
from tests.small_shoe import SMALL_SHOE

WEAK = FatigueMaterial.a36().with_(fatigue_strength=90e6)
"""So weak that the small stresses of a short run wear it out."""


def short_run(
    duration: float, shoes: tuple[int, ...] = (7, 13), mesh: str = SMALL_SHOE, top_speed: float = 0.05
) -> History:
    """Track of the stress study with some flexible shoes, set going within half the run."""
    case = Case.stress(mesh)
    case = case.with_(
        drive=Drive(speed=StepProfile(times=(0.0, 0.5 * duration), values=(0.0, top_speed))),
        loads=LoadCycle.propel(),
        flexible=case.part(FlexibleShoes).with_(shoes=shoes),
    )
    return simulate(case, duration)


def by_modes_alone(history: History) -> History:
    """The same history, whose stresses have no static fields."""
    flexible = history.case.part(FlexibleShoes).with_(static_fields=False)
    return History(history.case.with_(flexible=flexible), history.dataset)


def stress_results(history: History, frames: list[float]) -> tuple[xr.Dataset, dict[int, pd.DataFrame]]:
    """Stress dataset of a history and the tables of hot spots by shoe."""
    results = recover_stresses(history, frames, peak=False)
    return results.dataset, dict(results.hot_spots)
