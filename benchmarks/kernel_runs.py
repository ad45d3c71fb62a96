"""Kernels of a simulation one by one, over and over: what limit.py times and counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from soft_sim_ros.core.backend.jit import (
    _call,
    _intrinsic,
    address,
    bare,
    call_residual,
    call_tangent,
)
from soft_sim_ros.core.integrators.problem import RESIDUAL, TANGENT
from soft_sim_ros.core.recursion import elimination, rnea, tangent
from soft_sim_ros.core.settled import Simulation

from .counting import Counted


@_intrinsic
def call_factor(context, where, model, matrix):
    """Call factor(model, matrix) by address."""
    return _call(numba.types.boolean, where, (model, matrix))


@_intrinsic
def call_solve(context, where, model, matrix, x):
    """Call solve(model, matrix, x) by address."""
    return _call(numba.types.none, where, (model, matrix, x))


@numba.njit
def _residuals(where, count, model, data, q, v, a, r):
    for _ in range(count):
        call_residual(where, model, data, q, v, a, r)


@numba.njit
def _tangents(where, count, model, data, alpha, matrix):
    for _ in range(count):
        call_tangent(where, model, data, alpha, matrix)


@numba.njit
def _factors(where, count, model, matrix, kept):
    for _ in range(count):
        for i in range(len(kept)):
            matrix.diagonal[i] = kept[i]
        call_factor(where, model, matrix)


@numba.njit
def _solutions(where, count, model, matrix, x, kept):
    for _ in range(count):
        for i in range(len(kept)):
            x[i] = kept[i]
        call_solve(where, model, matrix, x)


@numba.njit(error_model="numpy")
def _strains(count, model, data, q, v, a, r):
    q, v, a = bare(q), bare(v), bare(a)
    for _ in range(count):
        rnea.strains(model, data, q, v, a)


@numba.njit(error_model="numpy")
def _kinematics(count, model, data, q, v, a, r):
    for _ in range(count):
        rnea.kinematics(model, data)


@numba.njit(error_model="numpy")
def _project(count, model, data, q, v, a, r):
    r = bare(r)
    for _ in range(count):
        rnea.project(model, data, r)


@numba.njit(error_model="numpy")
def _internal(count, model, data, q, v, a, r):
    q, v, r = bare(q), bare(v), bare(r)
    for _ in range(count):
        rnea.internal_forces(model, q, v, r)


PARTS = {
    "strains at Gauss points": _strains,
    "motion, base to tip": _kinematics,
    "wrenches, tip to base": _project,
    "internal forces": _internal,
}


def units(simulation: Simulation) -> dict[str, tuple[Any, int, Callable[[int, int], None]]]:
    """Return for each unit its function, its address and a run of it (address, times)."""
    problem = simulation._problem
    model, data, work = problem.model, problem.data, problem.work
    state = (work.q, work.v, work.a, work.residual)
    matrix, x = work.system, work.residual.copy()
    gamma = problem.method.tableau[0, 0] * simulation.step_ns * 1e-9
    alpha = (gamma * gamma, gamma, 1.0)
    call_at = {
        "residual": int(problem.calls[RESIDUAL]),
        "tangent": int(problem.calls[TANGENT]),
        "factor": address(elimination.factor, model, matrix),
        "solve": address(elimination.solve, model, matrix, x),
    }
    _residuals(call_at["residual"], 1, model, data, *state)
    _tangents(call_at["tangent"], 1, model, data, alpha, matrix)
    kept, right = matrix.diagonal.copy(), work.residual.copy()
    return {
        "residual": (
            rnea.inverse_dynamics,
            call_at["residual"],
            lambda at, count: _residuals(at, count, model, data, *state),
        ),
        "tangent": (
            tangent.tangent,
            call_at["tangent"],
            lambda at, count: _tangents(at, count, model, data, alpha, matrix),
        ),
        "factor": (
            elimination.factor,
            call_at["factor"],
            lambda at, count: _factors(at, count, model, matrix, kept),
        ),
        "solve": (
            elimination.solve,
            call_at["solve"],
            lambda at, count: _solutions(at, count, model, matrix, x, right),
        ),
    }


def known_count() -> dict[str, float]:
    """Return what is counted in a 6x6 product, which has 216 products and 216 sums."""
    a, b, c = np.random.default_rng(0).normal(size=(3, 6, 6))
    _product(a, b, c)
    copy = Counted(next(iter(_product.overloads.values())))
    _run_product(copy.address, a, b, c)
    return {"fmul": copy.counts()["fmul"], "fadd": copy.counts()["fadd"]}


@numba.njit(error_model="numpy")
def _product(a, b, c):
    for i in range(6):
        for j in range(6):
            total = 0.0
            for k in range(6):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@_intrinsic
def _call_product(context, where, a, b, c):
    return _call(numba.types.none, where, (a, b, c))


@numba.njit
def _run_product(where, a, b, c):
    _call_product(where, a, b, c)
