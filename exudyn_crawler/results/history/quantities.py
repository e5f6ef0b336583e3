"""Quantities of results: the rows of `quantities.csv`, with values in the types of their columns."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from exudyn_crawler.settings.rows import read_rows

TABLE = Path(__file__).with_name("quantities.csv")
"""Table with a column for each field of `Quantity`; spaces separate several words in a cell."""
DTYPES = {"double": "f8", "single": "f4"}
"""NumPy types of real numbers in files."""


@dataclass(frozen=True)
class Quantity:
    """Quantity of results.

    Parameters
    ----------
    name : str
        Variable in a dataset.
    symbol : str
        Symbol in formulas, in plain text.
    unit : str
        SI; empty for numbers without one.
    dimensions : tuple of str
    per : str
        Item with one value: shoe, link, pin, pair (of a shoe and a unit in contact), unit, node, run ...
    label : str
        Label of axes and curves, without the unit.
    meaning : str
        Meaning, with the origin and the positive direction.
    files : tuple of str
        Files of a run's folder (history.nc, stress.nc ...) that hold it; empty for derived ones.
    derived_from : tuple of str
        Quantities from which `catalogue.DERIVED` computes it; empty for stored ones.
    by_shoe : str
        Rule that combines the pairs of a shoe: their sum, or the value of the deepest contact.
    needs : tuple of str
        Conditions on the case: words of `catalogue.NEEDS`, or paths of values.
    numbers : str
        Type in files.
    curves : str
        Group of curves over time that show it; empty for none.
    curve_axes : tuple of str
        Drawn components; all if empty.
    compared : bool
        True if it is in the table of `compare`.
    figure : int, optional
        Position among the figures of `compare`.
    key_place : int, optional
        Position of its greatest value among the key results of a run.
    key_result : str
        Name of its greatest value among the key results.
    """

    name: str
    symbol: str
    unit: str
    dimensions: tuple[str, ...]
    per: str
    label: str
    meaning: str
    files: tuple[str, ...]
    derived_from: tuple[str, ...]
    by_shoe: Literal["sum", "deepest", ""]
    needs: tuple[str, ...]
    numbers: Literal["double", "single", "integer", "truth", "text"]
    curves: str
    curve_axes: tuple[str, ...]
    compared: bool
    figure: int | None
    key_place: int | None
    key_result: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a variable."""
        return ({"units": self.unit} if self.unit else {}) | {"long_name": self.meaning}

    @property
    def dtype(self) -> np.dtype:
        """Type of the numbers in files; in memory all real numbers of a history are double."""
        return np.dtype(DTYPES[self.numbers])


QUANTITIES = {row.name: row for row in read_rows(TABLE, Quantity)}
"""Every quantity by the name of its variable."""
