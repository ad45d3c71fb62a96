"""Derived equations as text, as LaTeX and as the source of a numpy module."""

from __future__ import annotations

import re

import sympy
from sympy import Expr, Symbol
from sympy.printing.numpy import NumPyPrinter

from soft_sim_ros.derive.equations import Derivation
from soft_sim_ros.derive.unknowns import (
    ACCELERATION,
    GROUPS,
    LOAD,
    RATE,
    SLOPE,
    VALUE,
    WRENCH,
    WRENCH_SLOPE,
)

TITLES = ("moment_x", "moment_y", "moment_z", "force_x", "force_y", "force_z")
KINEMATICS = ("strain", "twist", "acceleration")


def as_text(derivation: Derivation) -> str:
    """Return all expressions, one line each, in SymPy's notation.

    ``_s`` is ∂/∂σ and ``_t`` ∂/∂t.
    """
    lines = [_head(derivation)]
    for name in KINEMATICS:
        entries = getattr(derivation, name)
        lines += [f"{name}[{i}] = {entry}" for i, entry in enumerate(entries)]
    for title, entry in zip(TITLES, derivation.equations, strict=True):
        lines.append(f"{title}: 0 = {entry}")
    return "\n".join(lines) + "\n"


def as_latex(derivation: Derivation) -> str:
    """Return the six equations as a LaTeX align environment: primes and dots, c_i and s_i."""
    names = _latex_names()
    rows = [
        "0 &= " + sympy.latex(_short(entry), symbol_names=names, order="none")
        for entry in derivation.equations
    ]
    note = "% c_i = cos psi_i, s_i = sin psi_i; moments first, in the section's axes"
    body = " \\\\\n".join(rows)
    return f"% {_head(derivation)}\n{note}\n\\begin{{align}}\n{body}\n\\end{{align}}\n"


def as_python(derivation: Derivation) -> str:
    """Return the source of a module with ``residual(…)``, needing numpy only."""
    groups = derivation.groups
    printer = NumPyPrinter({"fully_qualified_modules": True, "allow_unknown_functions": False})
    common, reduced = sympy.cse(derivation.equations, sympy.numbered_symbols("_a"))
    lines = [f'"""{_head(derivation)}"""', "", "import numpy", "", ""]
    lines.append(f"def residual({', '.join(groups)}):")
    lines += [
        '    """Return six residuals (6, ...): moments, then forces, in the section\'s axes.',
        "",
        "    Each argument holds its components along the first axis:",
        "",
    ]
    used = [name for name in groups if name in GROUPS]
    lines += [f"    {name}: {' '.join(map(str, groups[name]))}" for name in used]
    lines += ['    """']
    lines += [f"    {', '.join(map(str, groups[name]))} = {name}" for name in used]
    lines += [f"    {symbol} = {printer.doprint(entry)}" for symbol, entry in common]
    lines += ["    return numpy.array(", "        numpy.broadcast_arrays("]
    lines += [f"            {printer.doprint(entry)}," for entry in reduced]
    lines += ["        )", "    )", ""]
    return "\n".join(lines)


def _head(derivation: Derivation) -> str:
    reference = ", ".join(map(str, derivation.reference))
    return (
        f"Cosserat rod, rotations {derivation.rotations}, reference strain ({reference}): "
        "soft_sim_ros derive"
    )


def _short(entry: Expr) -> Expr:
    """Return an expression with c_i and s_i for the cosines and sines of the angles."""
    names = {}
    for i, angle in enumerate(VALUE[3:], start=1):
        names[sympy.cos(angle)] = Symbol(f"c_{i}")
        names[sympy.sin(angle)] = Symbol(f"s_{i}")
    return entry.xreplace(names)


def _latex_names() -> dict[Symbol, str]:
    """Return how every symbol is written."""
    names: dict[Symbol, str] = {}
    plain = [re.sub(r"psi(\d)", r"\\psi_{\1}", str(symbol)) for symbol in VALUE]
    for i, text in enumerate(plain):
        names[VALUE[i]] = text
        base, _, index = text.partition("_")
        low = f"_{index}" if index else ""
        names[SLOPE[i]] = f"{base}{low}'"
        names[RATE[i]] = f"\\dot{{{base}}}{low}"
        names[ACCELERATION[i]] = f"\\ddot{{{base}}}{low}"
    for symbols, prime in ((WRENCH, ""), (WRENCH_SLOPE, "'"), (LOAD, "")):
        for symbol in symbols:
            letter, axis = str(symbol).split("_")[:2]
            names[symbol] = f"{letter}_{{{axis}}}{prime}"
    return names
