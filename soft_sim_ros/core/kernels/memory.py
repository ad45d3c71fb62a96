"""Structs of arrays in memory, so that kernels pass one address instead of hundreds of words.

Handing the arrays of a simulation from Python to a kernel costs about 0.3 µs each, at every call.
``pack`` does it once; afterwards kernels get an address and ``load`` from it what they use. The
arrays are borrowed: whoever packed them keeps them alive, and nobody counts references.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .jit import unit

_intrinsic: Any = intrinsic
_TUPLE: Any = types.BaseTuple


def pointer_to(value: Any) -> types.Type:
    """Return the type of an address at which ``value`` is packed, for jit.address."""
    return types.CPointer(numba.typeof(value))


def pack(value: Any) -> np.ndarray:
    """Return a buffer that holds ``value``, a tuple of arrays, numbers and such tuples.

    Its address is ``buffer.ctypes.data``. The arrays must outlive it.
    """
    buffer = np.zeros((_size(value) + 7) // 8)
    _write(buffer.ctypes.data, value)
    return buffer


@unit
def _size(value):
    return _size_of(value)


@unit
def _write(where, value):
    _store(where, value)


@_intrinsic
def _size_of(context, value):  # noqa: ARG001
    def generate(context, _builder, signature, _values):
        size = context.get_abi_sizeof(context.get_value_type(signature.args[0]))
        return ir.Constant(ir.IntType(64), size)

    return types.int64(value), generate


@_intrinsic
def _store(context, where, value):  # noqa: ARG001
    def generate(_context, builder, _signature, values):
        target = builder.inttoptr(values[0], values[1].type.as_pointer())
        builder.store(values[1], target)

    return types.void(where, value), generate


@_intrinsic
def load(context, where):  # noqa: ARG001
    """Return what is packed at an address (type ``pointer_to``), its arrays borrowed."""

    def generate(context, builder, signature, values):
        kind = signature.return_type
        target = builder.bitcast(values[0], context.get_value_type(kind).as_pointer())
        return _fields(context, builder, kind, target)

    return where.dtype(where), generate


def _fields(context: Any, builder: Any, kind: Any, target: Any) -> Any:
    """Return the value of a type at an address, loaded field by field: unused ones vanish."""
    if isinstance(kind, _TUPLE):
        value = ir.Constant(context.get_value_type(kind), ir.Undefined)
        for i, part in enumerate(kind):
            place = cgutils.gep_inbounds(builder, target, 0, i)
            value = builder.insert_value(value, _fields(context, builder, part, place), i)
        return value
    if isinstance(kind, types.Array):
        stored = context.make_array(kind)(context, builder, ref=target)
        array = context.make_array(kind)(context, builder)
        for name in ("nitems", "itemsize", "data", "shape", "strides"):
            setattr(array, name, getattr(stored, name))
        # no owner: counting references of a borrowed array is optimised away
        for name in ("meminfo", "parent"):
            setattr(array, name, cgutils.get_null_value(getattr(array, name).type))
        return array._getvalue()
    return builder.load(target)
