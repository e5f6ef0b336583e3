"""Arrays and scenes as a page's scripts take them.

Arrays are base64 of little-endian numbers. What only has to be seen is 16-bit steps of its
greatest magnitude.
"""

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Scene, Solid
from exudyn_crawler.views.style import colour_map


def packed(array: NDArray, kind: str) -> str:
    """Base64 of an array as little-endian numbers of a kind such as "f4" or "u2"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()).decode("ascii")


class SceneArrays:
    """Arrays of the scenes of a page; what several solids have in common is there once."""

    def __init__(self) -> None:
        self.packed: list[dict[str, Any]] = []
        self._numbers: dict[int, int] = {}
        self._kept: list[NDArray] = []

    def add(self, array: NDArray, kind: str = "f4", rows: int = 1) -> int:
        """Number of an array; `rows` are the times that it holds."""
        if id(array) not in self._numbers:
            self._numbers[id(array)] = len(self.packed)
            self._kept.append(array)
            self.packed.append({"kind": kind, "data": packed(array, kind), "rows": rows})
        return self._numbers[id(array)]

    def add_over_time(self, array: NDArray | None, stepped: bool = False) -> int | None:
        """Same of an array (times, ...), in steps if it is finite; None of none."""
        if array is None:
            return None
        if not stepped or not np.isfinite(array).all():
            return self.add(array, rows=len(array))
        kind, most = ("u2", 65535) if array.min() >= 0.0 else ("i2", 32767)
        step = max(float(np.abs(array).max()), 1e-12) / most
        number = self.add(np.rint(array / step), kind, len(array))
        self.packed[number]["step"] = step
        return number


def packed_scene(
    scene: Scene, arrays: SceneArrays, window: Sequence[Sequence[float]] | None = None, first: int = 0
) -> dict[str, Any]:
    """Scene for a view in 3D.

    Parameters
    ----------
    window : sequence of (float, float), optional
        Least and greatest x, y and z to be shown, m; all that is drawn, if not given.
    first : int
        Index of the time that is shown first.
    """
    return {
        "titles": scene.titles,
        "first": first,
        "window": window,
        "solids": [_packed_solid(one, arrays) for one in scene.solids],
        "arrows": [_packed_arrows(one, arrays) for one in scene.arrows],
    }


def _packed_solid(solid: Solid, arrays: SceneArrays) -> dict[str, Any]:
    return {
        "name": solid.name,
        "colour": solid.colour,
        "opacity": solid.opacity,
        "labels": solid.labels,
        "notes": solid.notes,
        "larger": solid.larger,
        "points": arrays.add(solid.points),
        "triangles": arrays.add(solid.triangles, "u4"),
        "nodes": None if solid.nodes is None else arrays.add(solid.nodes, "u4"),
        "origin": arrays.add_over_time(solid.origin),
        "turn": arrays.add_over_time(solid.turn),
        "lift": arrays.add_over_time(solid.lift, stepped=True),
        "bend": arrays.add_over_time(solid.bend, stepped=True),
        "colourings": [_packed_colouring(one, arrays) for one in solid.colourings],
    }


def _packed_colouring(colouring: Colouring, arrays: SceneArrays) -> dict[str, Any]:
    return {
        "name": colouring.name,
        "title": colouring.title,
        "low": float(colouring.low),
        "high": float(colouring.high),
        "colours": colour_scale(colouring.colours),
        "words": colouring.words,
        "decades": colouring.decades,
        "nodal": colouring.values.ndim == 3,
        "values": arrays.add_over_time(colouring.values, stepped=not colouring.words),
    }


def _packed_arrows(arrows: Arrows, arrays: SceneArrays) -> dict[str, Any]:
    return {
        "name": arrows.name,
        "colour": arrows.colour,
        "scale": arrows.scale,
        "solid": arrows.solid,
        "through": arrows.through,
        "heads": arrays.add_over_time(arrows.heads),
        "forces": arrays.add_over_time(arrows.forces),
    }


def colour_scale(colours: str | tuple[str, ...]) -> list[list[Any]]:
    """Colours as Plotly takes them: places from 0 to 1, and a colour at each, of which some are doubled."""
    if isinstance(colours, str):
        return [[float(at), to_hex(colour_map(colours)(at))] for at in np.linspace(0.0, 1.0, 17)]
    edges = np.linspace(0.0, 1.0, len(colours) + 1)
    return [[float(edges[k + end]), colour] for k, colour in enumerate(colours) for end in (0, 1)]
