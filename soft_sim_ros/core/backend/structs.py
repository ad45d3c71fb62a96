"""Structs of arrays that kernels get by reference: one address instead of hundreds of words.

To numba a named tuple of arrays is a value. Every kernel that takes one unpacks and packs hundreds
of words: compiling that took most of the time of a first start, and passing them most of the time
of a call. Here a named tuple registered by ``struct`` is packed into words once,
and kernels get the address of the words. Attributes read as before, each loaded where it is used.

Arrays are borrowed: the caller who packed them keeps them alive, references are not counted, and
packed words are never written, so the compiler may load them once and keep them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any, NoReturn, TypeVar

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)
from numba.np.arrayobj import populate_array

from soft_sim_ros.errors import NotCopied

T = TypeVar("T", bound=type)
_model: Any = register_model
_template: Any = AttributeTemplate
_WORD = ir.IntType(64)
# This many structs passed from Python stay packed for the next call.
RECENT = 64


class Struct(types.Type):
    """The type of a reference to a packed named tuple.

    A field is an array, a number of eight bytes or a struct; kernels cannot see any other.
    """

    def __init__(self, instance_class: Any, parts: tuple[Any, ...]) -> None:
        self.instance_class, self.parts = instance_class, parts
        self.place: dict[str, tuple[int, Any]] = {}  # field → first word, type
        self.size = 0
        for field, part in zip(instance_class._fields, parts, strict=True):
            self.place[field] = self.size, part
            self.size += _words(part)
        # types of one name are the same to numba; it is short because it is in all symbols
        digest = hashlib.sha256(repr(parts).encode()).hexdigest()[:12]
        super().__init__(name=f"{instance_class.__name__}_{digest}")


def _words(part: Any) -> int:
    """Return how many words a field takes: address and shape of an array, else one."""
    if isinstance(part, types.Array):
        return 1 + part.ndim
    return int(part in (types.float64, types.int64) or isinstance(part, Struct))


_seen: dict[Any, Struct] = {}  # by layout: numba takes some 20 µs to name the type of an array
_TYPE_BITS = 0x1 | 0x2 | 0x400  # of numpy's flags: contiguous by rows, by columns, writable


def layout(value: Any) -> tuple[Any, ...]:
    """Return what the type of a struct depends on, and nothing else, as a key of dictionaries."""
    parts: list[Any] = [type(value)]
    for part in value:
        if isinstance(part, np.ndarray):
            parts.append((part.dtype, part.ndim, part.flags.num & _TYPE_BITS))
        elif isinstance(part, tuple) and part:
            parts.append(layout(part))
        else:
            parts.append(type(part))
    return tuple(parts)


def struct(kind: T) -> T:
    """Let kernels get named tuples of this class by reference."""

    def typeof(value: Any, _context: Any) -> Struct:
        key = layout(value)
        if key not in _seen:
            _seen[key] = Struct(kind, tuple(numba.typeof(part) for part in value))
        return _seen[key]

    typeof_impl.register(kind)(typeof)
    return kind


class Packed:
    """The words of a struct, and what they refer to, kept alive.

    kind : its type, if that is known already
    shared : packed structs; those among them that are parts of this one are not packed again
    """

    __slots__ = ("_kept", "_words", "address")
    _kept: list[Any]  # the struct, then the packed structs in it

    def __init__(
        self, value: Any, kind: Struct | None = None, shared: Sequence[Packed] = ()
    ) -> None:
        kind = numba.typeof(value) if kind is None else kind
        assert kind is not None
        kept: list[Any] = [value]
        words: list[Any] = []
        for name, part in zip(value._fields, value, strict=True):
            field = kind.place[name][1]
            if isinstance(field, types.Array):
                if field.layout != "C":
                    raise TypeError(f"{kind}.{name} must be a contiguous array, not {field}")
                words.append(part.__array_interface__["data"][0])
                words += part.shape
            elif isinstance(field, Struct):
                ready = [one for one in shared if one._kept[0] is part]
                kept.append(ready[0] if ready else Packed(part, field))
                words.append(kept[-1].address)
            elif field == types.float64:
                words.append(np.float64(part).view(np.int64))
            elif _words(field):
                words.append(part)
        self._kept, self._words = kept, np.array([*words, 0], dtype=np.int64)
        self.address = int(self._words.ctypes.data)

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        """Refuse to be copied or pickled: the words would refer to the original's arrays."""
        raise NotCopied("a packed struct", "it holds addresses; copy the named tuple")


_recent: dict[int, tuple[Any, Packed]] = {}


def packed(value: Any) -> Packed:
    """Return a struct as packed words; the last RECENT ones are kept for the next call."""
    found = _recent.get(id(value))
    if found is not None and found[0] is value:
        return found[1]
    if len(_recent) >= RECENT:
        _recent.pop(next(iter(_recent)), None)
    new = Packed(value)
    _recent[id(value)] = value, new
    return new


_model(Struct)(models.OpaqueModel)


@infer_getattr
class _Fields(_template):
    key = Struct

    def generic_resolve(self, kind: Struct, field: str) -> Any:
        """Return the type of a field."""
        _, part = kind.place.get(field, (0, None))
        return part if part is not None and _words(part) else None


@lower_getattr_generic(Struct)
def _field(context, builder, kind, value, field):
    """Load a field."""
    first, part = kind.place[field]
    unchanging = builder.module.add_metadata([])

    def word(place: int, as_type: Any) -> Any:
        start = builder.bitcast(value, _WORD.as_pointer())
        where = builder.gep(start, [ir.Constant(_WORD, first + place)], inbounds=True)
        loaded = builder.load(builder.bitcast(where, as_type.as_pointer()))
        loaded.set_metadata("invariant.load", unchanging)
        return loaded

    if not isinstance(part, types.Array):
        return word(0, context.get_value_type(part))
    array = context.make_array(part)(context, builder)
    shape = [word(1 + i, _WORD) for i in range(part.ndim)]
    size = ir.Constant(_WORD, context.get_abi_sizeof(context.get_data_type(part.dtype)))
    strides = [size]
    for length in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], length, flags=("nsw",)))
    data = word(0, context.get_data_type(part.dtype).as_pointer())
    populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return array._getvalue()


@unbox(Struct)
def _unbox(_kind, given, c):
    """Refer to a named tuple from Python; it stays packed until the kernel returns."""
    api = c.pyapi
    pack = api.unserialize(api.serialize_object(packed))
    holder = api.call_function_objargs(pack, (given,))
    api.decref(pack)
    value = cgutils.alloca_once_value(c.builder, cgutils.get_null_value(cgutils.voidptr_t))
    with cgutils.if_likely(c.builder, cgutils.is_not_null(c.builder, holder)):
        number = api.object_getattr_string(holder, "address")
        c.builder.store(api.long_as_voidptr(number), value)
        api.decref(number)
    failed = cgutils.is_null(c.builder, holder)

    def forget() -> None:
        api.decref(holder)

    return NativeValue(c.builder.load(value), is_error=failed, cleanup=forget)
