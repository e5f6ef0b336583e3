"""Memory of freed arrays, which the C library holds on to."""

import ctypes
from collections.abc import Callable
from functools import cache


def give_back_memory() -> None:
    """Give memory of arrays that were freed back to the operating system, where the C library does so.

    glibc holds on to what lies between objects that are still in use, some hundred MB after a matrix was made
    of elements. Another library is left as it is.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """Function of glibc that does so; None for others."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None
