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
_compile: Any = numba.njit(cache=True, nogil=True, error_model="numpy")


def kernel(function: F) -> F:
    """Compile ``function`` without the GIL, cached, in strict IEEE arithmetic.

    Strict, because a kernel is compiled anew wherever it is inlined and any copy may be the one
    that runs: only without fused or reordered operations do all copies give the same bits, which
    is what re-simulation relies on. It costs nothing that can be measured.
    """
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = _CACHE
    try:
        return _compile(function)  # the cache folder is chosen here, once
    finally:
        numba_config.CACHE_DIR = before


def address(function: Any, *arguments: Any) -> int:
    """Return the address of a kernel compiled for the types of ``arguments``.

    Together with the callers below this keeps large kernels in compilation units of their own:
    numba would otherwise optimise the whole tree below a kernel anew in each of its callers.
    """
    signature = tuple(numba.typeof(argument) for argument in arguments)
    if signature not in function.overloads:
        function.compile(signature)
    result = function.overloads[signature]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def _call(returns: Any, where: Any, arguments: tuple[Any, ...]) -> tuple[Any, Any]:
    """Return the typing and lowering of a call by address, for an intrinsic."""

    def generate(context, builder, signature, values):
        convention = context.call_conv
        function_type = convention.get_function_type(returns, arguments)
        pointer = builder.inttoptr(values[0], function_type.as_pointer())
        status, result = convention.call_function(builder, pointer, returns, arguments, values[1:])
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return result

    return returns(where, *arguments), generate


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
def call_stage(context, where, calls, model, data, work, cq, cv, tolerance, limit):  # noqa: ARG001
    """Call solve_stage(calls, model, data, work, cq, cv, tolerance, limit) by address."""
    arguments = (calls, model, data, work, cq, cv, tolerance, limit)
    return _call(numba.types.intp, where, arguments)
