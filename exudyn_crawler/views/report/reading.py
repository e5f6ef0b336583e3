"""Histories and stresses that a report finds in the folders of runs."""

from pathlib import Path

import h5py
import xarray as xr

from exudyn_crawler.results.history.catalogue import check_dimensions
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.report.left_out import LeftOut
from fem.interrupts import interrupts_wait

STRESSES = "stress.nc"


def run_folders(folder: Path) -> list[Path]:
    """A folder and those of the runs in it: a study keeps each of its cases in a folder of its own."""
    return [folder, *sorted({path.parent for path in folder.glob("*/history*.nc")})]


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


@interrupts_wait()
def _holds_a_case(path: Path) -> bool:
    # first without h5netcdf, which fills the terminal over a file that HDF5 cannot read
    with h5py.File(path, "r") as file:
        return "case" in file.attrs


@interrupts_wait()
def stress_of(folder: Path) -> xr.Dataset | None:
    """Stresses that a run has left in a folder; None if there are none.

    Raises
    ------
    ValueError
        Naming the file, if it cannot be read.
    """
    path = folder / STRESSES
    if not path.is_file():
        return None
    try:
        _holds_a_case(path)
        dataset = xr.load_dataset(path, engine="h5netcdf")
        check_dimensions(dataset)
    # altered bytes make the readers raise all kinds of errors
    except Exception as error:
        reason = " ".join(str(error).split()) or repr(error)
        raise ValueError(f"{path} cannot be read: {reason}") from error
    return dataset
