"""What pictures show, read back from their artists."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray


def curves(figure: Figure) -> dict[str, dict[str, NDArray]]:
    """Labels of the panels, and values by curve of each."""
    return {
        ax.get_ylabel().replace("\n", " "): {line.get_label(): line.get_ydata() for line in ax.lines}
        for ax in figure.axes
    }


def corners(collection: PolyCollection) -> NDArray:
    """Corners of the quadrilaterals of a collection: array (n, 4, 2)."""
    return np.array([path.vertices[:4] for path in collection.get_paths()])
