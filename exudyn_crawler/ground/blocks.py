"""Blocks of memory with the numbers of nested tuples, and the addresses and shapes of their arrays.

A block has a word of 8 bytes for each number. Compiled code reads a field where it names it. numba has no
public means for this; `trial` tries those that are used here.
"""

import itertools
import operator
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, models, overload, register_model
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

WORD = ir.IntType(64)


def write(values: tuple, kind: types.Type) -> NDArray[np.int64]:
    """Return the block (words,) of tuples, whose arrays must outlive it."""
    words: list[int] = []

    def add(value: Any, of: Any) -> None:
        if isinstance(of, types.BaseTuple):
            for part, of_part in zip(value, of.types, strict=True):
                add(part, of_part)
        elif isinstance(of, types.Array):
            words.extend((value.ctypes.data, *value.shape))
        else:
            number = struct.pack("<d", value) if of == types.float64 else struct.pack("<q", value)
            words.append(int.from_bytes(number, "little", signed=True))

    add(values, kind)
    return np.array(words, dtype=np.int64)


class Packed(types.Type):
    """Tuple in a block; compiled code reads its fields by name, each time that it names them."""

    def __init__(self, kind: types.BaseTuple, opened: tuple[type, ...]) -> None:
        self.kind = kind
        self.opened = opened
        super().__init__(f"Packed({kind})")

    def part(self, kind: types.Type) -> types.Type:
        """Return the type of a field: another part for the opened classes and for rows of tuples."""
        is_part = isinstance(kind, types.UniTuple) and isinstance(kind.dtype, types.BaseTuple)
        is_part = is_part or getattr(kind, "instance_class", None) in self.opened
        return Packed(kind, self.opened) if is_part else kind


@register_model(Packed)
class _PackedModel(models.PrimitiveModel):
    """A part is the address of its first word."""

    def __init__(self, manager: Any, kind: Packed) -> None:
        super().__init__(manager, kind, WORD.as_pointer())


@infer_getattr
class _Fields(AttributeTemplate):
    key = Packed

    def generic_resolve(self, part: Packed, name: str) -> types.Type | None:
        fields = getattr(part.kind, "fields", ())
        return part.part(part.kind.types[fields.index(name)]) if name in fields else None


@lower_getattr_generic(Packed)
def _read_field(context: Any, builder: Any, part: Packed, words: Any, name: str) -> Any:
    number = part.kind.fields.index(name)
    first = sum(map(_size, part.kind.types[:number]))
    place = builder.gep(words, [ir.Constant(WORD, first)])
    return _value(context, builder, place, part.part(part.kind.types[number]))


@overload(len)
def _count(part):  # numba compares the two signatures
    if not isinstance(part, Packed) or not isinstance(part.kind, types.UniTuple):
        return None
    count = part.kind.count
    return lambda part: count


@overload(operator.getitem)
def _item(part, number):
    if not isinstance(part, Packed) or not isinstance(part.kind, types.UniTuple):
        return None
    return lambda part, number: _read_item(part, number)


@intrinsic
def _read_item(_typing: Any, part: Any, number: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        words, k = arguments
        kind = signature.args[0].kind.dtype
        k = context.cast(builder, k, signature.args[1], types.int64)
        place = builder.gep(words, [builder.mul(k, ir.Constant(WORD, _size(kind)))])
        return _value(context, builder, place, signature.return_type)

    return part.part(part.kind.dtype)(part, number), code


def _size(kind: types.Type) -> int:
    """Return the number of words of a value."""
    if isinstance(kind, types.BaseTuple):
        return sum(map(_size, kind.types))
    return 1 + kind.ndim if isinstance(kind, types.Array) else 1


def _value(context: Any, builder: Any, words: Any, kind: types.Type) -> Any:
    """Return the value at the address of its first word."""
    if isinstance(kind, Packed):
        return words
    places = itertools.count()

    def word() -> Any:
        return builder.load(builder.gep(words, [ir.Constant(WORD, next(places))]))

    def array(of: Any) -> Any:
        view = make_array(of)(context, builder)
        size = ir.Constant(WORD, context.get_abi_sizeof(context.get_data_type(of.dtype)))
        address = word()
        shape = [word() for _ in range(of.ndim)]
        strides = [size]
        for length in shape[:0:-1]:
            strides.insert(0, builder.mul(strides[0], length))
        data = builder.inttoptr(address, view.data.type)
        populate_array(view, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
        return view._getvalue()

    def value(of: Any) -> Any:
        if isinstance(of, types.BaseTuple):
            return context.make_tuple(builder, of, [value(part) for part in of.types])
        if isinstance(of, types.Array):
            return array(of)
        bits = word()
        if of == types.float64:
            return builder.bitcast(bits, ir.DoubleType())
        return builder.trunc(bits, ir.IntType(1)) if of == types.boolean else bits

    return value(kind)


def read(block: types.Array, kind: types.BaseTuple, opened: tuple[type, ...]) -> tuple[Any, Callable]:
    """Return signature and code, those of an `intrinsic`, of a function that takes a block.

    It returns the tuple, whose fields are read by name. Fields of `opened` classes, and rows of tuples, are
    themselves read by name; all others as a whole. References to arrays are not counted.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        words = make_array(signature.args[0])(context, builder, arguments[0]).data
        return _value(context, builder, words, signature.return_type)

    return Packed(kind, opened)(block), code
