"""Machine loads on the shoes of the multibody system."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import at_time
from exudyn_crawler.model.shoes import ShoeBody


def add_loads(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody]) -> None:
    """Machine load on the top face of every shoe, along gravity."""
    down = case.terrain.down
    for number, shoe in enumerate(shoes, start=1):
        profile = case.loads.profile(number)
        load = items.LoadForceVector(
            markerNumber=shoe.top, loadVector=(float(profile.value(0.0)) * down).tolist()
        )
        if len(set(profile.values)) > 1:
            load.loadVectorUserFunction = _downward(profile, down)
        mbs.AddLoad(load)


def add_grip(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody], flexible_mass: float) -> None:
    """Friction that holds each shoe on a slope at rest, where the laws, which need slip, have none.

    It acts at the underside, half as deep in the ground as the shoe has settled.

    Parameters
    ----------
    flexible_mass : float
        kg, of a flexible shoe.
    """
    along_ground = case.terrain.down * np.array([1.0, 1.0, 0.0])
    loads = case.loads.loads(0.0)[0]
    height = 0.5 * case.settled_penetration - case.shoe.com_height
    arm = np.array([*case.shoe.underside_center, height])
    for shoe, load in zip(shoes, loads, strict=True):
        mass = flexible_mass if shoe.is_flexible else case.shoe.mass
        grip = -(load + mass * case.gravity) * along_ground
        frame = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=shoe.node))
        mbs.AddLoad(items.LoadForceVector(markerNumber=frame, loadVector=grip.tolist()))
        moment = np.cross(arm, grip).tolist()
        mbs.AddLoad(items.LoadTorqueVector(markerNumber=frame, loadVector=moment))


def _downward(profile: StepProfile, down: NDArray) -> Callable[..., list[float]]:
    """Exudyn's user function of a load over time along the direction `down`."""
    size = at_time(profile.value)
    x, y, z = down.tolist()

    def downward(_mbs, t, _load):
        now = size(t)
        return [now * x, now * y, now * z]

    return downward
