"""Four numbers of four segments side by side, in one register.

Most of what a sweep computes for a segment (its exponential, its tangent map, the force dual to it)
does not depend on other segments. A value of type ``Lanes`` holds one number of four of them, and
the algebra of dual.py, compiled for it, treats four segments with the instructions for one. Every
lane gives the same bits as single numbers would, on any processor: vectors are split where
registers are shorter.

Arrays keep a row for every segment. Four rows are read and written in blocks of four by four
numbers, which are transposed in registers; the last rows are repeated where there are fewer.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from soft_sim_ros.core.backend.jit import kernel

WIDTH = 4
_intrinsic: Any = intrinsic
_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, WIDTH)
_INDEX = ir.IntType(32)


class _Lanes(types.Type):
    """The type of four float64."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = _Lanes()
_register: Any = register_model


@_register(_Lanes)
class _Model(models.PrimitiveModel):
    """A vector register."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _splat(builder: Any, number: Any) -> Any:
    """Return a vector of four times the same number."""
    if isinstance(number, ir.Constant):
        return ir.Constant(_VECTOR, [number.constant] * WIDTH)
    single = builder.insert_element(
        ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(_INDEX, 0)
    )
    mask = ir.Constant(ir.VectorType(_INDEX, WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(single, ir.Constant(_VECTOR, ir.Undefined), mask)


def _vector(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return a vector, made from a vector or from one number."""
    if kind is LANES:
        return value
    return _splat(builder, context.cast(builder, value, kind, types.float64))


def _binary(function: Any, instruction: str) -> None:
    """Let ``function`` take lanes and numbers."""
    pairs = ((LANES, LANES), (LANES, types.float64), (types.float64, LANES))
    template: Any = ConcreteTemplate

    class Typing(template):
        key = function
        cases = tuple(signature(LANES, *pair) for pair in pairs)

    infer_global(function)(Typing)

    def lower(context, builder, sig, args):
        left, right = (
            _vector(context, builder, *each) for each in zip(sig.args, args, strict=True)
        )
        return getattr(builder, instruction)(left, right)

    for pair in pairs:
        lower_builtin(function, *pair)(lower)


_binary(operator.add, "fadd")
_binary(operator.sub, "fsub")
_binary(operator.mul, "fmul")
_binary(operator.truediv, "fdiv")


class _Negation(ConcreteTemplate):
    key = operator.neg
    cases = (signature(LANES, LANES),)


infer_global(operator.neg)(_Negation)


@lower_builtin(operator.neg, LANES)
def _negate(_context, builder, _sig, args):
    return builder.fneg(args[0])


@_intrinsic
def fused(context, factor, b, c):
    """Return factor · b + c, rounded once; factor: a number or lanes."""

    def generate(context, builder, sig, args):
        kind = ir.FunctionType(_VECTOR, [_VECTOR] * 3)
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.fma.v{WIDTH}f64")
        a = _vector(context, builder, sig.args[0], args[0])
        return builder.call(function, [a, args[1], args[2]])

    return LANES(factor, LANES, LANES), generate


@_intrinsic
def lanes_of(context, values):
    """Return a tuple of lanes, of lanes and numbers."""

    def generate(context, builder, sig, args):
        parts = [
            _vector(context, builder, kind, builder.extract_value(args[0], i))
            for i, kind in enumerate(sig.args[0])
        ]
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(LANES, len(values))(values), generate


# ---- rows of arrays ----------------------------------------------------------------------------


@kernel
def lanes_from(k, count):
    """Return the rows of four lanes from row k on, of ``count`` in all."""
    last = count - 1
    return (k, min(k + 1, last), min(k + 2, last), min(k + 3, last))


def _place(context: Any, builder: Any, kind: Any, value: Any, row: Any, at: Any) -> Any:
    """Return a pointer to number ``at`` of a row (of the first axis) of an array."""
    array = context.make_array(kind)(context, builder, value=value)
    start = builder.mul(row, builder.extract_value(array.strides, 0))
    start = builder.add(start, builder.mul(at, ir.Constant(at.type, 8)))
    return builder.gep(builder.bitcast(array.data, cgutils.voidptr_t), [start])


def _mask(*places: int) -> Any:
    return ir.Constant(ir.VectorType(_INDEX, WIDTH), list(places))


def _transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """Return the columns of four vectors."""
    a, b, c, d = rows
    low, high = _mask(0, 4, 2, 6), _mask(1, 5, 3, 7)
    ab0, ab1 = builder.shuffle_vector(a, b, low), builder.shuffle_vector(a, b, high)
    cd0, cd1 = builder.shuffle_vector(c, d, low), builder.shuffle_vector(c, d, high)
    first, second = _mask(0, 1, 4, 5), _mask(2, 3, 6, 7)
    return [
        builder.shuffle_vector(ab0, cd0, first),
        builder.shuffle_vector(ab1, cd1, first),
        builder.shuffle_vector(ab0, cd0, second),
        builder.shuffle_vector(ab1, cd1, second),
    ]


@_intrinsic
def four(context, array, rows, at):
    """Return numbers ``at`` … ``at + 3`` of four rows as four lanes."""

    def generate(context, builder, sig, args):
        read = []
        for i in range(WIDTH):
            row = builder.extract_value(args[1], i)
            place = _place(context, builder, sig.args[0], args[0], row, args[2])
            read.append(builder.load(builder.bitcast(place, _VECTOR.as_pointer()), align=8))
        columns = _transposed(builder, read)
        return context.make_tuple(builder, sig.return_type, columns)

    return types.UniTuple(LANES, WIDTH)(array, rows, types.intp), generate


@_intrinsic
def keep(context, array, rows, at, values):
    """Write lanes, or numbers for all of them, as numbers ``at``, ``at + 1`` … of four rows.

    At least four; the last four may overlap others.
    """

    def generate(context, builder, sig, args):
        parts = [
            _vector(context, builder, kind, builder.extract_value(args[3], i))
            for i, kind in enumerate(sig.args[3])
        ]
        firsts = [*range(0, len(parts) - WIDTH, WIDTH), len(parts) - WIDTH]
        for first in firsts:
            begin = builder.add(args[2], ir.Constant(args[2].type, first))
            for i, lanes in enumerate(_transposed(builder, parts[first : first + WIDTH])):
                row = builder.extract_value(args[1], i)
                place = _place(context, builder, sig.args[0], args[0], row, begin)
                builder.store(lanes, builder.bitcast(place, _VECTOR.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.none(array, rows, types.intp, values), generate


@_intrinsic
def each(context, array, rows, at):
    """Return number ``at`` of four rows."""

    def generate(context, builder, sig, args):
        out = ir.Constant(_VECTOR, ir.Undefined)
        for i in range(WIDTH):
            row = builder.extract_value(args[1], i)
            place = _place(context, builder, sig.args[0], args[0], row, args[2])
            number = builder.load(builder.bitcast(place, _DOUBLE.as_pointer()), align=8)
            out = builder.insert_element(out, number, ir.Constant(_INDEX, i))
        return out

    return LANES(array, rows, types.intp), generate


@_intrinsic
def one(context, array, row, at):
    """Return the lanes that lie together from number ``at`` of a row on."""

    def generate(context, builder, sig, args):
        place = _place(context, builder, sig.args[0], *args)
        return builder.load(builder.bitcast(place, _VECTOR.as_pointer()), align=8)

    return LANES(array, types.intp, types.intp), generate


@_intrinsic
def keep_one(context, array, row, at, value):
    """Write lanes together from number ``at`` of a row on."""

    def generate(context, builder, sig, args):
        place = _place(context, builder, sig.args[0], *args[:3])
        value = _vector(context, builder, sig.args[3], args[3])
        builder.store(value, builder.bitcast(place, _VECTOR.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.none(array, types.intp, types.intp, value), generate


@_intrinsic
def lane(context, value, i):
    """Return one of four lanes."""

    def generate(context, builder, sig, args):
        return builder.extract_element(args[0], builder.trunc(args[1], _INDEX))

    return types.float64(LANES, types.intp), generate


@kernel
def largest_lane(value):
    """Return the largest of four lanes."""
    a, b = max(lane(value, 0), lane(value, 1)), max(lane(value, 2), lane(value, 3))
    return max(a, b)


@kernel
def sum_of(value):
    """Return the sum of four lanes."""
    return (lane(value, 0) + lane(value, 1)) + (lane(value, 2) + lane(value, 3))


@kernel
def padded(m):
    """Return the next multiple of four."""
    return (m + WIDTH - 1) // WIDTH * WIDTH


@kernel
def six(array, rows, at):
    """Return numbers ``at`` … ``at + 5`` of four rows as six lanes."""
    a, b = four(array, rows, at), four(array, rows, at + 2)
    return (a[0], a[1], a[2], a[3], b[2], b[3])


@kernel
def three(array, rows, at):
    """Return numbers ``at`` … ``at + 2`` of four rows as three lanes, and read no others."""
    return (each(array, rows, at), each(array, rows, at + 1), each(array, rows, at + 2))


@kernel
def nine(array, rows, at):
    """Return numbers ``at`` … ``at + 8`` of four rows as nine lanes."""
    a, b = four(array, rows, at), four(array, rows, at + 4)
    return (a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], each(array, rows, at + 8))
