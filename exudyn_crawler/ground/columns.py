"""Layouts of rows of numbers: what stands in which columns, said once by a named tuple.

A layout is a named tuple of the first column of each quantity. Its annotations say how many columns each
takes; compiled code reads the columns by name as it reads any constant.
"""

from typing import Annotated, NamedTuple, TypeVar, get_type_hints

Number = Annotated[int, 1]
Pair = Annotated[int, 2]
Triple = Annotated[int, 3]
Quadruple = Annotated[int, 4]
Matrix = Annotated[int, 9]
"""First column of a quantity with so many columns."""

Layout = TypeVar("Layout", bound=NamedTuple)


def widths_of(kind: type[NamedTuple]) -> dict[str, int]:
    """Columns that each quantity of a layout takes."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


def width_of(kind: type[NamedTuple]) -> int:
    """Columns of a layout."""
    return sum(widths_of(kind).values())


def columns_of(kind: type[Layout]) -> Layout:
    """First columns of a layout, one quantity after the other."""
    firsts = []
    end = 0
    for width in widths_of(kind).values():
        firsts.append(end)
        end += width
    return kind(*firsts)  # type: ignore[call-overload]


def places_of(kind: type[NamedTuple]) -> dict[str, int | slice]:
    """Column of each quantity of a layout by its name, or slice where it takes several."""
    widths = widths_of(kind)
    firsts = columns_of(kind)
    return {
        name: first if width == 1 else slice(first, first + width)
        for (name, width), first in zip(widths.items(), firsts, strict=True)
    }
