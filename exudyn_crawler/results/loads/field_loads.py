"""Loads of a history as coordinates of static fields: all that acts on a flexible shoe, by family."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.load_places import (
    DRIVE,
    GROUND,
    INERTIA,
    JOINTS,
    MACHINE,
    RAILS,
    ground_grid,
    rail_loads,
    rail_stations,
)
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
)
from exudyn_crawler.results.loads.modal_coordinates import in_body
from fem import PressureGrid, Shapes, StaticFields, Stations


class _Families(dict[str, NDArray]):
    """Loads (times, coordinates) by family, of which one that is asked for first is zero."""

    def __init__(self, times: int, counts: Mapping[str, int]) -> None:
        self.times, self.counts = times, counts

    def __missing__(self, name: str) -> NDArray:
        self[name] = np.zeros((self.times, self.counts[name]))
        return self[name]


def field_loads(fields: StaticFields, by_kind: Mapping[str, Mapping[str, NDArray]]) -> NDArray:
    """Coordinates (times, loads) of static fields by all that acts on a flexible shoe.

    Parameters
    ----------
    fields : StaticFields
        Of `model.load_places`.
    by_kind : mapping
        Of `loads_by_kind`.
    """
    whole: dict[str, NDArray] = {}
    for families in by_kind.values():
        for name, values in families.items():
            whole[name] = whole[name] + values if name in whole else values
    return fields.coordinates(whole)


def loads_by_kind(
    history: History,
    fields: StaticFields,
    body: Shapes,
    momentum: NDArray,
    shoe: int,
    acting: Sequence[Action],
) -> dict[str, Mapping[str, NDArray]]:
    """Loads on a flexible shoe by kind of action and by family of static fields: arrays (times, coordinates).

    "inertia" is the momentum of the integrated modes; other kinds are those of `Action.kind`.

    Parameters
    ----------
    fields : StaticFields
        Of `model.load_places`.
    body : Shapes
        Mesh and joints of the shoe.
    momentum : array (times, modes)
        Of the integrated modes, as of `coordinates_and_momentum`.
    shoe : int
        Number of a flexible shoe.
    acting : sequence of Action
        Its `actions`.
    """
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    times = len(frames)
    names = [interface.name for interface in body.interfaces]
    grid = ground_grid(body.mesh)
    undercarriage = history.case.undercarriage
    rails = [] if undercarriage is None else rail_stations(body.mesh)
    found: dict[str, _Families] = {INERTIA: _Families(times, fields.families)}
    found[INERTIA][INERTIA] += momentum
    for action in acting:
        loads = found.setdefault(action.kind, _Families(times, fields.families))
        if isinstance(action.entry, OnRail) and undercarriage is not None:
            rail = action.entry.line // undercarriage.strips
            force = in_body(frames, action.force)
            loads[RAILS] += _on_rail(rails, rail, force, action.entry.x).reshape(times, -1)
        else:
            _add(loads, action, frames, names, grid)
    return {kind: loads for kind, loads in found.items() if loads}


def _on_rail(rails: list[Stations], rail: int, force: NDArray, x: NDArray) -> NDArray:
    """Coordinates (times, stations, 3) of a strip of a tread.

    It presses on the middle of its rail: what it turns that by about its length is left out. Over a gap it
    lies on the rail's very end.
    """
    level = rails[rail].rectangle
    return rail_loads(rails, rail, force, np.clip(x, level.low[0], level.high[0]))


def _add(loads: _Families, action: Action, frames: NDArray, joints: list[str], grid: PressureGrid) -> None:
    """Add the coordinates of one action to those of its family (times, ...); what bends no shoe has none."""
    force = in_body(frames, action.force)
    times = len(force)
    match action.entry:
        case AtInterface(name):
            both = np.hstack((force, in_body(frames, action.moment)))
            loads[JOINTS].reshape(times, -1, 6)[:, joints.index(name)] += both
        case OverSurface(_, shift):
            shifted = np.zeros(times) if shift is None else shift
            loads[MACHINE] += np.hstack((force, shifted[:, None] * force))
        case OverRectangle(low, high, pressed):
            spread = grid.coordinates(force[pressed], low[pressed], high[pressed])
            loads[GROUND][pressed] += spread.reshape(len(spread), loads.counts[GROUND])
        case AtDrivePoint() if DRIVE in loads.counts:
            loads[DRIVE] += force
        case AtDrivePoint():
            pins = [number for number, name in enumerate(joints) if name.startswith("front")]
            if action.where == "front pins":
                loads[JOINTS].reshape(times, -1, 6)[:, pins, :3] += force[:, None] / len(pins)
        case OnFrame() | OverMass():
            pass
