"""Loads of the lower rollers of one track on even ground and on uneven supports.

Rollers have positions x along the side frame and only push. The uneven supports are a convention of this
assessment (assumed): no rule for the rollers of large crawlers was found in any source.
"""

import numpy as np

from exudyn_crawler.assessment.forces import Floats, Numbers

NEGLIGIBLE = 1e-12
"""Fraction of the load that counts as zero."""


def even_loads(load: Numbers, centre: Numbers, positions: Floats, parts: Floats | None = None) -> Floats:
    """Return loads (..., rollers) on even ground, N: P w (1 / W + e (x - x_m) / sum(w (x - x_m)^2)).

    `load` (N) acts at x = `centre` (m), one or several (...,). Supports at `positions` (m) have the stiffness
    `parts` w: 1 for a roller, 2 for a bogie of two; None: 1 each (rigid frame, derived). Supports that would
    pull bear nothing. Raise `ValueError` if a load is not between the outer supports.
    """
    positions = np.asarray(positions, dtype=float)
    stiff = np.ones(len(positions)) if parts is None else np.asarray(parts, dtype=float)
    load, centre = np.asarray(load, dtype=float), np.asarray(centre, dtype=float)
    if centre.min() < positions.min() or centre.max() > positions.max():
        between = f"rollers from {positions.min():.4g} to {positions.max():.4g} m"
        farthest = float(centre.max() if centre.max() > positions.max() else centre.min())
        raise ValueError(f"a load must be between its {between}, got x = {farthest:.4g} m")
    bears = np.ones((*centre.shape, len(positions)), dtype=bool)
    while True:
        w = np.where(bears, stiff, 0.0)
        whole = w.sum(axis=-1, keepdims=True)
        middle = (w * positions).sum(axis=-1, keepdims=True) / whole
        arm = positions - middle
        spread = (w * arm**2).sum(axis=-1, keepdims=True)
        share = w * (1.0 / whole + (centre[..., None] - middle) * arm / np.where(spread > 0.0, spread, 1.0))
        pulls = (share.min(axis=-1) < -NEGLIGIBLE) & (bears.sum(axis=-1) > 2)
        if not pulls.any():
            return load[..., None] * np.maximum(share, 0.0)
        least = share.argmin(axis=-1)[..., None]
        np.put_along_axis(
            bears, least, ~pulls[..., None] & np.take_along_axis(bears, least, axis=-1), axis=-1
        )


def two_loads(load: Numbers, centre: Numbers, positions: Floats, pair: tuple[Numbers, Numbers]) -> Floats:
    """Return loads (..., rollers), N, if two rollers, from 0, bear all: R_i = P (x_j - x_c) / (x_j - x_i).

    The loads are one or several (...,), each with its pair of rollers (lever, derived). Raise `ValueError` if
    a load is not between its rollers.
    """
    positions = np.asarray(positions, dtype=float)
    load, centre = np.asarray(load, dtype=float), np.asarray(centre, dtype=float)
    numbers = [np.broadcast_to(np.asarray(number) % len(positions), centre.shape) for number in pair]
    first, second = (positions[number] for number in numbers)
    outside = (centre < np.minimum(first, second)) | (centre > np.maximum(first, second))
    if outside.any():
        x, low, high = (float(np.extract(outside, values)[0]) for values in (centre, first, second))
        raise ValueError(f"a load at x = {x:.4g} m must be between {low:.4g} and {high:.4g} m")
    share = (second - centre) / (second - first)
    loads = np.zeros((*centre.shape, len(positions)))
    for number, part in zip(numbers, (share, 1.0 - share), strict=True):
        np.put_along_axis(loads, number[..., None], (load * part)[..., None], axis=-1)
    return loads


def _nearest(centre: Numbers, positions: Floats) -> np.ndarray:
    """Return the number, from 0, of the roller nearest to each place (m): array (...,)."""
    return np.abs(np.asarray(positions) - np.asarray(centre)[..., None]).argmin(axis=-1)


def neighbours(centre: Numbers, positions: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers, from 0, of the rollers on both sides of the one nearest to a place (m)."""
    nearest = _nearest(centre, positions)
    return np.maximum(nearest - 1, 0), np.minimum(nearest + 1, len(positions) - 1)


def one_load(load: Numbers, centre: Numbers, positions: Floats) -> Floats:
    """Return loads (..., rollers), N, if the roller nearest to the load bears all of it."""
    alone = _nearest(centre, positions)[..., None] == np.arange(len(positions))
    return np.asarray(load, dtype=float)[..., None] * alone


def end_load(load: Numbers, centre: Numbers, positions: Floats) -> Floats:
    """Return loads (..., rollers), N, if an obstacle lifts one end: the outer rollers bear all."""
    return two_loads(load, centre, positions, (0, len(positions) - 1))


def corner_load(weight: Numbers, ahead: Numbers, aside: Numbers, length: float, gauge: float) -> Numbers:
    """Return the greatest load (N) of a corner on a stone: V (1/2 + min(abs(x) / L, abs(y) / B)).

    The machine is rigid and stands on its corners at (+-L / 2, +-B / 2), which only push. The end of a corner
    bears V (1/2 + x / L) and its track V (1/2 + y / B), for any shares of the corners. The corner bears
    the lesser of both if its neighbour there bears nothing (statics; derived).
    """
    off = np.minimum(np.abs(ahead) / length, np.abs(aside) / gauge)
    return weight * (0.5 + np.minimum(off, 0.5))
