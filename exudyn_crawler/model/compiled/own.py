"""Coordinates of single shoes in those of the whole track."""

from typing import NamedTuple

from exudyn_crawler.ground.rotations import Attitude, FloatArray, attitude
from exudyn_crawler.model.compiled.elimination import solving_within


class Sizes(NamedTuple):
    """Numbers of things: coordinates of the terrain, modes of a flexible shoe, coordinates of the frame."""

    shoes: int
    terrain: int
    modes: int
    pins: int
    frame: int


@solving_within
def modal_start(sizes: Sizes, f: int) -> int:
    """First modal coordinate of the flexible shoe in row f; -1 for a rigid one, whose f is negative."""
    return 6 * sizes.shoes + sizes.terrain + f * sizes.modes if f >= 0 else -1


@solving_within
def read_own(s: int, modal: int, values: FloatArray, out: FloatArray) -> None:
    """Write the coordinates of a shoe and its modes, or zeros, into one row."""
    for k in range(6):
        out[k] = values[6 * s + k]
    for k in range(6, out.shape[0]):
        out[k] = values[modal + k - 6] if modal >= 0 else 0.0


@solving_within
def add_own(s: int, modal: int, own: FloatArray, factor: float, residual: FloatArray) -> None:
    """Add a row of a shoe's coordinates and modes, times a factor."""
    for k in range(6):
        residual[6 * s + k] += factor * own[k]
    if modal >= 0:
        for k in range(6, own.shape[0]):
            residual[modal + k - 6] += factor * own[k]


@solving_within
def shoe_attitude(state: FloatArray, s: int) -> Attitude:
    """Attitude of a shoe."""
    return attitude(state[0, 6 * s + 3], state[0, 6 * s + 4], state[0, 6 * s + 5])
