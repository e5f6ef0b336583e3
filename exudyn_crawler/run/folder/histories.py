"""Histories and spreads in the folders of runs, found again by their parameters."""

from pathlib import Path

import xarray as xr

from exudyn_crawler.case import Case, CaseFile
from exudyn_crawler.case.files.text import differences
from exudyn_crawler.results.history.history import History
from exudyn_crawler.run.folder.folder import SAME_TIME
from exudyn_crawler.run.folder.reporting import HISTORY
from fem.interrupts import interrupts_wait

SPREAD_FOLDER, SPREAD = "spread", "spread.nc"
"""Where a run's folder has the spread of its stresses."""


def matching_history(folder: Path, case_file: CaseFile) -> History:
    """History of the same case and duration in the folder of an earlier run, or of a study that ran it.

    Raises
    ------
    FileNotFoundError
        If the folder holds none.
    ValueError
        If it comes from other parameters or is shorter or longer, naming what differs.
    """
    case = case_file.case
    paths = (folder / HISTORY, folder / case.name / HISTORY)
    path = next((path for path in paths if path.is_file()), None)
    if path is None:
        raise FileNotFoundError(f"no history at {paths[0]} or {paths[1]}")
    history = History.load(path)
    found = [str(one) for one in differences(history.case, case)]
    if abs(history.duration - case_file.duration) > SAME_TIME:
        found.append(f"duration is {history.duration:g} s, not {case_file.duration:g} s")
    if found:
        raise ValueError(f"{path} comes from other parameters: {'; '.join(found[:5])}")
    return history


@interrupts_wait()
def spread_beside(run: Path, case: Case) -> xr.Dataset | None:
    """Spread of the stresses of the run in a folder, or None if there is none.

    Raises
    ------
    ValueError
        If it comes from another case.
    """
    path = run / SPREAD_FOLDER / SPREAD
    if not path.is_file():
        return None
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        if dataset.attrs.get("case") != case.model_dump_json():
            raise ValueError(
                f"{path} comes from another case than the run beside it: run spread again, or remove it"
            )
        return dataset[["peak_von_mises", "peak_spread", "peak_choice"]].load()
