"""Rows of states for tests."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.model.state import StateLayout


def row_of(layout: StateLayout, parts: Mapping[str, ArrayLike]) -> np.ndarray:
    """Row of a state (size,) with these parts; all others are zero."""
    row = np.zeros(layout.size)
    for name, values in parts.items():
        layout.part(row, name)[...] = values
    return row
