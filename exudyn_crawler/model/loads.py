"""Machine loads on the shoes of the multibody system."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import at_time
from exudyn_crawler.model.shoes import ShoeBody


def add_loads(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody], static: bool = False) -> None:
    """Machine load on the top face of every shoe, along gravity.

    One that shifts to a side acts at two points that stay where they are, each with its share.

    Parameters
    ----------
    static : bool
        Keep the loads as they are at t = 0: Exudyn's static solver asks for those at 1 s.
    """
    down, shift = case.terrain.down, case.loads.side_shift
    for number, shoe in enumerate(shoes, start=1):
        profile = case.loads.profile(number)
        changes = not static and max(len({*profile.values}), len({*shift.values})) > 1
        if any(shift.values):
            for marker, side in zip(shoe.sides, (-1.0, 1.0), strict=True):
                _add_load(mbs, marker, _part(profile, shift, side / shoe.reach), down, changes)
        else:
            _add_load(mbs, shoe.top, profile.value, down, changes)


def _part(profile: StepProfile, shift: StepProfile, side: float) -> Callable[[float], NDArray]:
    """Part of a load at a point beside the load point; `side` is one over its y there (m)."""
    return lambda time: 0.5 * profile.value(time) * (1.0 + side * shift.value(time))


def _add_load(
    mbs: "exu.MainSystem", marker: int, size: Callable[[float], NDArray], down: NDArray, changes: bool
) -> None:
    load = items.LoadForceVector(markerNumber=marker, loadVector=(float(size(0.0)) * down).tolist())
    if changes:
        load.loadVectorUserFunction = _downward(size, down)
    mbs.AddLoad(load)


def grips(case: Case, masses: NDArray) -> tuple[NDArray, NDArray]:
    """Friction that holds each shoe on a slope at rest, where the laws, which need slip, have none.

    It acts at the underside, half as deep in the ground as the shoe has settled.

    Parameters
    ----------
    masses : array (shoes,)
        kg.

    Returns
    -------
    force, moment : array (shoes, 3)
        N, and N m about the COM.
    """
    along_ground = case.terrain.down * np.array([1.0, 1.0, 0.0])
    loads = case.first_loads
    height = 0.5 * case.settled_penetration - case.shoe.com_height
    force = -(loads + masses * case.gravity)[:, None] * along_ground
    return force, np.cross([*case.shoe.underside_center, height], force)


def add_grip(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody], flexible_mass: float) -> None:
    """Add the friction of `grips`; `flexible_mass` (kg) is that of a flexible shoe."""
    masses = np.array([flexible_mass if shoe.is_flexible else case.shoe.mass for shoe in shoes])
    for shoe, force, moment in zip(shoes, *grips(case, masses), strict=True):
        frame = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=shoe.node))
        mbs.AddLoad(items.LoadForceVector(markerNumber=frame, loadVector=force.tolist()))
        mbs.AddLoad(items.LoadTorqueVector(markerNumber=frame, loadVector=moment.tolist()))


def _downward(force: Callable[[float], NDArray], down: NDArray) -> Callable[..., list[float]]:
    """Exudyn's user function of a load over time along the direction `down`."""
    size = at_time(force)
    x, y, z = down.tolist()

    def downward(_mbs, t, _load):
        now = size(t)
        return [now * x, now * y, now * z]

    return downward
