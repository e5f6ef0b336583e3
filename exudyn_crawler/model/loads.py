"""Machine loads on the shoes of the multibody system."""

from collections.abc import Callable, Sequence

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import at_time
from exudyn_crawler.model.shoes import ShoeBody


def add_loads(mbs: "exu.MainSystem", case: Case, shoes: Sequence[ShoeBody]) -> None:
    """Machine load on the top face of every shoe."""
    for number, shoe in enumerate(shoes, start=1):
        profile = case.loads.profile(number)
        load = items.LoadForceVector(markerNumber=shoe.top, loadVector=[0.0, 0.0, -float(profile.value(0.0))])
        if len(set(profile.values)) > 1:
            load.loadVectorUserFunction = _vertical(profile)
        mbs.AddLoad(load)


def _vertical(profile: StepProfile) -> Callable[..., list[float]]:
    """Exudyn's user function of a downward load over time."""
    size = at_time(profile.value)

    def vertical(_mbs, t, _load):
        return [0.0, 0.0, -size(t)]

    return vertical
