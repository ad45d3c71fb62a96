"""Formulas in s: arithmetic and a few functions, nothing else.

A formula is parsed by Python's own parser and walked node by node; names, calls and operators are
those listed here. Nothing is ever evaluated by Python itself.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from soft_sim_ros.scene.taper import Floats

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log,
    "sqrt": np.sqrt, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "atan": np.arctan,
}  # fmt: skip
OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.Pow: operator.pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
LONGEST = 500
DEEPEST = 50


class ExpressionError(ValueError):
    """A formula says something that is not arithmetic."""


class Expression:
    """A formula as a function of arc lengths s (…) in m; it knows s, pi and FUNCTIONS."""

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > LONGEST:
            raise ExpressionError(f"at most {LONGEST} characters")
        try:
            self.tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise ExpressionError("this is not arithmetic") from None
        _value(self.tree, np.zeros(1), 0)

    def __call__(self, s: Floats) -> Floats:
        """Return the values at s, same shape."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(np.asarray(_value(self.tree, s, 0), dtype=float), np.shape(s))


def _value(node: ast.expr, s: Floats, depth: int) -> Any:
    """Return the value of a node; everything is a floating-point number, so powers stay small."""
    if depth > DEEPEST:
        raise ExpressionError("fewer parentheses")
    number = node.value if isinstance(node, ast.Constant) else None
    if isinstance(number, int | float) and not isinstance(number, bool):
        try:
            return np.float64(number)
        except OverflowError:
            raise ExpressionError("numbers below 1.8e308, all of them") from None
    if isinstance(node, ast.Name) and node.id in ("s", "pi"):
        return s if node.id == "s" else np.pi
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        left, right = (_value(part, s, depth + 1) for part in (node.left, node.right))
        with np.errstate(all="ignore"):
            return OPERATORS[type(node.op)](left, right)
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATORS:
        return OPERATORS[type(node.op)](_value(node.operand, s, depth + 1))
    if isinstance(node, ast.Call) and len(node.args) == 1 and not node.keywords:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name in FUNCTIONS:
            with np.errstate(all="ignore"):
                return FUNCTIONS[name](_value(node.args[0], s, depth + 1))
    written = ast.unparse(node)
    known = f"s, pi, numbers, + - * / **, {' '.join(FUNCTIONS)}"
    raise ExpressionError(f"{written!r} is not among {known}")
