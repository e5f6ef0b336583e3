"""Long columns of numbers in CSV files."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.files import whole_file

DIGITS = 10
"""Of a number in a CSV file: the last ones of sixteen are rounding alone, 1.5860000000000005 for 1.586."""
NUMBER = f"%.{DIGITS}g"


def write_columns(columns: Mapping[str, NDArray], path: Path, overwrite: bool = False) -> Path:
    """Write columns of numbers, of the same length, as CSV, whole or not at all.

    Parameters
    ----------
    columns : mapping of str to array (rows,)
        By what stands over them.
    """
    with whole_file(path, overwrite) as temporary:
        np.savetxt(
            temporary,
            np.column_stack(list(columns.values())),
            fmt=NUMBER,
            delimiter=",",
            header=",".join(columns),
            comments="",
            encoding="utf-8",
        )
    return path
