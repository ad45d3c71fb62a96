"""From a rotation sequence and a reference curve to six scalar equations.

This is the program of Curvilinear Systems 2006, section 4.

The section's frame is g = g_r D with D = exp(u) exp(ψ₁ρ¹) exp(ψ₂ρ²) exp(ψ₃ρ³), u = (x, y, z) in the
axes of the reference frame g_r(σ). Only adjoint actions are needed: with w = σ or t, ω_σ = ξ₀ and
ω_t = 0,

    ζ ← ω_w,   ζ ← Ad(exp u)⁻¹ ζ + ∂u/∂w,   ζ ← Ad(exp ψᵢρⁱ)⁻¹ ζ + ∂ψᵢ/∂w ρⁱ,  i = 1, 2, 3

ends in the strain ξ and in the twist η: item 7 of the paper without its slips, and the recursion of
``core/recursion/rnea.py`` over four joints. Angular parts first, as everywhere here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from sympy import Expr, Matrix, Symbol

from soft_sim_ros.derive.unknowns import (
    GROUPS,
    INERTIA,
    LOAD,
    RATE,
    REFERENCE,
    SLOPE,
    VALUE,
    WRENCH,
    WRENCH_SLOPE,
    S,
    time_derivative,
)
from soft_sim_ros.errors import DeriveError

AXES = "xyz"


def skew(w: Matrix) -> Matrix:
    """Return the (3, 3) matrix of w ×."""
    return Matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def ad(x: Matrix) -> Matrix:
    """Return ad_x (6, 6)."""
    w, v = skew(x[:3, 0]), skew(x[3:, 0])
    return Matrix.vstack(Matrix.hstack(w, sympy.zeros(3)), Matrix.hstack(v, w))


def rotation(axis: str, angle: Expr) -> Matrix:
    """Return the rotation by an angle about a coordinate axis.

    Λ₂, Λ₃, Λ₄ of Curvilinear Systems 2006, section 4, item 4.
    """
    i = AXES.index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    out = sympy.eye(3)
    c, s = sympy.cos(angle), sympy.sin(angle)
    out[j, j] = out[k, k] = c
    out[k, j], out[j, k] = s, -s
    return out


@dataclass(frozen=True)
class Derivation:
    """Six scalar equations and the kinematics they are made of.

    Components are those of the section's own axes, angular part first.

    rotations : the axes ρ¹, ρ², ρ³
    reference : strain ξ₀ = (K₀; Γ₀) of the reference curve
    strain, twist, acceleration : ξ, η, η̇
    equations : 𝓜 η̇ − ad_ηᵀ 𝓜 η − Λ′ + ad_ξᵀ Λ − F, zero along a motion: three moments in N,
        three forces in N/m
    parameters : symbols of the reference besides σ, in alphabetical order
    """

    rotations: str
    reference: tuple[Expr, ...]
    strain: tuple[Expr, ...]
    twist: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]
    equations: tuple[Expr, ...]
    parameters: tuple[Symbol, ...]

    @property
    def groups(self) -> dict[str, tuple[Symbol, ...]]:
        """Arguments of the equations by name, in order; the parameters come last."""
        extra = {str(symbol): (symbol,) for symbol in self.parameters}
        return GROUPS | extra

    def function(self) -> Callable[..., Any]:
        """Return residual(unknowns, slopes, …, load, **parameters) in numpy.

        Every argument of GROUPS is an array (6, …), the inertia (4, …), of shapes that broadcast;
        parameters of the reference are numbers or arrays (…). The result is (6, …).
        """
        groups = self.groups
        arguments = [symbol for group in groups.values() for symbol in group]
        compiled = sympy.lambdify(arguments, list(self.equations), "numpy", cse=True)
        expected = [str(symbol) for symbol in self.parameters]

        def residual(*arrays: Any, **parameters: Any) -> Any:
            missing = [name for name in expected if name not in parameters]
            if missing or len(parameters) > len(expected) or len(arrays) != len(GROUPS):
                asked = ", ".join([*GROUPS, *(f"{name}=" for name in expected)])
                raise TypeError(f"residual takes the arguments {asked}")
            rows = [np.asarray(row, dtype=float) for array in arrays for row in array]
            rows += [np.asarray(parameters[name], dtype=float) for name in expected]
            return np.array(np.broadcast_arrays(*compiled(*rows)))

        return residual


def derive(rotations: str = "zyx", reference: str | Sequence[Any] = "straight") -> Derivation:
    """Derive the equations for a rotation sequence and a reference curve.

    Parameters
    ----------
    rotations : three letters out of x, y, z, the axes ρ¹, ρ², ρ³; neighbours differ
    reference : ``straight``; ``general`` for six symbols; or three or six expressions in s and
        in names of parameters: the curvatures K₀ in 1/m and, after them, the Γ₀ (default 1, 0, 0)

    Raises
    ------
    DeriveError
        naming what is wrong.
    """
    _check(rotations)
    xi0 = _reference(reference)
    strain = _carried(rotations, xi0, SLOPE)
    twist = _carried(rotations, sympy.zeros(6, 1), RATE)
    acceleration = twist.applyfunc(time_derivative)
    inertia = sympy.diag(*INERTIA[:3], *[INERTIA[3]] * 3)
    wrench = Matrix(WRENCH)
    left = inertia * acceleration - ad(twist).T * (inertia * twist)
    left += -Matrix(WRENCH_SLOPE) + ad(strain).T * wrench - Matrix(LOAD)
    names = {symbol for entry in xi0 for symbol in entry.free_symbols}
    return Derivation(
        rotations,
        tuple(xi0),
        tuple(strain),
        tuple(twist),
        tuple(acceleration),
        tuple(left.applyfunc(sympy.expand)),
        tuple(sorted(names, key=str)),
    )


def _carried(rotations: str, start: Matrix, change: tuple[Symbol, ...]) -> Matrix:
    """Return the twist (6,) of the section when its coordinates change, and the frame by start."""
    shift = skew(Matrix(VALUE[:3]))
    angular, linear = start[:3, 0], start[3:, 0]
    linear = linear - shift * angular + Matrix(change[:3])
    for axis, angle, rate in zip(rotations, VALUE[3:], change[3:], strict=True):
        turn = rotation(axis, angle).T
        unit = Matrix([1 if axis == other else 0 for other in AXES])
        angular, linear = turn * angular + rate * unit, turn * linear
    return Matrix.vstack(angular, linear)


def _check(rotations: str) -> None:
    fits = len(rotations) == 3 and set(rotations) <= set(AXES)
    if not fits or rotations[0] == rotations[1] or rotations[1] == rotations[2]:
        expected = "three of x, y, z with neighbours that differ, such as zyx or zxz"
        raise DeriveError("rotations", rotations, expected)


def _reference(reference: str | Sequence[Any]) -> Matrix:
    """Return ξ₀ (6, 1)."""
    if reference == "straight":
        return Matrix([0, 0, 0, 1, 0, 0])
    if reference == "general":
        return Matrix(REFERENCE)
    entries = reference.split(",") if isinstance(reference, str) else list(reference)
    entries = [entry.strip() if isinstance(entry, str) else entry for entry in entries]
    expected = (
        "straight, general, or three or six expressions in s such as '0, 0, 1/R': "
        "curvatures, then stretch and shears"
    )
    readable = all(not isinstance(e, str) or _READABLE.fullmatch(e) for e in entries)
    if len(entries) not in (3, 6) or not readable:
        raise DeriveError("reference", reference, expected)
    try:
        found = [sympy.sympify(entry, locals=_NAMES) for entry in entries]
    except (sympy.SympifyError, SyntaxError, TypeError, AttributeError) as error:
        raise DeriveError("reference", reference, expected) from error
    taken = {symbol.name for group in GROUPS.values() for symbol in group}
    for entry in found:
        if not isinstance(entry, Expr):
            raise DeriveError("reference", reference, expected)
        clash = sorted({symbol.name for symbol in entry.free_symbols} & taken)
        if clash:
            raise DeriveError("reference", reference, f"another name than {clash[0]}, an unknown")
    return Matrix([*found, 1, 0, 0] if len(found) == 3 else found)


# SymPy evaluates what it reads: only formulas may get there
_READABLE = re.compile(r"(?!.*__)[\w\s.+\-*/()]+")
_NAMES = {"s": S, **{name: Symbol(name, real=True) for name in ("R", "E", "I", "N", "S", "Q", "O")}}
