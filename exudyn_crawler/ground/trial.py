"""Trial of numba's internals: a function that reads a block of memory, compiled as part of a kernel.

The kernel is cached like all others, so that the trial costs time only with another numba.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import typeof
from numba.extending import intrinsic

from exudyn_crawler.ground import blocks, linking
from fem.compiling import COUNTS, compiler


class _Part(NamedTuple):
    """Values of every kind."""

    array: np.ndarray
    number: int
    pair: tuple[float, float]
    is_on: bool


class _Whole(NamedTuple):
    """Parts in a row, and one alone."""

    parts: tuple[_Part, _Part]
    last: _Part


def _part(value: float, is_on: bool) -> _Part:
    return _Part(np.full((2, 3), value), 40, (0.5, 10.0), is_on)


WHOLE = _Whole((_part(1.0, True), _part(2.0, False)), _part(3.0, True))
KIND = typeof(WHOLE)


@intrinsic
def _read(_typing: Any, block: Any) -> Any:
    return blocks.read(block, KIND, (_Part,))


def _sum(part: Any) -> float:
    total = part.number + (0.25 if part.is_on else 0.5)
    for i in range(part.array.shape[0]):
        for j in range(part.array.shape[1]):
            total += part.array[i, j] * part.pair[1]
    return total


_merged_sum = linking.linked(_sum, allocates=False, merged=True)


def _both(parts: Any) -> float:
    total = 0.0
    for k in range(len(parts)):
        total += _merged_sum(parts[k])
    return total


_linked_both = linking.linked(_both, allocates=False, merged=False)


@compiler(error_model="numpy")
def _total(block: np.ndarray) -> float:
    whole = _read(block)
    whole.last.array[1, 2] = 7.0
    return _linked_both(whole.parts) + _merged_sum(whole.last)


def passes() -> bool:
    """Return True if numba's internals give what they should; they may also raise any error."""
    WHOLE.last.array.fill(3.0)
    result = _total(blocks.write(WHOLE, KIND))
    return bool(COUNTS) and result == 521.0 and WHOLE.last.array[1, 2] == 7.0
