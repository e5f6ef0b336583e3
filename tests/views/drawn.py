"""What pictures show, read back from their artists."""

import numpy as np
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray


def corners(collection: PolyCollection) -> NDArray:
    """Corners of the quadrilaterals of a collection: array (n, 4, 2)."""
    return np.array([path.vertices[:4] for path in collection.get_paths()])
