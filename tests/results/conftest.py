"""Runs of the shared fixtures, seen otherwise."""

import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History


@pytest.fixture(scope="session")
def modes_alone(flexible_run: tuple[History, xr.Dataset, dict[int, pd.DataFrame]]) -> History:
    """The run with flexible shoes whose stresses have no static fields."""
    history = flexible_run[0]
    flexible = history.case.flexible_shoes().with_(static_fields=False)
    return History(history.case.with_(flexible=flexible), history.dataset)
