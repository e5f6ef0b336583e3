"""Where a run's folder has the spread of its stresses, and finding it again."""

from pathlib import Path

import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.netcdf import open_netcdf
from fem.interrupts import interrupts_wait

FOLDER, SPREAD = "spread", "spread.nc"


@interrupts_wait()
def spread_beside(run: Path, case: Case) -> xr.Dataset | None:
    """Spread of the stresses of the run in a folder, or None if it has not been found yet.

    Raises
    ------
    ValueError
        If it comes from another case.
    """
    path = run / FOLDER / SPREAD
    if not path.is_file():
        return None
    with open_netcdf(path) as dataset:
        if dataset.attrs.get("case") != case.model_dump_json():
            raise ValueError(
                f"{path} comes from another case than the run beside it: find it anew, or remove it"
            )
        return dataset[["peak_von_mises", "peak_spread", "peak_choice"]].load()
