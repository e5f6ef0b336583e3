"""Small items that several builders of the multibody system share."""

from collections.abc import Callable
from functools import lru_cache

from numpy.typing import NDArray

from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.state import BODY_COORDINATES


def coordinate_marker(mbs: "exu.MainSystem", node: int, coordinate: int) -> int:
    """Marker of one coordinate of a node."""
    return mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def hold(mbs: "exu.MainSystem", fixed: int, node: int, coordinate: int, name: str) -> int:
    """Keep one coordinate of a node where it is; messages say along which axis or about which."""
    return mbs.AddObject(
        items.ObjectConnectorCoordinate(
            name=f"{name} ({BODY_COORDINATES[coordinate]})",
            markerNumbers=[fixed, coordinate_marker(mbs, node, coordinate)],
        )
    )


def at_time(function: Callable[[float], NDArray]) -> Callable[[float], float]:
    """Function of time as a number, remembered: a step asks for the same time again and again."""

    @lru_cache(maxsize=4)
    def at_time(time: float) -> float:
        return float(function(time))

    return at_time
