"""What the report's interactive plots draw.

Long series keep the least and the greatest value of every bin of time, so that no extreme is lost.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views import figures as of
from exudyn_crawler.views.figures import Series
from exudyn_crawler.views.pages.packing import packed
from exudyn_crawler.views.style import negligible

SERIES_BYTES = 4_500_000
"""Size on the page that all series together may have."""
BYTES_A_POINT = 6 * 4 / 3
"""A 16-bit number of the time and a 32-bit value, in base64."""
LEAST_POINTS, MOST_POINTS = 200, 4000
"""Points that a series keeps at least and at most."""
FEW = 5
"""Items of many that are drawn at first."""


def thinned(values: NDArray, points: int) -> NDArray:
    """Indices to keep of a series (n,): ends, and the least and greatest of bins; at most about `points`."""
    n = len(values)
    if n <= points:
        return np.arange(n)
    bins = max(1, points // 2 - 1)
    width = -(-n // bins)
    padded = np.concatenate((values, np.full(-n % width, values[-1]))).reshape(-1, width)
    starts = width * np.arange(len(padded))
    kept = np.concatenate(([0, n - 1], starts + padded.argmin(axis=1), starts + padded.argmax(axis=1)))
    return np.unique(np.minimum(kept, n - 1))


def points_a_series(cases: Mapping[str, list[Series]]) -> int:
    """Points that each series may keep, for all of them to fit on a page."""
    count = sum(series.count for found in cases.values() for series in found)
    return int(np.clip(SERIES_BYTES / BYTES_A_POINT / max(count, 1), LEAST_POINTS, MOST_POINTS))


def packed_case(found: list[Series], points: int) -> dict[str, Any]:
    """All quantities of a case; they share their stored times where they have the same."""
    times: list[NDArray] = []
    quantities = []
    for series in found:
        time = series.values.time.values
        same = [k for k, one in enumerate(times) if np.array_equal(one, time)]
        if not same:
            times.append(time)
        place = same[0] if same else len(times) - 1
        quantities.append(_packed_series(series, points) | {"time": place})
    return {"times": [packed(time, "f4") for time in times], "quantities": quantities}


def packed_phases(history: History) -> list[dict[str, Any]]:
    """Name, begin and end (s) of every phase of a run that has a band behind the curves."""
    found = common_phases(history)
    return [phase._asdict() for phase in found] if len(found) > 1 else []


def _packed_series(series: Series, points: int) -> dict[str, Any]:
    """Quantity for the page: names, and for every item and axis packed indices of time and values."""
    kind = "u2" if series.values.sizes["time"] < 2**16 else "u4"
    rows = []
    for item in series.values.transpose("item", "axis", "time").values:
        kept = [thinned(values, points) for values in item]
        rows.append(
            [[packed(k, kind), packed(values[k], "f4")] for k, values in zip(kept, item, strict=True)]
        )
    return {
        "group": series.group,
        "label": series.label,
        "unit": series.unit,
        "floor": negligible(series.unit),
        "items": [str(item) for item in series.values["item"].values],
        "axes": [str(axis) for axis in series.values.axis.values],
        "index": kind,
        "drawn": _drawn(series),
        "series": rows,
    }


def _drawn(series: Series) -> list[int]:
    """Numbers of the items that are drawn at first: those that the papers draw, else some evenly spread."""
    found = (re.search(r"\d+", str(item)) for item in series.values["item"].values)
    numbers = sorted({int(one[0]) for one in found if one})
    usual = of.JOINTS if series.group == "links" else of.SHOES
    if series.group == "rollers" and series.label != of.RAIL_FORCE:
        return numbers
    if not numbers or (set(usual) <= set(numbers) and numbers[-1] <= of.SHOES[-1]):
        return list(usual)
    places = np.linspace(0, len(numbers) - 1, min(FEW, len(numbers)))
    return [numbers[round(place)] for place in places]


def first_plots(found: Mapping[str, list[Series]]) -> list[str]:
    """Labels of what the plots show first: stress, or else what moves the track, and what it carries."""
    labels = {series.label for one in found.values() for series in one}
    rolled = of.ROLLER_FORCE in labels
    moving = of.PULL if rolled else "velocity"
    return [
        of.HIGHEST_STRESS if of.HIGHEST_STRESS in labels else moving,
        of.ROLLER_FORCE if rolled else "contact force",
    ]


def thinning(histories: Iterable[History], points: int) -> str:
    """What the reader has to know about left-out times."""
    most = max((one.time.size for one in histories), default=0)
    if most <= points:
        return "Every stored time is drawn."
    return (
        f"Of the {most} stored times each curve keeps the least and the greatest value in every one of "
        f"{points // 2 - 1} equal parts of the run, so that no extreme is lost; in between it is thinner "
        "than what was computed."
    )
