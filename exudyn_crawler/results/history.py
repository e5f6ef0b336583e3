"""Results of a run: named arrays over time that know their units and where they come from."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Self

import h5py
import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.case.files import saved_case
from exudyn_crawler.files import write_netcdf
from exudyn_crawler.model.state import VERSION

LAYOUT_VERSION = "layout_version"
"""Attribute of the version of the states that a history was made of; the first histories have none."""
UNSIGNED = 1
"""Version whose modes had the signs that rounding gave them: of flexible shoes it says nothing."""


@dataclass(frozen=True)
class History:
    """Results of a run.

    Every variable of the dataset is an attribute too: ``history.position.sel(shoe=13, axis="x")``.
    `exudyn_crawler.results.quantities` lists the variables; each has its unit and meaning in its attributes.

    Attributes
    ----------
    case : Case
        What was run.
    dataset : xarray.Dataset
        Dimensions time (s), shoe, joint, unit, contact and axis (x, y, z of the global frame).
    """

    case: Case
    dataset: xr.Dataset

    def __getattr__(self, name: str) -> xr.DataArray:
        """Variable or coordinate of the dataset."""
        if name.startswith("_") or name not in self.dataset.variables:
            raise AttributeError(
                f"a history has no {name!r}; it has {sorted(map(str, self.dataset.variables))}"
            )
        return self.dataset[name]

    def __dir__(self) -> list[str]:
        """Attributes, for completion: those of every object and the variables."""
        return [*super().__dir__(), *map(str, self.dataset.variables)]

    def _repr_html_(self) -> str:
        """Case in a line and the dataset, for notebooks."""
        shown = f"<p>History of the case {escape(repr(self.case.name))} over {self.duration:g} s</p>"
        return shown + self.dataset._repr_html_()

    @property
    def duration(self) -> float:
        """Time of the last state, s."""
        return float(self.dataset.time[-1])

    def save(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write everything to one NetCDF file.

        Raises
        ------
        FileExistsError
            If the file exists and `overwrite` is false.
        """
        path = Path(path)
        whole = self.dataset.assign_attrs(case=self.case.model_dump_json())
        return write_netcdf(whole, path, overwrite)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a file that `save` wrote.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If the file does not hold a history, or one of states laid out in another version.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"no history at {path}")
        try:
            # first without h5netcdf, which fills the terminal over a file that HDF5 cannot read
            with h5py.File(path, "r") as file:
                found = np.asarray(file.attrs.get(LAYOUT_VERSION, UNSIGNED)).item()
                if found != VERSION and (found != UNSIGNED or "modal_coordinate" in file):
                    raise ValueError(f"its states have layout version {found}, this program reads {VERSION}")
                case = saved_case(file.attrs["case"], path)
            dataset = xr.load_dataset(path, engine="h5netcdf")
            del dataset.attrs["case"]
        except (OSError, KeyError, ValueError, RuntimeError) as error:
            raise ValueError(f"{path} does not hold a history: {error}") from error
        return cls(case=case, dataset=dataset)
