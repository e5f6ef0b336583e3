"""What a report finds in the folders of runs, and what it goes on without."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

import h5py
import xarray as xr

from exudyn_crawler.results.history.catalogue import check_dimensions
from exudyn_crawler.results.history.history import History
from fem.interrupts import interrupts_wait

T = TypeVar("T")

STRESSES = "stress.nc"


class LeftOut(list[str]):
    """Lines that name the files that were left out, and why."""

    def unless_broken(self, path: Path, read: Callable[[Path], T]) -> T | None:
        """What a file holds; None, and a line, if it cannot be read."""
        try:
            return _read(path, read)
        except ValueError as error:
            # a file that is read for several sections is named once
            if not any(line.startswith(f"{path} ") for line in self):
                self.append(str(error))
            return None

    def of_all(self, paths: Iterable[Path], read: Callable[[Path], T | None]) -> list[T]:
        """What those of the files hold that can be read."""
        found = [self.unless_broken(path, read) for path in paths]
        return [one for one in found if one is not None]


def _read(path: Path, read: Callable[[Path], T]) -> T:
    """What a file holds; a ValueError that names the file if it cannot be read."""
    try:
        return read(path)
    # altered bytes make the readers of tables, pictures and NetCDF raise all kinds of errors
    except Exception as error:
        reason = " ".join(str(error).split()) or repr(error)
        named = reason if reason.startswith(f"{path} ") else f"{path} cannot be read: {reason}"
        raise ValueError(named) from error


def histories_in(folders: list[Path], left_out: LeftOut) -> tuple[dict[str, History], dict[str, Path]]:
    """Histories of some folders by case, and the folder of each."""
    histories: dict[str, History] = {}
    places: dict[str, Path] = {}
    for folder in folders:
        for path in sorted(folder.glob("[!.]*.nc")):
            if not path.name.startswith("history") and not left_out.unless_broken(path, _holds_a_case):
                continue
            history = History.load(path)
            name = history.case.name
            if name in histories:
                name = f"{folder.name}, {path.stem}"
            histories[name], places[name] = history, folder
    return histories, places


def stress_of(folder: Path) -> xr.Dataset | None:
    """Stresses that a run has left in a folder; None if there are none; a ValueError if they are broken."""
    path = folder / STRESSES
    return _read(path, _stresses) if path.is_file() else None


@interrupts_wait()
def _holds_a_case(path: Path) -> bool:
    # first without h5netcdf, which fills the terminal over a file that HDF5 cannot read
    with h5py.File(path, "r") as file:
        return "case" in file.attrs


@interrupts_wait()
def _stresses(path: Path) -> xr.Dataset:
    _holds_a_case(path)
    dataset = xr.load_dataset(path, engine="h5netcdf")
    check_dimensions(dataset)
    return dataset
