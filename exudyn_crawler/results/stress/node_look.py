"""A look at one node of a flexible shoe: its stress over a run, from a history in memory or in a file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.results.history.case_in_file import case_in_file
from exudyn_crawler.results.loads.kept_loads import kept_loads
from fem.keeping import note_used
from fem.one_node import Places, places_in, unit_stress, unit_stress_in
from fem.stress import principal, von_mises

if TYPE_CHECKING:
    from exudyn_crawler.results.history.history import History

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
MEGA = 1e6

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class NodeLook:
    """Stress at a node over a run.

    Attributes
    ----------
    shoe, node : int
        Numbers; nodes count from 0, as in tables of hot spots.
    place : array (3,)
        Of the node, m in the shoe's frame.
    distance : float
        m, of the node from the place that was asked for.
    in_spider : bool
        Whether a joint's rigid spider holds the node, so that it shows the stress beside a rigid ring.
    time : array (times,)
        s
    stress : array (times, 6)
        Pa, in the shoe's axes, in the order of `COMPONENTS`.
    """

    shoe: int
    node: int
    place: NDArray
    distance: float
    in_spider: bool
    time: NDArray
    stress: NDArray

    @property
    def principal(self) -> NDArray:
        """Principal stresses (times, 3) in Pa, from the greatest down."""
        return principal(self.stress)[:, ::-1]

    @property
    def von_mises(self) -> NDArray:
        """Von Mises stress (times,) in Pa."""
        return von_mises(self.stress)

    def columns(self) -> dict[str, NDArray]:
        """Columns of a table by name: a row a stored time, stresses in MPa."""
        named = {"time in s": self.time}
        named |= {f"{name} in MPa": self.stress[:, k] / MEGA for k, name in enumerate(COMPONENTS)}
        named |= {f"principal {k + 1} in MPa": one / MEGA for k, one in enumerate(self.principal.T)}
        return named | {"von Mises in MPa": self.von_mises / MEGA}


def look(history: "History", shoe: int, near: ArrayLike | None = None, node: int | None = None) -> NodeLook:
    """Look at a node of a history in memory; parameters and errors are those of `node_stress`."""
    from exudyn_crawler.results.stress.stress_columns import acting_loads

    place = _checked(history.case, shoe, near, node)
    places = _places(history.case)
    number = _chosen(places, place, node)
    stress = acting_loads(history, shoe) @ _unit_stress(history.case, number)
    return _looked_at(shoe, number, places, place, history.time.values, stress)


def look_into(path: Path, shoe: int, near: ArrayLike | None = None, node: int | None = None) -> NodeLook:
    """Look at a node of a history in a file; parameters and errors are those of `node_stress`.

    The first look at a shoe keeps its loads, and a further one reads no more than these and the rows of the
    node.
    """
    case = case_in_file(path)
    place = _checked(case, shoe, near, node)
    kept = kept_loads(path, case, shoe)
    places = _read_or_made(lambda: places_in(kept.reduction), lambda: _places(case))
    number = _chosen(places, place, node)
    unit = _read_or_made(
        lambda: unit_stress_in(kept.reduction, kept.fields, number), lambda: _unit_stress(case, number)
    )
    for used in filter(None, (kept.reduction, kept.fields)):
        note_used(used)
    return _looked_at(shoe, number, places, place, kept.time, kept.loads @ unit)


def _checked(case: Case, shoe: int, near: ArrayLike | None, node: int | None) -> NDArray | None:
    """Place (3,) in m that is asked for; None where a node is. Refuses a shoe that is not flexible."""
    there = [] if case.flexible is None else list(case.flexible.shoes)
    if shoe not in there:
        raise ValueError(f"shoe must be a flexible one of the history, of {there}, got {shoe}")
    if (near is None) == (node is None):
        raise ValueError("near or node must be given, got neither or both")
    place = None if near is None else np.asarray(near, dtype=float)
    if place is not None and (place.shape != (3,) or not np.isfinite(place).all()):
        raise ValueError(f"near must be three finite numbers in m, got {near!r}")
    return place


def _chosen(places: Places, place: NDArray | None, node: int | None) -> int:
    """Number of the node that is nearest to a place, or the one given."""
    if place is not None:
        distances = np.linalg.norm(places.nodes - place, axis=1)
        number = int(distances.argmin())
        if distances[number] > np.ptp(places.nodes, axis=0).max():
            raise ValueError(
                f"near must be at the shoe, in m in its frame, got {place.tolist()}, "
                f"{distances[number]:.4g} m from the nearest node"
            )
        return number
    if node is None or not 0 <= node < len(places.nodes):
        raise ValueError(f"node must be in 0..{len(places.nodes) - 1}, got {node}")
    return node


def _read_or_made(read: Callable[[], Found], make: Callable[[], Found]) -> Found:
    """What a kept file says, or what is made anew where it is gone or broken."""
    try:
        return read()
    except (FileNotFoundError, ValueError):
        return make()


def _places(case: Case) -> Places:
    from exudyn_crawler.model.flexible_shoes import whole_reduction

    whole = whole_reduction(case).body
    return Places(whole.nodes, whole.spider_nodes)


def _unit_stress(case: Case, node: int) -> NDArray:
    from exudyn_crawler.model.flexible_shoes import whole_reduction
    from exudyn_crawler.results.stress.stress_columns import fields_of

    kept = fields_of(case)
    return unit_stress(whole_reduction(case).body, None if kept is None else kept.fields, node)


def _looked_at(
    shoe: int, node: int, places: Places, place: NDArray | None, time: NDArray, stress: NDArray
) -> NodeLook:
    own = places.nodes[node]
    distance = 0.0 if place is None else float(np.linalg.norm(own - place))
    return NodeLook(shoe, node, own, distance, bool(np.isin(node, places.spider_nodes)), time, stress)
