"""Compile a function to machine code: kernels, which are inlined, into units, which are called."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import cgutils
from numba.core.registry import CPUDispatcher as _CPUDispatcher
from numba.extending import intrinsic

from .disk import keep
from .inlined import InlinedCompiler

CPUDispatcher: Any = _CPUDispatcher
F = TypeVar("F", bound=Callable[..., Any])
Call = tuple[Any, ...] | None  # a unit and its arguments


_intrinsic: Any = intrinsic
_options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
# Inlined functions are never called by themselves, so no machine code is made for them.
_BARE: dict[str, Any] = {
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": InlinedCompiler,
}
# Algebra may take 0·x = 0 and x + 0 = x: bits of finite numbers stay as they are, up to the sign of
# zeros, and literal zeros vanish from compiled code (spaces.py).
ALGEBRA: dict[str, Any] = {"error_model": "numpy", "fastmath": {"nnan", "nsz"}} | _BARE
_inlined: Any = numba.njit(**(_options | _BARE))
_algebra: Any = numba.njit(**(_options | ALGEBRA))
_unit: Any = numba.njit(**_options)


def kernel(function: F) -> F:
    """Compile ``function`` without the GIL, cached, in strict IEEE arithmetic, inlined in others.

    Strict, because a kernel is compiled anew wherever it is inlined and any copy may be the one
    that runs: only if the compiler fuses and reorders nothing by itself do all copies give the
    same bits, which is what re-simulation relies on. It costs nothing that can be measured.
    """
    return _not_called(_inlined(function))


def algebra(function: F) -> F:
    """Compile like ``kernel``, for arithmetic that may rely on all numbers being finite.

    Nothing may be tested for NaN in it.
    """
    return _not_called(_algebra(function))


def unit(function: F) -> F:
    """Compile like ``kernel``, but as a function of its own: one that Python calls, or a large one.

    Arrays that enter a unit should go through ``bare`` first.
    """
    return keep(_unit(function))


def _not_called(dispatcher: Any) -> Any:
    """Make a call from Python, for which there is no machine code, fail with an explanation."""
    if isinstance(dispatcher, CPUDispatcher):  # not where NUMBA_DISABLE_JIT is set
        dispatcher.__class__ = _Inlined
    return dispatcher


class _Inlined(CPUDispatcher):
    """A kernel, to be called by other kernels only."""

    def __call__(self, *_arguments: Any, **_names: Any) -> Any:
        """Refuse: numba would jump to an invalid address."""
        name = f"{self.py_func.__module__}.{self.py_func.__name__}"
        raise TypeError(f"{name} is inlined in other kernels; Python can call units only")


def signature_of(arguments: Any) -> tuple[Any, ...]:
    """Return the types of arguments."""
    return tuple(numba.typeof(argument) for argument in arguments)


def address(function: Any, *arguments: Any) -> int:
    """Return the address of a kernel compiled for the types of ``arguments``.

    Together with the callers below this keeps large kernels in compilation units of their own:
    numba would otherwise optimise the whole tree below a kernel anew in each of its callers.
    """
    signature = signature_of(arguments)
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
def bare(context, value):
    """Return an array as a view that is not counted.

    Numba counts references to an array whenever it is handed on or sliced: hundreds of atomic
    operations in a sweep, more than its arithmetic costs. A unit can do without, because whoever
    calls it keeps the array alive until it returns.
    """

    def generate(context, builder, signature, values):
        array = context.make_array(signature.args[0])(context, builder, value=values[0])
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()

    return value(value), generate


# One intrinsic per number of arguments: a tuple of arguments would count references of every array
# in it, hundreds of atomic operations a call.


@_intrinsic
def call_residual(context, where, model, data, q, v, a, r):
    """Call inverse_dynamics(model, data, q, v, a, r) by address."""
    return _call(numba.types.none, where, (model, data, q, v, a, r))


@_intrinsic
def call_tangent(context, where, model, data, alpha, system):
    """Call tangent(model, data, alpha, system) by address."""
    return _call(numba.types.none, where, (model, data, alpha, system))


@_intrinsic
def call_stage(context, where, problem, cq, cv, goal):
    """Call solve_stage(problem, cq, cv, goal) by address."""
    return _call(numba.types.intp, where, (problem, cq, cv, goal))


@_intrinsic
def call_step(context, where, problem, t, h):
    """Call the step(problem, t, h) of a method by address."""
    return _call(numba.types.intp, where, (problem, t, h))


@_intrinsic
def call_wrench(context, where, p, rotation, position, omega, velocity, time, moment, force):
    """Call the law of a load by address (terms/custom.py)."""
    given = (p, rotation, position, omega, velocity, time, moment, force)
    return _call(numba.types.none, where, given)


@_intrinsic
def call_slopes(context, where, p, rotation, position, omega, velocity, time, by_pose, by_twist):
    """Call the derivatives of the law of a load by address (terms/custom.py)."""
    given = (p, rotation, position, omega, velocity, time, by_pose, by_twist)
    return _call(numba.types.none, where, given)


@_intrinsic
def call_contact(context, where, model, data):
    """Call contact_wrenches(model, data) by address (contact/force.py)."""
    return _call(numba.types.none, where, (model, data))


@_intrinsic
def call_contact_matrices(context, where, model, data, node, out):
    """Call contact_matrices(model, data, node, out) by address."""
    return _call(numba.types.none, where, (model, data, node, out))


@_intrinsic
def call_contact_energy(context, where, model, data):
    """Call contact_energy(model, data) by address."""
    return _call(numba.types.float64, where, (model, data))


@_intrinsic
def call_bristles(context, where, model, data, bristles):
    """Call bristle_energy(model, data, bristles) by address (contact/balance.py)."""
    return _call(numba.types.float64, where, (model, data, bristles))


@_intrinsic
def call_made(context, where, model, data, effort, q0, v0, old, q1, v1, new, worked, lost, whole):
    """Call energy_made(…) by address (contact/balance.py)."""
    given = (model, data, effort, q0, v0, old, q1, v1, new, worked, lost, whole)
    return _call(numba.types.float64, where, given)


@_intrinsic
def call_uphold(context, where, model, data, work, h, q, v):
    """Call uphold(model, data, work, h, q, v) by address."""
    return _call(numba.types.boolean, where, (model, data, work, h, q, v))


@_intrinsic
def call_close(context, where, problem, what, t, h):
    """Call close(problem, what, t, h) by address (integrators/closed.py)."""
    return _call(numba.types.intp, where, (problem, what, t, h))


@_intrinsic
def call_advance(context, where, problem, step_ns, steps, most):
    """Call advance(problem, step_ns, steps, most); the problem is its address as a number."""
    return _call(numba.types.int64, where, (problem, step_ns, steps, most), pointers=1)


@_intrinsic
def call_account(context, where, problem):
    """Call take_stock(problem) by address; the problem is its address as a number."""
    return _call(numba.types.none, where, (problem,), pointers=1)


@_intrinsic
def call_hold(context, where, problem, efforts):
    """Call hold(problem, efforts) by address; the problem is its address as a number."""
    return _call(numba.types.boolean, where, (problem, efforts), pointers=1)
