"""Nested tuples of arrays and numbers in one block of memory, which compiled functions read in place.

Python would take longer to look at the types of hundreds of arrays in every call than the contact of a track
takes, and compiled functions pass them on one by one. The annotations of named tuples define the contents of
a block, the same for all cases. Without numba's internals (`compiled.internals_work`) compiled functions take
the tuples themselves.
"""

import operator
from collections.abc import Callable
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from numba import typeof, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from exudyn_crawler.ground.compiled import internals_work

try:
    from exudyn_crawler.ground import blocks
except Exception:  # another numba: `internals_work` says so when a tuple is packed
    blocks = None  # type: ignore[assignment]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Floats1 = Annotated[FloatArray, types.float64[::1]]
Floats2 = Annotated[FloatArray, types.float64[:, ::1]]
Floats3 = Annotated[FloatArray, types.float64[:, :, ::1]]
Floats4 = Annotated[FloatArray, types.float64[:, :, :, ::1]]
Floats5 = Annotated[FloatArray, types.float64[:, :, :, :, ::1]]
Ints1 = Annotated[IntArray, types.int64[::1]]
Ints2 = Annotated[IntArray, types.int64[:, ::1]]
"""Contiguous arrays, in C order, with the number of dimensions in the name."""

NUMBERS = {float: types.float64, int: types.int64, bool: types.boolean}
NUMBER_OF: dict[types.Type, Callable[[Any], Any]] = {
    types.float64: float,
    types.int64: operator.index,
    types.boolean: bool,
}


def type_of(kind: Any) -> types.Type:
    """Return the compiler's type of an annotation."""
    if get_origin(kind) is Annotated:
        return kind.__metadata__[0]
    if kind in NUMBERS:
        return NUMBERS[kind]
    if get_origin(kind) is tuple:
        return types.BaseTuple.from_types([type_of(annotation) for annotation in get_args(kind)])
    fields = [type_of(annotation) for annotation in get_type_hints(kind, include_extras=True).values()]
    return types.BaseTuple.from_types(fields, kind)


def nothing(kind: Any) -> Any:
    """Return values of an annotation without rows: arrays are empty, numbers 1."""
    if get_origin(kind) is Annotated:
        return _nothing(kind.__metadata__[0])
    if kind in NUMBERS:
        return kind(1)
    if get_origin(kind) is tuple:
        return tuple(nothing(annotation) for annotation in get_args(kind))
    return kind(*map(nothing, get_type_hints(kind, include_extras=True).values()))


def _nothing(kind: Any) -> Any:
    if isinstance(kind, types.Array):
        return np.zeros((0,) * kind.ndim, dtype=str(kind.dtype))
    return tuple(map(_nothing, kind.types)) if isinstance(kind, types.BaseTuple) else 1


def pack(values: tuple, kind: types.Type) -> Any:
    """Return the block (words,) of tuples, whose arrays must outlive it, or the tuples without internals.

    Raises
    ------
    TypeError
        For an array or a number of another type.
    """
    exact = _exact(values, kind)
    return blocks.write(exact, kind) if internals_work() else exact


def _exact(value: Any, kind: types.Type) -> Any:
    """Return a value with numbers of the types of its kind; the kind decides what is compiled."""
    if isinstance(kind, types.BaseTuple):
        parts = [_exact(*pair) for pair in zip(value, kind.types, strict=True)]
        return kind.instance_class(*parts) if hasattr(kind, "instance_class") else tuple(parts)
    if isinstance(kind, types.Array):
        if typeof(value) != kind:
            raise TypeError(f"arrays must be {kind}, got {typeof(value)}")
        return value
    return NUMBER_OF[kind](value)


def reader(kind: types.BaseTuple, *opened: type) -> Callable[[Any], Any]:
    """Return a function for compiled callers alone that takes a packed tuple and returns its fields by name.

    In a block, fields of `opened` classes, and rows of tuples, are themselves read by name; all others as a
    whole. References to its arrays are not counted.
    """

    @intrinsic
    def read(_typing: Any, packed: Any) -> Any:
        if isinstance(packed, types.Array):
            return blocks.read(packed, kind, opened)

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            context.nrt.incref(builder, signature.return_type, arguments[0])
            return arguments[0]

        return packed(packed), code

    return read
