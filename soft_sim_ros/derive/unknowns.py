"""The symbols of the scalar equations, and how to differentiate what is made of them.

A prime is ∂/∂σ and a dot ∂/∂t, as in the paper. Derivatives are symbols of their own, so an
expression is a plain function of numbers.
"""

from __future__ import annotations

import sympy
from sympy import Expr, Symbol

NAMES = ("x", "y", "z", "psi1", "psi2", "psi3")
COMPONENTS = ("M_x", "M_y", "M_z", "N_x", "N_y", "N_z")

S = sympy.Symbol("s", real=True)  # arc length σ of the reference curve


def _symbols(names: tuple[str, ...], end: str = "") -> tuple[Symbol, ...]:
    return tuple(Symbol(name + end, real=True) for name in names)


VALUE = _symbols(NAMES)
SLOPE = _symbols(NAMES, "_s")  # ∂/∂σ
RATE = _symbols(NAMES, "_t")  # ∂/∂t
ACCELERATION = _symbols(NAMES, "_tt")
WRENCH = _symbols(COMPONENTS)  # internal wrench Λ = (M; N)
WRENCH_SLOPE = _symbols(COMPONENTS, "_s")
LOAD = _symbols(("m_x", "m_y", "m_z", "n_x", "n_y", "n_z"))  # F per length
INERTIA = _symbols(("J_x", "J_y", "J_z", "m"))  # per length: kg·m about the axes, kg/m
REFERENCE = _symbols(("K0_x", "K0_y", "K0_z", "G0_x", "G0_y", "G0_z"))  # a general ξ₀ = (K₀; Γ₀)

# every argument of the equations, by group, in the order of the numpy functions
GROUPS: dict[str, tuple[Symbol, ...]] = {
    "unknowns": VALUE,
    "slopes": SLOPE,
    "rates": RATE,
    "accelerations": ACCELERATION,
    "wrench": WRENCH,
    "wrench_slope": WRENCH_SLOPE,
    "inertia": INERTIA,
    "load": LOAD,
}


def time_derivative(expression: Expr) -> Expr:
    """Return d/dt of a function of the unknowns and their rates."""
    by_value = sum(expression.diff(u) * r for u, r in zip(VALUE, RATE, strict=True))
    by_rate = sum(expression.diff(r) * a for r, a in zip(RATE, ACCELERATION, strict=True))
    return by_value + by_rate
