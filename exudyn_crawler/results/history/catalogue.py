"""Catalogue of quantities: what results are called and measure, where they are and what they need.

`quantities.csv` holds them, a row each, stored and derived ones alike. Histories take their attributes from
here, figures and tables their units and labels, and whoever wants some of the quantities asks by `select`. A
new quantity is a row here and what computes it: a variable of `states`, or a function in `derived`.
"""

import csv
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case

Variable = tuple[tuple[str, ...], NDArray, dict[str, str]]
"""Dimensions, values and attributes, as xarray takes a variable."""

CATALOGUE = Path(__file__).with_name("quantities.csv")
"""Columns as the fields of `Quantity`; several words in one with spaces between."""
SEVERAL = ("dimensions", "files", "derived_from", "needs", "curve_axes")
"""Columns of several words."""
DTYPES = {"double": "f8", "single": "f4"}
"""Of real numbers in files."""
NEEDS = {
    "flexible": "flexible shoes, the case has none",
    "rolled": "a rolled case (undercarriage), the case has none",
    "dragged": "a dragged track, the case has an undercarriage",
}
"""What a quantity may need, and why a case does not do."""


@dataclass(frozen=True)
class Quantity:
    """One quantity.

    Attributes
    ----------
    name : str
        Of the variable in a dataset.
    symbol : str
        Of formulas, in plain text.
    unit : str
        SI; empty for numbers without one.
    dimensions : tuple of str
        Of the variable.
    per : str
        What has one of it: shoe, flexible shoe, link, pin, pair (of a shoe and a unit that met), unit,
        terrain coordinate, roller, tread, side frame, track, node, face, instant or run.
    label : str
        Of axes and curves, without the unit.
    meaning : str
        With what it counts from and which way it points.
    files : tuple of str
        Files of a run's folder (history.nc, stress.nc) that hold it.
    derived_from : tuple of str
        Quantities that it is computed of, as `derived.DERIVED` does it; empty for stored ones.
    by_shoe : str
        How the pairs of a shoe become one of it: "sum", or that of the "deepest" contact; empty if not.
    needs : tuple of str
        What a case must have: words of `NEEDS`.
    numbers : str
        In files: double, single, integer, truth or text.
    curves : str
        Group of the curves over time that show it; empty for none.
    curve_axes : tuple of str
        Components that are drawn; all, if empty.
    compared : str
        "table" where `compare` lists it; "figure 2" where it is drawn, too, as the second; else empty.
    key_result : str
        Place of its greatest value among the first results of a run and what it is called there, "2 greatest
        contact force on a shoe"; empty if it is none of them.
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
    by_shoe: str
    needs: tuple[str, ...]
    numbers: str
    curves: str
    curve_axes: tuple[str, ...]
    compared: str
    key_result: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a variable."""
        return ({"units": self.unit} if self.unit else {}) | {"long_name": self.meaning}

    @property
    def is_vector(self) -> bool:
        """Whether it has a component along each axis."""
        return "axis" in self.dimensions

    @property
    def is_derived(self) -> bool:
        """Whether it is computed of stored quantities when it is asked for."""
        return bool(self.derived_from)

    @property
    def dtype(self) -> np.dtype:
        """Of its numbers in files; in memory all real numbers of a history are double."""
        return np.dtype(DTYPES[self.numbers])

    def lacking(self, case: Case) -> str:
        """What it needs and a case does not have, for reading; empty if it needs nothing more."""
        has = {
            "flexible": case.flexible is not None,
            "rolled": case.undercarriage is not None,
            "dragged": case.undercarriage is None,
        }
        return " and ".join(NEEDS[need] for need in self.needs if not has[need])


def _catalogue() -> Iterator[Quantity]:
    with CATALOGUE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            columns: dict[str, Any] = row | {name: tuple(row[name].split()) for name in SEVERAL}
            yield Quantity(**columns)


QUANTITIES = {quantity.name: quantity for quantity in _catalogue()}
"""Every quantity by the name of its variable."""


def select(**columns: str | bool) -> dict[str, Quantity]:
    """Quantities by name whose columns are, or hold among several words, what is wanted; in their order.

    ``select(per="pair", files="history")``; True and False ask whether a column says anything.
    """

    def fits(quantity: Quantity) -> bool:
        for column, wanted in columns.items():
            value = getattr(quantity, column)
            if isinstance(wanted, bool):
                if bool(value) is not wanted:
                    return False
            elif wanted not in value if isinstance(value, tuple) else wanted != value:
                return False
        return True

    return {name: quantity for name, quantity in QUANTITIES.items() if fits(quantity)}


def variable(name: str, values: NDArray, without: Iterable[str] = ()) -> Variable:
    """Variable of a dataset with its quantity's dimensions, but for those it goes `without`."""
    quantity = QUANTITIES[name]
    dropped = set(without)
    return tuple(dim for dim in quantity.dimensions if dim not in dropped), values, quantity.attributes


def check_dimensions(dataset: xr.Dataset) -> None:
    """Refuse a dataset of which a variable does not have its quantity's dimensions.

    Raises
    ------
    ValueError
        Naming the variable.
    """
    for name, one in dataset.data_vars.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and set(one.dims) != set(quantity.dimensions):
            raise ValueError(f"{name} has dimensions {one.dims}, not {quantity.dimensions}")
