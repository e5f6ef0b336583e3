"""Catalogue of quantities: what the variables of a history and those derived from it are called and measure.

`quantities.csv` holds them, a row each. Histories take their attributes from here, figures and tables their
units and labels.
"""

import csv
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from numpy.typing import NDArray

Variable = tuple[tuple[str, ...], NDArray, dict[str, str]]
"""Dimensions, values and attributes, as xarray takes a variable."""

CATALOGUE = Path(__file__).with_name("quantities.csv")
"""Columns as the fields of `Quantity`; dimensions with spaces between."""


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
    long_name : str
        Meaning, with what it counts from and which way it points.
    dimensions : tuple of str
        Of the variable.
    label : str
        Of axes, without the unit.
    """

    name: str
    symbol: str
    unit: str
    long_name: str
    dimensions: tuple[str, ...]
    label: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a variable."""
        return ({"units": self.unit} if self.unit else {}) | {"long_name": self.long_name}


def _catalogue() -> Iterator[Quantity]:
    with CATALOGUE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            dimensions = tuple(row.pop("dimensions").split())
            yield Quantity(**row, dimensions=dimensions)


QUANTITIES = {quantity.name: quantity for quantity in _catalogue()}
"""Every quantity by the name of its variable."""


def variable(name: str, values: NDArray, without: Iterable[str] = ()) -> Variable:
    """Variable of a dataset with its quantity's dimensions, but for those it goes `without`."""
    quantity = QUANTITIES[name]
    dropped = set(without)
    return tuple(dim for dim in quantity.dimensions if dim not in dropped), values, quantity.attributes


def check_dimensions(dataset: xr.Dataset) -> None:
    """Refuse a dataset of which a variable has not its quantity's dimensions.

    Raises
    ------
    ValueError
        Naming the variable.
    """
    for name, found in dataset.data_vars.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and set(found.dims) != set(quantity.dimensions):
            raise ValueError(f"{name} has dimensions {found.dims}, not {quantity.dimensions}")
