"""Modal loads and coordinates of a flexible shoe, of all modes, by the unit loads of its actions."""

import numpy as np

from exudyn_crawler import History
from exudyn_crawler.results.loads.load_map import INERTIA, loads_by_kind, unit_loads


def modal_loads(history: History, shoe: int) -> np.ndarray:
    """Loads (times, M) of all modes by all that acts on the shoe, N kg^-0.5."""
    acting = loads_by_kind(history, shoe)
    del acting[INERTIA]
    return sum(acting.values()) @ unit_loads(history.case).work


def whole_coordinates(history: History, shoe: int) -> np.ndarray:
    """Coordinates (times, M) of all modes, kg^0.5 m."""
    return sum(loads_by_kind(history, shoe).values()) @ unit_loads(history.case).answers
