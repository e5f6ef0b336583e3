"""Simulator of the crawler tracks of mining shovels on oil sand.

>>> from exudyn_crawler import Case, simulate
>>> history = simulate(Case.translation(), duration=0.01)
>>> history.position.sel(shoe=13, axis="x").shape
(6,)
"""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exudyn_crawler.case import (
        Case,
        CaseFile,
        Drive,
        FlexibleShoes,
        LoadCycle,
        MachineCycle,
        MachinePhase,
        Outputs,
        PairContact,
        Phase,
        Rails,
        Shoe,
        Solver,
        SphereContact,
        StepProfile,
        Terrain,
        Track,
        Undercarriage,
        read_case,
        write_case,
    )
    from exudyn_crawler.case_run import CaseRun, run_case
    from exudyn_crawler.errors import (
        CaseFileError,
        CrawlerError,
        EquilibriumError,
        ParameterError,
        SimulationStopped,
    )
    from exudyn_crawler.life_run import life
    from exudyn_crawler.results.history.history import History
    from exudyn_crawler.results.life.duty import Duty, DutyRun, read_duty
    from exudyn_crawler.results.life.fatigue_material import FatigueMaterial
    from exudyn_crawler.results.life.life import LifeResults
    from exudyn_crawler.results.loads.actions import actions
    from exudyn_crawler.results.loads.balance import shoe_imbalance
    from exudyn_crawler.results.loads.exports import (
        ShoeLoads,
        action_table,
        pin_forces,
        shoe_loads,
    )
    from exudyn_crawler.results.loads.rollers import frame_imbalance, roller_loads
    from exudyn_crawler.results.stress.basis import stress_basis
    from exudyn_crawler.results.stress.node_stress import node_stress
    from exudyn_crawler.results.stress.recovery import StressResults, peak_time, recover_stresses
    from exudyn_crawler.results.stress.spread import Spread
    from exudyn_crawler.run.solve.simulation import simulate
    from exudyn_crawler.run.solve.track_modes import track_modes
    from exudyn_crawler.spread_run import spread
    from exudyn_crawler.sweep.answers import Answer, HotSpot, Life
    from exudyn_crawler.sweep.definition import Sweep
    from exudyn_crawler.sweep.files import read_sweep
    from exudyn_crawler.sweep.running import SweepRun, run_sweep
    from exudyn_crawler.sweep.vary import Vary
    from exudyn_crawler.views.figures.curves import panel_figure
    from exudyn_crawler.views.figures.series import history_series
    from exudyn_crawler.views.mode_shapes import mode_figure, mode_table
    from exudyn_crawler.views.pages.report import write_report
    from exudyn_crawler.views.scenes.paraview import write_paraview
    from exudyn_crawler.views.scenes.track_film import write_animation


def _check_neighbours() -> None:
    """Refuse to work with other packages of the names of those that are installed beside this one."""
    beside = Path(__file__).resolve().parents[1]
    for name in ("fem", "meshes", "studies"):
        found = find_spec(name)
        origin = None if found is None else found.origin
        if origin is None or Path(origin).resolve().parent != beside / name:
            raise ImportError(
                f"the package {name!r} must be that in {beside}, which comes with {__name__}, got "
                f"{origin or 'none'}: move the other away, or out of the folders where Python looks first"
            )


_check_neighbours()

_HOMES = {
    "Answer": "sweep.answers",
    "CaseFileError": "errors",
    "CaseRun": "case_run",
    "CrawlerError": "errors",
    "Duty": "results.life.duty",
    "DutyRun": "results.life.duty",
    "EquilibriumError": "errors",
    "FatigueMaterial": "results.life.fatigue_material",
    "History": "results.history.history",
    "LifeResults": "results.life.life",
    "ParameterError": "errors",
    "HotSpot": "sweep.answers",
    "SimulationStopped": "errors",
    "ShoeLoads": "results.loads.exports",
    "Spread": "results.stress.spread",
    "StressResults": "results.stress.recovery",
    "Life": "sweep.answers",
    "Sweep": "sweep.definition",
    "SweepRun": "sweep.running",
    "Vary": "sweep.vary",
    "action_table": "results.loads.exports",
    "actions": "results.loads.actions",
    "frame_imbalance": "results.loads.rollers",
    "history_series": "views.figures.series",
    "life": "life_run",
    "mode_figure": "views.mode_shapes",
    "mode_table": "views.mode_shapes",
    "node_stress": "results.stress.node_stress",
    "panel_figure": "views.figures.curves",
    "peak_time": "results.stress.recovery",
    "pin_forces": "results.loads.exports",
    "read_duty": "results.life.duty",
    "read_sweep": "sweep.files",
    "recover_stresses": "results.stress.recovery",
    "roller_loads": "results.loads.rollers",
    "run_case": "case_run",
    "run_sweep": "sweep.running",
    "shoe_imbalance": "results.loads.balance",
    "shoe_loads": "results.loads.exports",
    "simulate": "run.solve.simulation",
    "spread": "spread_run",
    "stress_basis": "results.stress.basis",
    "track_modes": "run.solve.track_modes",
    "write_animation": "views.scenes.track_film",
    "write_paraview": "views.scenes.paraview",
    "write_report": "views.pages.report",
}
"""Modules of the names that are not parts of a case."""

__all__ = [
    "Answer",
    "Case",
    "CaseFile",
    "CaseFileError",
    "CaseRun",
    "CrawlerError",
    "Drive",
    "Duty",
    "DutyRun",
    "EquilibriumError",
    "FatigueMaterial",
    "FlexibleShoes",
    "History",
    "HotSpot",
    "Life",
    "LifeResults",
    "LoadCycle",
    "MachineCycle",
    "MachinePhase",
    "Outputs",
    "PairContact",
    "ParameterError",
    "Phase",
    "Rails",
    "Shoe",
    "ShoeLoads",
    "SimulationStopped",
    "Solver",
    "SphereContact",
    "Spread",
    "StepProfile",
    "StressResults",
    "Sweep",
    "SweepRun",
    "Terrain",
    "Track",
    "Undercarriage",
    "Vary",
    "action_table",
    "actions",
    "frame_imbalance",
    "history_series",
    "life",
    "mode_figure",
    "mode_table",
    "node_stress",
    "panel_figure",
    "peak_time",
    "pin_forces",
    "read_case",
    "read_duty",
    "read_sweep",
    "recover_stresses",
    "roller_loads",
    "run_case",
    "run_sweep",
    "shoe_imbalance",
    "shoe_loads",
    "simulate",
    "spread",
    "stress_basis",
    "track_modes",
    "write_animation",
    "write_case",
    "write_paraview",
    "write_report",
]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is: the engine alone takes a second, and help needs none of it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES.get(name, 'case')}"), name)


def __dir__() -> list[str]:
    """Public names, for completion: they are not here before they are asked for."""
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
