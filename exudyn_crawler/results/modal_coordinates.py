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
from exudyn_crawler.model.drive_point import drive_point, pulled_node
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model, whole_basis
from exudyn_crawler.results.history import History
from fem import ReducedBody
from fem.patches import Underside, integrate_underside, mean_rows


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
    """

    whole: ReducedBody
    inside: NDArray
    underside: Underside


def stress_basis(history: History) -> StressBasis:
    """Reduce the shoe of a history again, with all the modes that its stress is to have.

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
    pulled = pulled_node(history.case, body.mesh)
    whole = whole_basis(flexible, history.case.track, flexible.recovered_modes, pulled)
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
    )


def modal_loads(history: History, basis: StressBasis, shoe: int) -> NDArray:
    """Loads of all modes of a flexible shoe: pins, contact, machine load and drive; array (times, M)."""
    case, flexible = history.case, history.case.flexible
    assert flexible is not None
    whole = basis.whole
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    loads = np.zeros((len(frames), len(whole.frequencies)))
    sides = [str(side) for side in history.pin.values]
    pilots = {interface.name: rows for interface, rows in zip(whole.interfaces, whole.pilots, strict=True)}
    # the link ahead acts on its rear shoe as stored, the link behind with the opposite
    for end, joint, sign in (("front", shoe, 1.0), ("rear", shoe - 1, -1.0)):
        if not 1 <= joint < case.track.shoe_count:
            continue
        for side in sides:
            chosen = {"joint": joint, "pin": side}
            force = np.nan_to_num(history.pin_force.sel(chosen).values)
            torque = np.nan_to_num(history.pin_torque.sel(chosen).values)
            wrench = np.hstack((_in_body(frames, force), _in_body(frames, torque)))
            loads += sign * wrench @ pilots[f"{end} {side}"]

    machine = np.zeros((len(frames), 3))
    machine[:, 2] = -history.shoe_load.sel(shoe=shoe).values
    loads += _in_body(frames, machine) @ whole.mean_rows(whole.weights(flexible.load_surface))
    if shoe == case.track.shoe_count:
        drive = np.zeros((len(frames), 3))
        drive[:, 0] = history.drive_force.values
        loads += _in_body(frames, drive) @ drive_point(case, whole).rows

    rows = np.zeros((3, loads.shape[1]))
    terrain = case.terrain
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    footprint = case.shoe.footprint
    under = basis.underside
    # where the underside's own x = y = 0 lies, and how much its axes are foreshortened from above
    origin = history.position.sel(shoe=shoe).values[:, :2] + footprint[4] * frames[:, :2, 2]
    shortened = np.stack((frames[:, 0, 0], frames[:, 1, 1]), axis=-1)
    for index in np.flatnonzero(history.contact_shoe.values == shoe):
        center = terrain.centers[int(history.contact_unit[index]) - 1, :2]
        force = (history.normal_force + history.friction_force).isel(contact=index).values
        body_force = _in_body(frames, force)
        low = np.maximum((center - half - origin) / shortened, footprint[[0, 2]])
        high = np.minimum((center + half - origin) / shortened, footprint[[1, 3]])
        for time in np.flatnonzero(history.area.isel(contact=index).values > 0.0):
            (x0, y0), (x1, y1) = low[time], high[time]
            mean_rows(under.corner, under.cell, under.integral, x0, x1, y0, y1, rows)
            loads[time] += body_force[time] @ rows
    return loads


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
