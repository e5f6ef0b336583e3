"""Stresses of flexible shoes from a history: the whole modal basis, of which the run integrated a part.

The run integrates the constraint modes and the lowest fixed-interface modes; the other fixed-interface modes
lie far above what the track excites and follow their loads without inertia. Craig-Bampton bases nest, so what
was integrated is a subspace of the whole, and the mode-acceleration method (R. R. Craig, Structural Dynamics,
1981, ch. 15) gives the whole: its elastic forces are the loads less the inertia and damping of that subspace.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.drive_point import drive_point
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model, side_weights, whole_reduction
from exudyn_crawler.model.rail_rows import RailRows, rail_rows, rows_along
from exudyn_crawler.results.actions import (
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
from exudyn_crawler.results.history import History
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
    flexible = history.case.flexible
    if flexible is None:
        raise ValueError("the history has no flexible shoes")
    floating = floating_shoe(history.case)
    body, _ = shoe_model(flexible, history.case.track)
    whole = whole_reduction(history.case).body
    count = len(whole.frequencies)
    modes = whole.modes.reshape(-1, count)
    mass = body.mass_matrix
    inside = modes.T @ (mass @ floating.reduced.modes.reshape(len(modes), -1))
    under = body.mesh.nodes_of("underside")
    return StressBasis(
        whole=whole,
        inside=inside,
        underside=integrate_underside(
            body.mesh.nodes[under, :2], whole.modes[under], history.case.shoe.footprint
        ),
        pulled=drive_point(history.case, whole).rows,
        rails=rail_rows(whole, history.case),
    )


def modal_loads(history: History, basis: StressBasis, shoe: int) -> NDArray:
    """Loads of all modes of a flexible shoe by all that acts on it: array (times, M), N kg^-0.5."""
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    loads = np.zeros((len(frames), len(basis.whole.frequencies)))
    for action in actions(history, shoe):
        _add_modal_loads(loads, action, frames, basis)
    return loads


def _add_modal_loads(loads: NDArray, action: Action, frames: NDArray, basis: StressBasis) -> None:
    """Add the modal loads of one action to `loads` (times, M)."""
    whole = basis.whole
    force = _in_body(frames, action.force)
    match action.entry:
        case AtInterface(name):
            number = [interface.name for interface in whole.interfaces].index(name)
            loads += np.hstack((force, _in_body(frames, action.moment))) @ whole.pilots[number]
        case OverSurface(name, shift):
            weights = whole.weights(name)
            loads += force @ whole.mean_rows(weights)
            if shift is not None:
                loads += (shift[:, None] * force) @ _rows_a_metre(whole, weights)
        case OverRectangle(low, high, pressed):
            spread = rectangle_loads(basis.underside, force[pressed], low[pressed], high[pressed])
            loads[pressed] += spread
        case AtDrivePoint():
            loads += force @ basis.pulled
        case OnRail(line, x):
            loads += np.einsum("tc,tck->tk", force[:, [0, 2]], rows_along(basis.rails, line, x))
        case OnFrame() | OverMass():
            pass


def _rows_a_metre(whole: ReducedBody, weights: NDArray) -> NDArray:
    """Displacement rows (3, M) that a load over a surface has more for each metre of shift to the left."""
    right, left = side_weights(weights, whole.nodes)
    apart = left @ whole.nodes[:, 1] / left.sum() - right @ whole.nodes[:, 1] / right.sum()
    return (whole.mean_rows(left) - whole.mean_rows(right)) / apart


def _in_body(frames: NDArray, vectors: NDArray) -> NDArray:
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
    flexible = history.case.flexible
    if flexible is None or shoe not in flexible.shoes:
        raise ValueError(f"shoe {shoe} is not flexible in this history")
    inside = basis.inside
    q = history.modal_coordinate.sel(flexible_shoe=shoe).values
    own = (2.0 * np.pi * history.frequency.values) ** 2
    loads = modal_loads(history, basis, shoe)
    elastic = loads + (q * own - loads @ inside) @ inside.T
    return elastic / (2.0 * np.pi * basis.whole.frequencies) ** 2
