"""Bounds of a formula on intervals: what it can be at most and at least, not only at samples.

Interval arithmetic (Moore, Interval Analysis, 1966): every operation maps intervals to an interval
that holds all its values. A formula that uses s more than once may get bounds that are too wide;
they close in on the true ones as the intervals get short. Round-off is not bounded.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

import numpy as np

from soft_sim_ros.scene.expression import FUNCTIONS, Expression
from soft_sim_ros.scene.taper import Floats

Bounds = tuple[Floats, Floats]

RISING = {"exp", "log", "sqrt", "sinh", "tanh", "atan"}


def enclose(formula: Expression, begin: Floats, end: Floats) -> Bounds:
    """Return lower and upper bounds (N,) of a formula on intervals of arc length (N,) in m.

    They are infinite where it may be undefined.
    """
    with np.errstate(all="ignore"):
        return _value(formula.tree, (begin, end))


def _value(node: ast.expr, s: Bounds) -> Bounds:
    if isinstance(node, ast.Constant):
        return _point(np.float64(node.value), s)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return s if node.id == "s" else _point(np.float64(np.pi), s)
    if isinstance(node, ast.UnaryOp):
        low, high = _value(node.operand, s)
        return (-high, -low) if isinstance(node.op, ast.USub) else (low, high)
    if isinstance(node, ast.BinOp):
        return _sure(_BINARY[type(node.op)](_value(node.left, s), _value(node.right, s)))
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)  # as Expression checked
    return _sure(_applied(node.func.id, _value(node.args[0], s)))


def _point(value: np.float64, s: Bounds) -> Bounds:
    same = np.full(np.shape(s[0]), value)
    return same, same


def _sure(bounds: Bounds) -> Bounds:
    """Return bounds that are infinite instead of undefined."""
    low, high = bounds
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def _hull(*ends: Floats) -> Bounds:
    stacked = np.stack(ends)
    unknown = np.isnan(stacked).any(axis=0)
    return (
        np.where(unknown, -np.inf, stacked.min(axis=0)),
        np.where(unknown, np.inf, stacked.max(axis=0)),
    )


def _times(a: Bounds, b: Bounds) -> Bounds:
    return _hull(*(x * y for x in a for y in b))


def _over(a: Bounds, b: Bounds) -> Bounds:
    low, high = _hull(*(x / y for x in a for y in b))
    zero = (b[0] <= 0.0) & (b[1] >= 0.0)
    return np.where(zero, -np.inf, low), np.where(zero, np.inf, high)


def _power(a: Bounds, b: Bounds) -> Bounds:
    low, high = _hull(*(x**y for x in a for y in b))  # right where a > 0: monotone in each
    whole = (b[0] == b[1]) & (b[0] == np.round(b[0]))
    across = (a[0] < 0.0) & (a[1] > 0.0)
    even = whole & (np.mod(b[0], 2.0) == 0.0)
    low = np.where(across & even, np.minimum(low, 0.0), low)
    unknown = (a[0] < 0.0) & ~whole
    unknown |= (a[0] <= 0.0) & (a[1] >= 0.0) & (b[0] < 0.0)
    return np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)


def _applied(name: str, a: Bounds) -> Bounds:
    low, high = a
    if name in RISING:
        return FUNCTIONS[name](low), FUNCTIONS[name](high)
    if name == "cosh":
        below, above = _hull(np.cosh(low), np.cosh(high))
        return np.where((low < 0.0) & (high > 0.0), 1.0, below), above
    if name == "tan":
        pole = np.floor(low / np.pi + 0.5) != np.floor(high / np.pi + 0.5)
        return np.where(pole, -np.inf, np.tan(low)), np.where(pole, np.inf, np.tan(high))
    top = 0.5 * np.pi if name == "sin" else 0.0
    below, above = _hull(FUNCTIONS[name](low), FUNCTIONS[name](high))
    # is there a whole k with top + 2πk, or top + π + 2πk, in between?
    highest = np.floor((high - top) / (2.0 * np.pi)) >= np.ceil((low - top) / (2.0 * np.pi))
    lowest = np.floor((high - top) / (2.0 * np.pi) - 0.5) >= np.ceil(
        (low - top) / (2.0 * np.pi) - 0.5
    )
    return np.where(lowest, -1.0, below), np.where(highest, 1.0, above)


_BINARY: dict[type, Callable[[Bounds, Bounds], Bounds]] = {
    ast.Add: lambda a, b: (a[0] + b[0], a[1] + b[1]),
    ast.Sub: lambda a, b: (a[0] - b[1], a[1] - b[0]),
    ast.Mult: _times,
    ast.Div: _over,
    ast.Pow: _power,
}
