"""Layouts of rows of numbers: a named tuple says once which columns each quantity takes.

A layout is a named tuple of the first column of each quantity. Its annotations give the number of columns of
each; compiled code reads the columns by name like any constant.
"""

from typing import Annotated, NamedTuple, TypeVar, get_type_hints

Number = Annotated[int, 1]
Pair = Annotated[int, 2]
Triple = Annotated[int, 3]
Quadruple = Annotated[int, 4]
Matrix = Annotated[int, 9]
"""First column of a quantity with 1, 2, 3, 4 or 9 columns."""

Layout = TypeVar("Layout", bound=NamedTuple)


def widths_of(kind: type[NamedTuple]) -> dict[str, int]:
    """Return the number of columns of each quantity of a layout."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


def width_of(kind: type[NamedTuple]) -> int:
    """Return the number of columns of a layout."""
    return sum(widths_of(kind).values())


def columns_of(kind: type[Layout]) -> Layout:
    """Return the first columns of a layout, its quantities one after the other."""
    firsts = []
    end = 0
    for width in widths_of(kind).values():
        firsts.append(end)
        end += width
    return kind(*firsts)  # type: ignore[call-overload]


def places_of(kind: type[NamedTuple]) -> dict[str, int | slice]:
    """Return the column of each quantity of a layout by its name; a slice for several columns."""
    widths = widths_of(kind)
    firsts = columns_of(kind)
    return {
        name: first if width == 1 else slice(first, first + width)
        for (name, width), first in zip(widths.items(), firsts, strict=True)
    }
