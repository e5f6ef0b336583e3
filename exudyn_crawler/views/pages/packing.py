"""Arrays, scenes and curves in the form that a page's scripts read.

Arrays are base64 of little-endian numbers. Arrays that are only seen in 3D are 16-bit steps of their greatest
magnitude. Long curves keep the least and the greatest value of every bin of time, so that no extreme is lost.
"""

import base64
import re

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex

from exudyn_crawler.results.history import History, common_phases
from exudyn_crawler.views import figures, style
from exudyn_crawler.views.scenes.scene import Scene, Solid

SERIES_BYTES = 4_500_000  # greatest size of all series together on the page
BYTES_A_POINT = 6 * 4 / 3  # a 16-bit number of the time and a 32-bit value, in base64
Kept = dict[tuple[int, int], list[tuple[np.ndarray, np.ndarray]]]
"""Kept points of a quantity by item and axis: for each part of a run, indices of stored times, and values."""
LEAST_POINTS, MOST_POINTS, FEW = 200, 4000, 5
"""Least and greatest number of points of a series, and number of items drawn at first if there are many."""
FIRST = [
    [figures.LABEL[name] for name in ("highest_von_mises", "drive_pull", "drive_moment", "velocity")],
    [figures.LABEL[name] for name in ("roller_force", "link_tension", "contact_force")],
]
"""Labels that both plots of a page show first, if runs have them: motion in one, loads in the other."""


def packed(array: np.ndarray, kind: str) -> str:
    """Return the base64 of an array as little-endian numbers of a kind such as "f4" or "u2"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()).decode("ascii")


class SceneArrays:
    """Arrays of the scenes of a page; an array that several solids share is stored once."""

    def __init__(self) -> None:
        self.packed: list[dict[str, object]] = []
        self._numbers: dict[int, tuple[int, np.ndarray]] = {}

    def add(self, array: np.ndarray | None, kind: str = "f4", rows: int = 1) -> int | None:
        """Return the number of an array, None for None; `rows` is the number of times in the array."""
        if array is None:
            return None
        if id(array) not in self._numbers:
            # the array is kept, so that no other object gets its id
            self._numbers[id(array)] = len(self.packed), array
            self.packed.append({"kind": kind, "data": packed(array, kind), "rows": rows})
        return self._numbers[id(array)][0]

    def add_over_time(self, array: np.ndarray | None, stepped: bool = False) -> int | None:
        """Return the number of an array (times, ...), in 16-bit steps if it is `stepped` and finite."""
        if array is None or not stepped or not np.isfinite(array).all():
            return self.add(array, rows=0 if array is None else len(array))
        kind, most = ("u2", 65535) if array.min() >= 0.0 else ("i2", 32767)
        step = max(float(np.abs(array).max()), 1e-12) / most
        number = self.add(np.rint(array / step), kind, len(array))
        self.packed[-1]["step"] = step
        return number


def packed_scene(
    scene: Scene, arrays: SceneArrays, window: list[tuple[float, float]] | None = None, first: int = 0
) -> dict[str, object]:
    """Return a scene for a 3D view that starts at time index `first`; `window` limits x, y and z (m)."""
    return {
        "titles": scene.titles,
        "first": first,
        "window": window,
        "solids": [_packed_solid(solid, arrays) for solid in scene.solids],
        "arrows": [
            _as_they_are(arrow, "name", "colour", "scale", "solid", "through")
            | {name: arrays.add_over_time(getattr(arrow, name)) for name in ("heads", "forces")}
            for arrow in scene.arrows
        ],
    }


def _packed_solid(solid: Solid, arrays: SceneArrays) -> dict[str, object]:
    return {
        **_as_they_are(solid, "name", "colour", "opacity", "labels", "notes", "larger"),
        "points": arrays.add(solid.points),
        "triangles": arrays.add(solid.triangles, "u4"),
        "nodes": arrays.add(solid.nodes, "u4"),
        "origin": arrays.add_over_time(solid.origin),
        "turn": arrays.add_over_time(solid.turn),
        "lift": arrays.add_over_time(solid.lift, stepped=True),
        "bend": arrays.add_over_time(solid.bend, stepped=True),
        "colourings": [
            {
                **_as_they_are(colouring, "name", "title", "words", "decades"),
                "low": float(colouring.low),
                "high": float(colouring.high),
                "colours": _colour_scale(colouring.colours),
                "nodal": colouring.values.ndim == 3,
                "values": arrays.add_over_time(colouring.values, stepped=not colouring.words),
            }
            for colouring in solid.colourings
        ],
    }


def _as_they_are(item: object, *names: str) -> dict[str, object]:
    return {name: getattr(item, name) for name in names}


def _colour_scale(colours: str | tuple[str, ...]) -> list[list[object]]:
    """Return colours as Plotly reads them: positions from 0 to 1 with a colour; steps have two at an edge."""
    if isinstance(colours, str):
        return [
            [float(place), to_hex(style.colour_map(colours)(place))] for place in np.linspace(0.0, 1.0, 17)
        ]
    edges = np.linspace(0.0, 1.0, len(colours) + 1)
    return [[float(edges[k + end]), colour] for k, colour in enumerate(colours) for end in (0, 1)]


def packed_curves(
    histories: dict[str, History], stresses: dict[str, xr.Dataset]
) -> tuple[dict[str, object], str]:
    """Return the time histories of runs by name for the page, and a sentence on left-out times."""
    at_first = {
        name: next(run.every(run.time.size).parts(stresses.get(name))) for name, run in histories.items()
    }
    offered = {name: figures.history_series(*pair) for name, pair in at_first.items()}
    count = sum(curve.values.size for series in offered.values() for curve in series.values())
    points = int(np.clip(SERIES_BYTES / BYTES_A_POINT / max(count, 1), LEAST_POINTS, MOST_POINTS))
    cases = {}
    for name, history in histories.items():
        pieces: dict[str, Kept] = {label: {} for label in offered[name]}
        start = 0
        width = bin_width(history.time.size, points)
        for part, stress in history.parts(stresses.get(name)):
            for label, series in figures.history_series(part, stress).items():
                whole = series.values.transpose("item", "axis", "time").values
                for slot in np.ndindex(whole.shape[:2]):
                    few = thinned(whole[slot], width)
                    pieces[label].setdefault(slot, []).append((start + few, whole[slot][few]))
            start += part.time.size
        kind = "u2" if start < 2**16 else "u4"
        phases = common_phases(history)
        cases[name] = {
            "time": packed(history.time.values, "f4"),
            "index": kind,
            "quantities": [
                _packed_series(quantity, pieces[label], kind) for label, quantity in offered[name].items()
            ],
            "phases": [phase._asdict() for phase in phases] if len(phases) > 1 else [],
        }
    most = max((run.time.size for run in histories.values()), default=0)
    said = (
        f"Of the {most} stored times each curve keeps the least and the greatest value in every one of "
        f"{points // 2 - 1} equal parts of the run, so that no extreme is lost; times between "
        "these are left out."
    )
    labels = {label for series in offered.values() for label in series}
    first = [next(choice for choice in each if choice in labels) for each in FIRST] if cases else []
    return {"cases": cases, "first": first}, said if most > points else "Every stored time is drawn."


def bin_width(times: int, points: int) -> int:
    """Return the number of successive times in a bin for a series of at most about `points` points."""
    return 1 if times <= points else -(-times // max(1, points // 2 - 1))


def thinned(values: np.ndarray, width: int) -> np.ndarray:
    """Return the indices to keep of a series (n,): its ends, and the extremes of bins of `width` values."""
    n = len(values)
    padded = np.concatenate((values, np.full(-n % width, values[-1]))).reshape(-1, width)
    starts = width * np.arange(len(padded))
    indices = np.concatenate(([0, n - 1], starts + padded.argmin(axis=1), starts + padded.argmax(axis=1)))
    return np.unique(np.minimum(indices, n - 1))


def _packed_series(series: figures.Series, stored: Kept, kind: str) -> dict[str, object]:
    """Return a quantity for the page: names, and packed time indices and values for each item and axis."""
    rows: list[list[list[str]]] = [[[] for _ in series.values.axis] for _ in series.items]
    for (item, axis), parts in stored.items():
        few, values = (np.concatenate(pieces) for pieces in zip(*parts, strict=True))
        rows[item][axis] = [packed(few, kind), packed(values, "f4")]
    return {
        **_as_they_are(series, "group", "label", "unit", "items"),
        "floor": style.negligible(series.unit),
        "axes": [str(axis) for axis in series.values.axis.values],
        "drawn": _drawn(series),
        "series": rows,
    }


def _drawn(series: figures.Series) -> list[int]:
    """Return the numbers of the items that are drawn at first, evenly spread."""
    matches = (re.search(r"\d+", item) for item in series.items)
    numbers = sorted({int(match[0]) for match in matches if match})
    places = np.linspace(0, len(numbers) - 1, min(FEW, len(numbers)))
    return [numbers[round(place)] for place in places]
