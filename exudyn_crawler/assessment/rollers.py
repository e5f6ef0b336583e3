"""Loads of the lower rollers of one track: on even ground, and where few of them bear.

Rollers stand at places x along the side frame and only push. What the uneven supports are is a convention of
this assessment (assumed): no source that could be read has a rule for the rollers of large crawlers.
"""

import numpy as np

from exudyn_crawler.assessment.forces import Floats

NEGLIGIBLE = 1e-12
"""Part of the load that counts as none."""


def even_loads(load: float, centre: float, places: Floats, parts: Floats | None = None) -> Floats:
    """Loads (N) on even ground: P w (1 / W + e (x - x_m) / sum(w (x - x_m)^2)) (rigid frame, derived).

    `load` (N) at x = `centre` (m) of supports at `places` (m), as stiff as `parts` w say: 1 for a roller, 2
    for a bogie of two, 1 each if none. Those that would pull bear nothing and the rest all of it; a
    ValueError if the load is not between the outer ones.
    """
    places = np.asarray(places, dtype=float)
    stiff = np.ones(len(places)) if parts is None else np.asarray(parts, dtype=float)
    if not places.min() <= centre <= places.max():
        between = f"rollers from {places.min():.4g} to {places.max():.4g} m"
        raise ValueError(f"a load must be between its {between}, got x = {centre:.4g} m")
    bears = np.ones(len(places), dtype=bool)
    while True:
        x = places[bears]
        w = stiff[bears]
        middle = float(w @ x / w.sum())
        spread = float(w @ (x - middle) ** 2)
        share = w * (1.0 / w.sum() + (centre - middle) * (x - middle) / (spread or 1.0))
        if share.min() >= -NEGLIGIBLE or len(x) <= 2:
            break
        bears[np.flatnonzero(bears)[share.argmin()]] = False
    loads = np.zeros(len(places))
    loads[bears] = load * np.maximum(share, 0.0)
    return loads


def two_loads(load: float, centre: float, places: Floats, pair: tuple[int, int]) -> Floats:
    """Loads (N) where two rollers, from 0, bear all: R_i = P (x_j - x_c) / (x_j - x_i) (lever, derived).

    A ValueError if the load is not between them.
    """
    first, second = (float(places[number]) for number in pair)
    if not min(first, second) <= centre <= max(first, second):
        raise ValueError(f"a load at x = {centre:.4g} m must be between {first:.4g} and {second:.4g} m")
    share = (second - centre) / (second - first)
    loads = np.zeros(len(places))
    loads[list(pair)] = load * share, load * (1.0 - share)
    return loads


def neighbours(centre: float, places: Floats) -> tuple[int, int]:
    """Numbers, from 0, of the rollers on both sides of the one that is nearest to a place (m)."""
    nearest = int(np.abs(np.asarray(places) - centre).argmin())
    return max(nearest - 1, 0), min(nearest + 1, len(places) - 1)


def one_load(load: float, centre: float, places: Floats) -> Floats:
    """Loads (N) where the roller nearest to the load bears all of it."""
    loads = np.zeros(len(places))
    loads[int(np.abs(np.asarray(places) - centre).argmin())] = load
    return loads


def end_load(load: float, centre: float, places: Floats) -> Floats:
    """Loads (N) where an obstacle lifts one end: the outer rollers bear all, the nearer one the more."""
    return two_loads(load, centre, places, (0, len(places) - 1))


def corner_load(weight: float, ahead: float, aside: float, length: float, gauge: float) -> float:
    """Return the greatest load (N) of a corner that a stone lifts: V (1/2 + min(|x| / L, |y| / B)).

    The machine is rigid and stands on its corners at (+-L / 2, +-B / 2), which only push. The end and the
    track of a corner bear V (1/2 + |x| / L) and V (1/2 + |y| / B) however the corners share it: the corner
    bears the lesser of both where its neighbour there bears nothing (statics; derived).
    """
    along = min(abs(ahead) / length, 0.5) if length else 0.5
    return weight * (0.5 + min(along, abs(aside) / gauge, 0.5))
