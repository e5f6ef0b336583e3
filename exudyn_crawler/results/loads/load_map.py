"""All that acts on a flexible shoe as coordinates of its unit loads, and what follows from these.

Modal loads, coordinates of static fields and nodal forces are products with these coordinates; an action that
enters in a new way is a case of `shares_of`.

The run integrates the constraint modes and the lowest fixed-interface modes; the other fixed-interface modes
lie far above what the track excites and follow their loads without inertia. Craig-Bampton bases nest, so what
was integrated is a subspace of the whole, and the mode-acceleration method (R. R. Craig, Structural Dynamics,
1981, ch. 15) gives the whole: its elastic forces are the loads less the inertia and damping of that subspace.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, hstack

from exudyn_crawler.ground.rotations import rotation_matrices
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
from exudyn_crawler.results.loads.unit_loads import (
    DRIVE,
    GROUND,
    INERTIA,
    JOINTS,
    MACHINE,
    RAILS,
    ShoeUnitLoads,
    unit_loads,
)

Shares = tuple[str, NDArray, NDArray]
"""Family of unit loads, numbers in it (times or 1, j), and the shares of these in a force (times or 1, j)."""


def shares_of(units: ShoeUnitLoads, action: Action) -> Shares | None:
    """Unit loads that share in the force of an action, and in its moment if they are joints'.

    None for what bends no shoe.
    """
    joints = [interface.name for interface in units.whole.interfaces]
    match action.entry:
        case AtInterface(name):
            return JOINTS, np.array([[joints.index(name)]]), np.ones((1, 1))
        case OverSurface(_, shift):
            metres = np.zeros(1) if shift is None else shift
            return MACHINE, np.array([[0, 1]]), np.column_stack((np.ones_like(metres), metres))
        case OverRectangle(low, high, pressed):
            points, shares = units.underside.rectangle_mean(low, high)
            return GROUND, points, shares * pressed[:, None]
        case OnRail(line, x) if units.strips is not None:
            return RAILS, *units.strips.shares(line, x)
        case AtDrivePoint() if DRIVE in units.spread:
            return DRIVE, np.zeros((1, 1), dtype=int), np.ones((1, 1))
        case AtDrivePoint() if action.where == "front pins":
            pins = [number for number, name in enumerate(joints) if name.startswith("front")]
            return JOINTS, np.array([pins]), np.full((1, len(pins)), 1.0 / len(pins))
        case AtDrivePoint() | OnFrame() | OverMass():
            return None
    raise TypeError(f"no unit loads for an action that enters by {action.entry}")


def coordinates(units: ShoeUnitLoads, action: Action, frames: NDArray) -> csr_array:
    """Coordinates (times, k) of the unit loads that make an action; of what bends no shoe there are none.

    Parameters
    ----------
    frames : array (times, 3, 3)
        Axes of the shoe, its columns global.
    """
    shared = shares_of(units, action)
    if shared is None:
        return csr_array((len(frames), units.size))
    family, numbers, shares = shared
    vectors = (action.force, action.moment) if family == JOINTS else (action.force,)
    in_body = np.concatenate([np.einsum("tji,tj->ti", frames, one) for one in vectors], axis=1)
    values = shares[..., None] * in_body[:, None]
    times, loads, components = values.shape
    columns = units.families[family].start + numbers[..., None] * components + np.arange(components)
    rows = np.arange(times + 1) * loads * components
    places = np.broadcast_to(columns, values.shape).flatten()
    found = csr_array((values.ravel(), places, rows), shape=(times, units.size))
    found.eliminate_zeros()
    return found


def loads_by_kind(history: History, shoe: int) -> dict[str, csr_array]:
    """Coordinates (times, k) of the unit loads of a flexible shoe by kind of action, as of `Action.kind`.

    "inertia" is the momentum of the integrated modes with their damping, ``k q - P^T f``: with the loads f of
    all modes, stiffness k and coordinates q of the integrated ones and their columns P in the whole basis.
    The elastic forces of all modes are then ``f - P P^T f + P k q``: what P cannot move answers its loads at
    once, what it can has the elastic forces that were integrated.

    Parameters
    ----------
    shoe : int
        Number of a flexible shoe.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    check_flexible(history, shoe)
    units = unit_loads(history.case)
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    by_kind: dict[str, csr_array] = {}
    for action in actions(history, shoe):
        loads = coordinates(units, action, frames)
        if loads.nnz:
            by_kind[action.kind] = by_kind[action.kind] + loads if action.kind in by_kind else loads
    q = history.modal_coordinate.sel(flexible_shoe=shoe).values
    elastic = q * (2.0 * np.pi * history.frequency.values) ** 2
    acting = sum(by_kind.values(), start=csr_array((len(q), units.size)))
    momentum = elastic - acting @ units.work @ units.integrated.inside
    before = csr_array((len(q), units.families[INERTIA].start))
    return by_kind | {INERTIA: hstack((before, csr_array(momentum)), format="csr")}


def check_flexible(history: History, shoe: int) -> None:
    """Refuse a shoe that is not a flexible one of a history.

    Raises
    ------
    ValueError
    """
    flexible = history.case.flexible
    there = [] if flexible is None else list(flexible.shoes)
    if shoe not in there:
        raise ValueError(f"shoe must be a flexible one of the history, of {there}, got {shoe}")
