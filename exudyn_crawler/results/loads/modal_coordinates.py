"""Stresses of flexible shoes from a history: the whole modal basis, of which the run integrated a part.

The run integrates the constraint modes and the lowest fixed-interface modes; the other fixed-interface modes
lie far above what the track excites and follow their loads without inertia. Craig-Bampton bases nest, so what
was integrated is a subspace of the whole, and the mode-acceleration method (R. R. Craig, Structural Dynamics,
1981, ch. 15) gives the whole: its elastic forces are the loads less the inertia and damping of that subspace.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.drive_point import drive_point
from exudyn_crawler.model.flexible_shoes import (
    integrated_reduction,
    weights_a_metre,
    whole_reduction,
)
from exudyn_crawler.model.rail_rows import RailRows, rail_rows, rows_along
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import (
    Action,
    AtDrivePoint,
    AtInterface,
    OnFrame,
    OnRail,
    OverMass,
    OverRectangle,
    OverSurface,
    actions,
)
from fem import ReducedBody
from fem.patches import Underside, integrate_underside, rectangle_loads


@dataclass(frozen=True)
class StressBasis:
    """Whole modal basis of a flexible shoe and how the integrated one lies in it; m of M modes.

    Attributes
    ----------
    whole : ReducedBody
        With M modes.
    inside : array (M, m)
        Whole coordinates of each integrated mode.
    underside : Underside
        Integrated underside of the whole basis.
    pulled : array (3, M)
        Displacement of the drive's point, on a front shoe, by each mode.
    rails : RailRows
        Displacements of the rails under a side frame's rollers; of no lines without one.
    """

    whole: ReducedBody
    inside: NDArray
    underside: Underside
    pulled: NDArray
    rails: RailRows


def stress_basis(history: History) -> StressBasis:
    """Modes that the stress of a history's flexible shoes is made of, and where the integrated ones lie.

    Raises
    ------
    ValueError
        If the history has no flexible shoes.
    """
    if history.case.flexible is None:
        raise ValueError("the history has no flexible shoes")
    whole = whole_reduction(history.case).body
    under = whole.mesh.nodes_of("underside")
    return StressBasis(
        whole=whole,
        inside=integrated_reduction(history.case).inside,
        underside=integrate_underside(
            whole.nodes[under, :2], whole.modes[under], history.case.shoe.footprint
        ),
        pulled=drive_point(history.case, whole).rows,
        rails=rail_rows(whole, history.case),
    )


def modal_loads(
    history: History, basis: StressBasis, shoe: int, acting: Sequence[Action] | None = None
) -> NDArray:
    """Loads of all modes of a flexible shoe by all that acts on it: array (times, M), N kg^-0.5.

    `acting` are its `actions`, if they are known already.
    """
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    loads = np.zeros((len(frames), len(basis.whole.frequencies)))
    for action in actions(history, shoe) if acting is None else acting:
        _add_modal_loads(loads, action, frames, basis)
    return loads


def coordinates_by_load(history: History, basis: StressBasis, shoe: int) -> dict[str, NDArray]:
    """Coordinates of all modes over time by what makes them: arrays (times, M), kg^0.5 m.

    Each kind of action gives those of its static answer; "inertia", that of the integrated modes with their
    damping, gives the rest of `whole_coordinates`, whose errors this has too. What moves no mode is left out.
    """
    whole = whole_coordinates(history, basis, shoe)
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    loads: dict[str, NDArray] = {}
    for action in actions(history, shoe):
        if action.kind not in loads:
            loads[action.kind] = np.zeros_like(whole)
        _add_modal_loads(loads[action.kind], action, frames, basis)
    stiffness = (2.0 * np.pi * basis.whole.frequencies) ** 2
    found = {kind: values / stiffness for kind, values in loads.items() if values.any()}
    return found | {"inertia": whole - sum(found.values())}


def _add_modal_loads(loads: NDArray, action: Action, frames: NDArray, basis: StressBasis) -> None:
    """Add the modal loads of one action to `loads` (times, M)."""
    whole = basis.whole
    force = in_body(frames, action.force)
    match action.entry:
        case AtInterface(name):
            number = [interface.name for interface in whole.interfaces].index(name)
            loads += np.hstack((force, in_body(frames, action.moment))) @ whole.pilots[number]
        case OverSurface(name, shift):
            weights = whole.weights(name)
            loads += force @ whole.mean_rows(weights)
            if shift is not None:
                more = np.tensordot(weights_a_metre(weights, whole.nodes), whole.modes, axes=1)
                loads += (shift[:, None] * force) @ more
        case OverRectangle(low, high, pressed):
            spread = rectangle_loads(basis.underside, force[pressed], low[pressed], high[pressed])
            loads[pressed] += spread
        case AtDrivePoint():
            loads += force @ basis.pulled
        case OnRail(line, x):
            loads += np.einsum("tc,tck->tk", force[:, [0, 2]], rows_along(basis.rails, line, x))
        case OnFrame() | OverMass():
            pass


def in_body(frames: NDArray, vectors: NDArray) -> NDArray:
    """Global vectors (times, 3) in the axes of a shoe."""
    return np.einsum("tji,tj->ti", frames, vectors)


def whole_coordinates(history: History, basis: StressBasis, shoe: int) -> NDArray:
    """Coordinates of all modes over time: array (times, M), kg^0.5 m.

    With loads f and the integrated part's own stiffness k and coordinates q, both in the whole basis through
    its columns P, the elastic forces of all modes are ``f - P P^T f + P k q``: what P cannot move answers its
    loads at once, what it can has the elastic forces that were integrated.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    return coordinates_and_momentum(history, basis, shoe)[0]


def coordinates_and_momentum(
    history: History, basis: StressBasis, shoe: int, acting: Sequence[Action] | None = None
) -> tuple[NDArray, NDArray]:
    """Coordinates as of `whole_coordinates` and, (times, m) in N kg^-0.5, momentum ``k q - P^T f``.

    `acting` are the shoe's `actions`, if they are known already.
    """
    flexible = history.case.flexible
    if flexible is None or shoe not in flexible.shoes:
        raise ValueError(f"shoe {shoe} is not flexible in this history")
    inside = basis.inside
    q = history.modal_coordinate.sel(flexible_shoe=shoe).values
    own = (2.0 * np.pi * history.frequency.values) ** 2
    loads = modal_loads(history, basis, shoe, acting)
    momentum = q * own - loads @ inside
    elastic = loads + momentum @ inside.T
    return elastic / (2.0 * np.pi * basis.whole.frequencies) ** 2, momentum
