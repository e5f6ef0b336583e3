"""Release of freed memory to the operating system."""

import ctypes
from collections.abc import Callable
from functools import cache


def give_back_memory() -> None:
    """Release the memory of freed arrays to the operating system, if the C library can do so.

    glibc keeps free memory between objects in use: some hundred MB after the assembly of a matrix. Nothing
    happens with another C library.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """Return glibc's `malloc_trim`; None with another C library."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None
