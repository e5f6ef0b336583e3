"""The chosen times of a run's stresses: what each is, and the one that is shown first."""

import numpy as np
import xarray as xr

PEAK = "peak"


def frame_titles(stress: xr.Dataset) -> list[str]:
    """Chosen times for reading: ``t = 0.226 s, peak``."""
    names = stress.frame_name.values.tolist() if "frame_name" in stress else [""] * stress.sizes["frame"]
    return [
        ", ".join(filter(None, (f"t = {time:.6g} s", name)))
        for time, name in zip(stress.frame.values, names, strict=True)
    ]


def first_frame(stress: xr.Dataset) -> int:
    """Index of the peak, or of the highest stress among the chosen times where that is not one of them."""
    titles = frame_titles(stress)
    peaks = [k for k, title in enumerate(titles) if PEAK in title.split(", ")]
    if peaks:
        return peaks[0]
    highest = stress.frame_von_mises.max([dim for dim in stress.frame_von_mises.dims if dim != "frame"])
    return int(highest.values.argmax())


def frame_at(stress: xr.Dataset, time: float) -> int:
    """Index of the chosen time nearest to one."""
    return int(np.abs(stress.frame.values - time).argmin())
