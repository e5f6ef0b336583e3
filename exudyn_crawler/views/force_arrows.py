"""Forces as arrows on axes of matplotlib."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.quiver import Quiver


def force_arrows(ax: Axes, count: int, colour: str) -> Quiver:
    """Arrows whose heads are where they are set, in the units of the axes; none is seen before."""
    nowhere, nothing = np.zeros(count), np.full(count, np.nan)
    how: dict[str, Any] = {
        "angles": "xy",
        "scale_units": "xy",
        "scale": 1.0,
        "pivot": "tip",
        "width": 0.0022,
        "zorder": 4,
    }
    return ax.quiver(nowhere, nowhere, nothing, nothing, color=colour, **how)
