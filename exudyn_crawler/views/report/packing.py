"""Arrays on a page: as base64 of little-endian bytes, and thinned so that no extreme is lost."""

import base64

import numpy as np
from numpy.typing import NDArray


def packed(array: NDArray, kind: str) -> str:
    """Base64 of an array as little-endian numbers of a kind such as "f4" or "u2"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()).decode("ascii")


def thinned(values: NDArray, points: int) -> NDArray:
    """Indices to keep of a series (n,): ends, and the least and greatest of bins; at most about `points`."""
    n = len(values)
    if n <= points:
        return np.arange(n)
    bins = max(1, points // 2 - 1)
    width = -(-n // bins)
    padded = np.concatenate((values, np.full(-n % width, values[-1]))).reshape(-1, width)
    starts = width * np.arange(len(padded))
    kept = np.concatenate(([0, n - 1], starts + padded.argmin(axis=1), starts + padded.argmax(axis=1)))
    return np.unique(np.minimum(kept, n - 1))
