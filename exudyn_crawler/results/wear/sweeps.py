"""Sweeps of hinges: turns between reversals, without those below a threshold.

A chain without friction in its pins rattles: most of the raw integral of force times turned angle is small
turns back and forth. Sweeps of at least a threshold are the bends over the wheels.
"""

import numpy as np


def sweep_signs(angle: np.ndarray, threshold: float) -> np.ndarray:
    """Return the sense of the sweep that each step belongs to: array (times - 1, items) of -1, 0 and 1.

    A sweep goes from a turning point to the next one; both differ by at least the threshold (rad), and
    smaller reversals between them belong to it. Steps beyond the last turning point have 0. `angle` is
    (times, items), rad.
    """
    count, items = angle.shape
    turns = np.zeros((count, items), dtype=bool)
    sense = np.zeros(items, dtype=int)
    first = np.zeros(items, dtype=int)
    last = np.zeros(items, dtype=int)
    extreme = angle[0].copy()
    every = np.arange(items)
    for k in range(1, count):
        x = angle[k]
        moved = x - extreme
        begins = (sense == 0) & (np.abs(moved) >= threshold)
        turned = (sense != 0) & (-sense * moved >= threshold)
        turns[last[turned], every[turned]] = True
        sense = np.where(begins, np.sign(moved), np.where(turned, -sense, sense)).astype(int)
        first = np.where(begins, sense, first)
        further = begins | turned | ((sense != 0) & (sense * moved > 0.0))
        last = np.where(further, k, last)
        extreme = np.where(further, x, extreme)
    passed = np.cumsum(turns, axis=0)[:-1]
    signs = first * np.where(passed % 2, -1, 1)
    signs[np.arange(count - 1)[:, None] >= last] = 0
    return signs


def sweep_work(angle: np.ndarray, force: np.ndarray, radius: float, threshold: float) -> np.ndarray:
    """Return force x radius x turned angle of sweeps: array (times - 1, items), J.

    `angle` (rad) and `force` (N) are (times, items), `radius` is in m. The sum over the steps of a sweep is
    its work; small reversals within it count back. A threshold of 0 gives the raw integral of force times
    radius times turned angle.
    """
    turned = np.diff(angle, axis=0)
    signs = np.sign(turned) if threshold == 0.0 else sweep_signs(angle, threshold)
    work: np.ndarray = 0.5 * (force[1:] + force[:-1]) * radius * turned * signs
    return work
