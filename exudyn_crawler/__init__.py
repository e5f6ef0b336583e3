"""Simulator of the crawler tracks of mining shovels on oil sand.

>>> from exudyn_crawler import Case, simulate
>>> history = simulate(Case.translation(), duration=0.01)
>>> history.position.sel(shoe=13, axis="x").shape
(6,)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exudyn_crawler.case import (
        Case,
        CaseFile,
        Drive,
        FlexibleShoes,
        LoadCycle,
        Outputs,
        PairContact,
        Phase,
        Shoe,
        Solver,
        SphereContact,
        StepProfile,
        Terrain,
        Track,
        read_case,
        write_case,
    )
    from exudyn_crawler.errors import CrawlerError, EquilibriumError, SimulationStopped
    from exudyn_crawler.results.history import History
    from exudyn_crawler.run.simulation import simulate

_HOMES = {
    "CrawlerError": "errors",
    "EquilibriumError": "errors",
    "History": "results.history",
    "SimulationStopped": "errors",
    "simulate": "run.simulation",
}
"""Modules of the names that are not parameters."""

__all__ = [
    "Case",
    "CaseFile",
    "CrawlerError",
    "Drive",
    "EquilibriumError",
    "FlexibleShoes",
    "History",
    "LoadCycle",
    "Outputs",
    "PairContact",
    "Phase",
    "Shoe",
    "SimulationStopped",
    "Solver",
    "SphereContact",
    "StepProfile",
    "Terrain",
    "Track",
    "read_case",
    "simulate",
    "write_case",
]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is: the engine alone takes a second, and help needs none of it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES.get(name, 'case')}"), name)
