"""Pictures on a page."""

import base64
import io
from pathlib import Path

from PIL import Image

from exudyn_crawler.views.stress_pictures import picture_time

WIDTH = 1500
"""Pixels of a picture on the page."""


def embedded_picture(path: Path) -> dict[str, str]:
    """Picture as a data URI, no wider than the page needs."""
    with Image.open(path) as opened:
        image = opened.convert("RGB")
    if image.width > WIDTH:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        image = image.resize(size, Image.Resampling.LANCZOS)
    memory = io.BytesIO()
    image.save(memory, format="webp", quality=85)
    encoded = base64.b64encode(memory.getvalue()).decode("ascii")
    return {"time": f"{picture_time(path):g}", "uri": f"data:image/webp;base64,{encoded}"}
