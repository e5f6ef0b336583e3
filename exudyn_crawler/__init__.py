"""Simulator of the crawler tracks of mining shovels on oil sand.

>>> from exudyn_crawler import Case, CrawlerModel
>>> history = CrawlerModel(Case.translation()).simulate(duration=0.01)
>>> history.position.sel(shoe=13, axis="x").shape
(6,)
"""

from exudyn_crawler.errors import CrawlerError, EquilibriumError, SimulationStopped
from exudyn_crawler.history import History
from exudyn_crawler.parameters import (
    Case,
    ContactLaw,
    Drive,
    FlexibleShoes,
    LoadCycle,
    Phase,
    Shoe,
    Solver,
    StepProfile,
    Terrain,
    Track,
)
from exudyn_crawler.simulation import CrawlerModel

__all__ = [
    "Case",
    "ContactLaw",
    "CrawlerError",
    "CrawlerModel",
    "Drive",
    "EquilibriumError",
    "FlexibleShoes",
    "History",
    "LoadCycle",
    "Phase",
    "Shoe",
    "SimulationStopped",
    "Solver",
    "StepProfile",
    "Terrain",
    "Track",
]
