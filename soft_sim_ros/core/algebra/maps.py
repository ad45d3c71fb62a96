"""Matrices with a row for every component of a twist: six in space, three in a plane.

Columns, and the numbers written from four segments at once, come in lanes (lanes.py).
"""

from soft_sim_ros.core.backend.jit import algebra

from .simd import fused, keep, keep_one, lanes_of, one
from .spaces import Mask, per_space


def column_of(space, rows, j):
    """Return column j of a matrix of twists."""


def keep_wrench_column(space, rows, j, moment, force):
    """Write column j of a matrix of wrenches (M; N)."""


def stack_of(space, rows, begin, j):
    """Return the rows from ``begin`` on, one for every component, of four columns from j on."""


def weighed(space, weights, i, j, down, factor, stack, total):
    """Return total + factor × Σ_c w_c stack[c]; w: weights from (i, j) on, along a row or down."""


def keep_motion(space, out, rows, at, m):
    """Write the dual matrix m, a map of all six components of a twist, transposed.

    Row c of (6, 20) gets the twist per unit of component c from ``at`` on; the numbers behind it
    are overwritten.
    """


def keep_hankel(space, out, rows, at, m):
    """Write the dual matrix m, a map from twists (w, v) to wrenches (M, N), transposed.

    Row c of (6, 12) gets the wrench per unit of component c from ``at`` on.
    """


def keep_blocks(space, out, rows, at, blocks):
    """Write 3x3 blocks (ww, wv, vw, vv) of a map from twists to wrenches.

    Rows and columns are those of the space, in rows of eight numbers.
    """


def _places(turns: Mask, moves: Mask) -> list[int]:
    """Return the row of every one of the six components, -1 if it has none."""
    present = [*turns, *moves]
    return [sum(present[:c]) if present[c] else -1 for c in range(6)]


def add_blocks(space, out, at, blocks):
    """Add 3x3 blocks (ww, wv, vw, vv) of a map from twists to wrenches to rows from ``at`` on.

    Of one matrix: rows and columns are those of the space.
    """


@per_space(column_of)
def _column(turns: Mask, moves: Mask):
    a, b, c, x, y, z = _places(turns, moves)

    def column(space, rows, j):
        return (
            (
                one(rows, a, j) if a >= 0 else 0.0,
                one(rows, b, j) if b >= 0 else 0.0,
                one(rows, c, j) if c >= 0 else 0.0,
            ),
            (
                one(rows, x, j) if x >= 0 else 0.0,
                one(rows, y, j) if y >= 0 else 0.0,
                one(rows, z, j) if z >= 0 else 0.0,
            ),
        )

    return column


@per_space(keep_wrench_column)
def _keep_wrench_column(turns: Mask, moves: Mask):
    a, b, c, x, y, z = _places(turns, moves)

    def keep_column(space, rows, j, moment, force):
        if a >= 0:
            keep_one(rows, a, j, moment[0])
        if b >= 0:
            keep_one(rows, b, j, moment[1])
        if c >= 0:
            keep_one(rows, c, j, moment[2])
        if x >= 0:
            keep_one(rows, x, j, force[0])
        if y >= 0:
            keep_one(rows, y, j, force[1])
        if z >= 0:
            keep_one(rows, z, j, force[2])

    return keep_column


@per_space(stack_of)
def _stack(turns: Mask, moves: Mask):
    if all(turns):
        return lambda space, rows, b, j: (
            one(rows, b, j), one(rows, b + 1, j), one(rows, b + 2, j),
            one(rows, b + 3, j), one(rows, b + 4, j), one(rows, b + 5, j),
        )  # fmt: skip
    return lambda space, rows, b, j: (one(rows, b, j), one(rows, b + 1, j), one(rows, b + 2, j))


@per_space(weighed)
def _weighed(turns: Mask, moves: Mask):
    def plane(space, w, i, j, down, factor, stack, total):
        right = 1 - down
        total = fused(factor * w[i, j], stack[0], total)
        total = fused(factor * w[i + down, j + right], stack[1], total)
        return fused(factor * w[i + 2 * down, j + 2 * right], stack[2], total)

    half = algebra(plane)

    def spatial(space, w, i, j, down, factor, stack, total):
        right = 1 - down
        total = half(space, w, i, j, down, factor, stack, total)
        total = fused(factor * w[i + 3 * down, j + 3 * right], stack[3], total)
        total = fused(factor * w[i + 4 * down, j + 4 * right], stack[4], total)
        return fused(factor * w[i + 5 * down, j + 5 * right], stack[5], total)

    return spatial if all(turns) else plane


def _axes(present: Mask) -> tuple[int, ...]:
    return tuple(i for i in range(3) if present[i])


def _twist_part(turns: Mask, moves: Mask):
    """Return a function that gives the numbers of a twist that its space has, and zeros."""
    if all(turns):
        return lambda w, v: (w[0], w[1], w[2], v[0], v[1], v[2])
    (a,), (x, y) = _axes(turns), _axes(moves)
    return lambda w, v: (w[a], v[x], v[y], 0.0)


@algebra
def _line(m, i):
    return (m[3 * i], m[3 * i + 1], m[3 * i + 2])


@algebra
def _pile(m, j):
    return (m[j], m[3 + j], m[6 + j])


@per_space(keep_motion)
def _keep_motion(turns: Mask, moves: Mask):
    row_of = algebra(_twist_part(turns, moves))

    def keep_map(space, out, rows, at, m):
        a, b = lanes_of(m[0]), lanes_of(m[1])
        zero = lanes_of((0.0, 0.0, 0.0))
        for j in range(3):
            keep(out, rows, at + 20 * j, row_of(_pile(a, j), _pile(b, j)))
            keep(out, rows, at + 20 * (3 + j), row_of(zero, _pile(a, j)))

    return keep_map


@per_space(keep_hankel)
def _keep_hankel(turns: Mask, moves: Mask):
    def keep_map(space, out, rows, at, m):
        a, b = lanes_of(m[0]), lanes_of(m[1])
        zero = lanes_of((0.0, 0.0, 0.0))
        for j in range(3):
            keep(out, rows, at + 12 * j, _pile(b, j) + _pile(a, j))
            keep(out, rows, at + 12 * (3 + j), _pile(a, j) + zero)

    return keep_map


@per_space(keep_blocks)
def _keep_blocks(turns: Mask, moves: Mask):
    angular, linear, place = _axes(turns), _axes(moves), tuple(_places(turns, moves))
    row_of = algebra(_twist_part(turns, moves))

    def keep_map(space, out, rows, at, blocks):
        ww, wv = lanes_of(blocks[0]), lanes_of(blocks[1])
        vw, vv = lanes_of(blocks[2]), lanes_of(blocks[3])
        for i in angular:
            keep(out, rows, at + 8 * place[i], row_of(_line(ww, i), _line(wv, i)))
        for i in linear:
            keep(out, rows, at + 8 * place[3 + i], row_of(_line(vw, i), _line(vv, i)))

    return keep_map


@per_space(add_blocks)
def _add_blocks(turns: Mask, moves: Mask):
    angular, linear, place = _axes(turns), _axes(moves), tuple(_places(turns, moves))

    def add_map(space, out, at, blocks):
        ww, wv, vw, vv = blocks
        for i in angular:
            for j in angular:
                out[at + place[i], place[j]] += ww[3 * i + j]
            for j in linear:
                out[at + place[i], place[3 + j]] += wv[3 * i + j]
        for i in linear:
            for j in angular:
                out[at + place[3 + i], place[j]] += vw[3 * i + j]
            for j in linear:
                out[at + place[3 + i], place[3 + j]] += vv[3 * i + j]

    return add_map
