"""Pictures on a page."""

import base64
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from PIL import Image

from exudyn_crawler.views.report.frames import first_frame, frame_at, frame_titles
from exudyn_crawler.views.stress_pictures import picture_time

WIDTH = 1500
"""Pixels of a picture on the page."""


def embedded_picture(path: Path, stress: xr.Dataset | None) -> dict[str, str]:
    """Picture of stress as a data URI with what its time is, as far as that is known."""
    time = picture_time(path)
    title = f"t = {time:.6g} s"
    if stress is not None and abs(float(stress.frame[at := frame_at(stress, time)]) - time) < 1e-4:
        title = frame_titles(stress)[at]
    return {"title": title, "uri": _data_uri(path)}


def first_picture(paths: Sequence[Path], stress: xr.Dataset | None) -> int:
    """Index of the picture that is shown first: that of the highest stress."""
    if stress is None or not paths:
        return 0
    shown = float(stress.frame[first_frame(stress)])
    return int(np.argmin([abs(picture_time(path) - shown) for path in paths]))


def _data_uri(path: Path) -> str:
    """Picture no wider than the page needs."""
    with Image.open(path) as opened:
        image = opened.convert("RGB")
    if image.width > WIDTH:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        image = image.resize(size, Image.Resampling.LANCZOS)
    memory = io.BytesIO()
    image.save(memory, format="webp", quality=85)
    encoded = base64.b64encode(memory.getvalue()).decode("ascii")
    return f"data:image/webp;base64,{encoded}"
