"""Columns of numbers in CSV files."""

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler.views.columns import write_columns
from exudyn_crawler.views.tables import write_table


def test_columns_are_written_as_tables_are(tmp_path):
    rng = np.random.default_rng(3)
    columns = {
        "time in s": np.arange(5) * 0.004,
        "xx in MPa": rng.standard_normal(5) * 10.0 ** np.arange(-9, 6, 3),
    }
    found = write_columns(columns, tmp_path / "columns.csv")
    table = write_table(pd.DataFrame(columns), tmp_path / "table.csv")
    assert found.read_text() == table.read_text()
    with pytest.raises(FileExistsError, match="--overwrite"):
        write_columns(columns, tmp_path / "columns.csv")
