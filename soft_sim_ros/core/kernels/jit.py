"""Compile a function to machine code, with a cache on disk that can never be stale.

Numba keys its cache on the file of the function alone, so an edit to a function *called* by a
cached one would go unnoticed. Here the cache folder carries a digest of every kernel source, and
lies in the user's cache directory, so a read-only installation works too.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import cgutils
from numba.core import config as _config
from numba.extending import intrinsic

numba_config: Any = _config  # its settings are set at import, out of sight of type checkers
F = TypeVar("F", bound=Callable[..., Any])


def _digest() -> str:
    """Digest of all kernel sources and the numba version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Folder of the compiled kernels of exactly these sources.

    ``NUMBA_CACHE_DIR``, then ``XDG_CACHE_HOME``, then ``~/.cache`` are asked in this order.
    """
    root = os.environ.get("NUMBA_CACHE_DIR") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "soft_sim_ros"
    )
    return Path(root) / f"kernels-{_digest()}"


_CACHE = str(cache_directory())
_intrinsic: Any = intrinsic
_options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy"}
# Algebra may take 0·x = 0 and x + 0 = x: bits of finite numbers stay as they are, up to the sign of
# zeros, and literal zeros vanish from compiled code (spaces.py).
ALGEBRA: dict[str, Any] = {
    "error_model": "numpy",
    "forceinline": True,
    "fastmath": {"nnan", "nsz"},
}
_TUPLE: Any = numba.types.BaseTuple
# Inlined code is never called from Python: wrappers would take most of the time of compilation.
_BARE: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_inlined: Any = numba.njit(**_options, **_BARE)
_algebra: Any = numba.njit(**(_options | ALGEBRA | _BARE))
_unit: Any = numba.njit(**_options)


def kernel(function: F) -> F:
    """Compile ``function`` without the GIL, cached, in strict IEEE arithmetic, inlined in others.

    Strict, because a kernel is compiled anew wherever it is inlined and any copy may be the one
    that runs: only without fused or reordered operations do all copies give the same bits, which
    is what re-simulation relies on. It costs nothing that can be measured.
    """
    return _cached(_inlined, function)


def algebra(function: F) -> F:
    """Compile like ``kernel``, for arithmetic that may rely on all numbers being finite.

    Nothing may be tested for NaN in it.
    """
    return _cached(_algebra, function)


def unit(function: F) -> F:
    """Compile like ``kernel``, but as a function of its own: one that Python calls, or a large one.

    Arrays that enter a unit should go through ``bare`` first.
    """
    return _cached(_unit, function)


def _cached(compile_: Any, function: F) -> F:
    """Apply a compiling decorator so that it writes to the folder of exactly these sources."""
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = _CACHE
    try:
        return compile_(function)  # the cache folder is chosen here, once
    finally:
        numba_config.CACHE_DIR = before


def address(function: Any, *arguments: Any) -> int:
    """Return the address of a kernel compiled for the types of ``arguments``.

    An argument may also be a type itself. Together with the callers below this keeps large kernels
    in compilation units of their own: numba would otherwise optimise the whole tree below a kernel
    anew in each of its callers.
    """
    signature = tuple(
        argument if isinstance(argument, numba.types.Type) else numba.typeof(argument)
        for argument in arguments
    )
    if signature not in function.overloads:
        function.compile(signature)
    result = function.overloads[signature]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def _call(
    returns: Any, where: Any, arguments: tuple[Any, ...], pointers: int = 0
) -> tuple[Any, Any]:
    """Return the typing and lowering of a call by address, for an intrinsic.

    The first ``pointers`` arguments are given as numbers and taken as addresses.
    """
    taken = (numba.types.voidptr,) * pointers + arguments[pointers:]

    def generate(context, builder, signature, values):
        convention = context.call_conv
        function_type = convention.get_function_type(returns, taken)
        function = builder.inttoptr(values[0], function_type.as_pointer())
        given = [builder.inttoptr(value, cgutils.voidptr_t) for value in values[1 : 1 + pointers]]
        given += values[1 + pointers :]
        status, result = convention.call_function(builder, function, returns, taken, given)
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return result

    return returns(where, *arguments), generate


@_intrinsic
def bare(context, value):  # noqa: ARG001
    """Return arrays, or nested tuples of them, as views that are not counted.

    Numba counts references to every array of a tuple whenever one is picked out of it: hundreds of
    atomic operations in a sweep, more than its arithmetic costs. A unit can do without, because
    whoever calls it keeps the arrays alive until it returns.
    """

    def strip(context: Any, builder: Any, kind: Any, value: Any) -> Any:
        if isinstance(kind, numba.types.Array):
            array = context.make_array(kind)(context, builder, value=value)
            array.meminfo = cgutils.get_null_value(array.meminfo.type)
            array.parent = cgutils.get_null_value(array.parent.type)
            return array._getvalue()
        if isinstance(kind, _TUPLE):
            for i, inner in enumerate(kind):
                part = strip(context, builder, inner, builder.extract_value(value, i))
                value = builder.insert_value(value, part, i)
        return value

    def generate(context, builder, signature, values):
        return strip(context, builder, signature.args[0], values[0])

    return value(value), generate


# One intrinsic per number of arguments: a tuple of arguments would count references of every array
# in it, hundreds of atomic operations a call.


@_intrinsic
def call_residual(context, where, model, data, q, v, a, r):  # noqa: ARG001
    """Call inverse_dynamics(model, data, q, v, a, r) by address."""
    return _call(numba.types.none, where, (model, data, q, v, a, r))


@_intrinsic
def call_tangent(context, where, model, data, alpha, system):  # noqa: ARG001
    """Call tangent(model, data, alpha, system) by address."""
    return _call(numba.types.none, where, (model, data, alpha, system))


@_intrinsic
def call_stage(context, where, problem, cq, cv, goal):  # noqa: ARG001
    """Call solve_stage(problem, cq, cv, goal) by address."""
    return _call(numba.types.intp, where, (problem, cq, cv, goal))


@_intrinsic
def call_step(context, where, problem, t, h):  # noqa: ARG001
    """Call the step(problem, t, h) of a method by address."""
    return _call(numba.types.intp, where, (problem, t, h))


@_intrinsic
def call_uphold(context, where, model, data, work, h, q, v):  # noqa: ARG001
    """Call uphold(model, data, work, h, q, v) by address."""
    return _call(numba.types.boolean, where, (model, data, work, h, q, v))


@_intrinsic
def call_advance(context, where, problem, start_ns, step_ns, steps):  # noqa: ARG001
    """Call advance(problem, start_ns, step_ns, steps); the problem is its address as a number."""
    returns = numba.types.UniTuple(numba.types.int64, 2)
    return _call(returns, where, (problem, start_ns, step_ns, steps), pointers=1)


@_intrinsic
def call_account(context, where, problem):  # noqa: ARG001
    """Call take_stock(problem) by address; the problem is its address as a number."""
    return _call(numba.types.none, where, (problem,), pointers=1)
