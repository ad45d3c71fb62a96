"""Laws of loads that users write: a wrench on a frame, by its place, its motion and the time.

A law is compiled on its own and called by its address, so it costs nothing where no scene has one.
Everything a law sees and gives is along world axes; here it becomes what the recursion needs. With
F the wrench about the origin of a frame, A and B its derivatives by a small turn and shift and by
angular and linear velocity, what varies in the axes of the frame is

    δF = A (θ; δp) + B (δω; δv) + F × θ,      δω → δω − ω × θ,  δv → δv − v × θ

in which the last terms belong to the turning of the frame (docs/theory.md, the tangent).
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numba
import numpy as np
from numba import types

from soft_sim_ros.core.backend.jit import bare, call_slopes, call_wrench, kernel, unit
from soft_sim_ros.core.backend.laws import note_law
from soft_sim_ros.errors import BadArgument
from soft_sim_ros.scene.custom_load import LAWS
from soft_sim_ros.scene.words import NAME

_ROW, _MATRIX = types.float64[::1], types.float64[:, ::1]
_WRENCH = types.void(_ROW, _MATRIX, _ROW, _ROW, _ROW, types.float64, _ROW, _ROW)
_SLOPES = types.void(_ROW, _MATRIX, _ROW, _ROW, _ROW, types.float64, _MATRIX, _MATRIX)
NAMES = "p, rotation, position, omega, velocity, time"
STEP = 1e-5  # rad, m, rad/s, m/s: of differences
AGREE = 1e-5  # of the size of a wrench: what differences of a law may be off its derivatives by


@kernel
def turn(rotation, axis, angle, out):
    """Fill out (3, 3) with a rotation (3, 3) turned about a world axis."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = math.cos(angle), math.sin(angle)
    for j in range(3):
        out[axis, j] = rotation[axis, j]
        out[b, j] = cos * rotation[b, j] - sin * rotation[c, j]
        out[c, j] = sin * rotation[b, j] + cos * rotation[c, j]


@kernel
def congruent(m, x, factor, out, first):
    """Add factor mᵀ x m of (6, 6) matrices to rows ``first`` … of out."""
    half = np.zeros((6, 6))
    for i in range(6):
        for j in range(6):
            for c in range(6):
                half[i, j] += x[i, c] * m[c, j]
    for i in range(6):
        for j in range(6):
            for c in range(6):
                out[first + i, j] += factor * m[c, i] * half[c, j]


@unit
def differences(where, p, rotation, position, omega, velocity, time, by_pose, by_twist):
    """Fill the derivatives of a law (6, 6) by central differences."""
    moment, force, turned = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((3, 3))
    seen = np.zeros((3, 3))  # position, omega, velocity
    for j in range(12):
        c, part = j % 3, j // 3 - 1
        for side in range(2):
            h = STEP if side == 0 else -STEP
            for i in range(3):
                moment[side, i], force[side, i] = 0.0, 0.0
                seen[0, i], seen[1, i], seen[2, i] = position[i], omega[i], velocity[i]
            turn(rotation, c, h if part < 0 else 0.0, turned)
            if part >= 0:
                seen[part, c] += h
            call_wrench(
                where, p, turned, seen[0], seen[1], seen[2], time, moment[side], force[side]
            )
        slopes = by_pose if j < 6 else by_twist
        for i in range(3):
            slopes[i, j % 6] = (moment[0, i] - moment[1, i]) / (2.0 * STEP)
            slopes[3 + i, j % 6] = (force[0, i] - force[1, i]) / (2.0 * STEP)


def register_load(
    name: str,
    parameters: Sequence[str],
    wrench: Callable[..., None],
    derivatives: Callable[..., None] | None = None,
) -> None:
    """Make a law of loads known to scenes as ``{custom: …, law: NAME}``.

    Parameters
    ----------
    name : str
    parameters : names of the numbers that a scene gives
    wrench : function of (p, rotation, position, omega, velocity, time, moment, force), compiled by
        numba: p (k,) parameters, rotation (3, 3) and position (3,) in m of the frame in the world,
        omega (3,) in rad/s and velocity (3,) in m/s of it along world axes, time in s. It adds to
        moment (3,) in N·m about the frame's origin and force (3,) in N, along world axes (both per
        length along rods)
    derivatives : function of the same first six, and by_pose, by_twist (6, 6), zero at first: what
        moment and force gain per small turn and shift along world axes, and per omega and velocity.
        Without it differences are taken: Newton's method then costs more

    Raises
    ------
    BadArgument
        if a function does not compile, or the derivatives are not those of the wrench
    """
    parameters = tuple(parameters)
    if not NAME.fullmatch(name):
        raise BadArgument("name", name, "a name of letters, digits and _ that starts with a letter")
    made = _compiled("wrench", wrench, _WRENCH)
    place = _address(made)
    if derivatives is None:
        note_law(name, place, 0, made)
    else:
        slopes = _compiled("derivatives", derivatives, _SLOPES)
        _check(name, len(parameters), place, slopes)
        note_law(name, place, _address(slopes), made, slopes)
    LAWS[name] = parameters


def _compiled(what: str, function: Callable[..., None], signature: Any) -> Any:
    try:
        return numba.njit(signature, nogil=True, error_model="numpy")(function)
    except Exception as error:  # numba has many
        first = str(error).strip().split("\n")[0]
        expected = f"a function of ({NAMES}, …) that numba compiles ({first})"
        raise BadArgument(what, function, expected) from error


def _address(dispatcher: Any) -> int:
    result = dispatcher.overloads[dispatcher.signatures[0]]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def _check(name: str, count: int, place: int, slopes: Any) -> None:
    """Refuse derivatives that are not those of differences, at some states drawn."""
    rng = np.random.default_rng(5)
    for _ in range(5):
        p = rng.uniform(0.5, 1.5, count)
        rotation = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(3, 3)))[0])
        rotation *= np.linalg.det(rotation)
        position, omega, velocity = rng.normal(size=(3, 3))
        exact, found = np.zeros((2, 2, 6, 6))
        slopes(p, rotation, position, omega, velocity, 0.3, exact[0], exact[1])
        differences(place, p, rotation, position, omega, velocity, 0.3, found[0], found[1])
        off = np.nan_to_num(np.abs(exact - found), nan=np.inf)
        if not off.max() <= AGREE * max(1e-12, np.abs(found).max()):
            which, row, column = np.unravel_index(int(np.argmax(off)), off.shape)
            what = ("by_pose", "by_twist")[which]
            expected = (
                f"the derivatives of {name}: {what}[{row}, {column}] is "
                f"{exact[which, row, column]:.6g}, differences give {found[which, row, column]:.6g}"
            )
            raise BadArgument("derivatives", slopes.py_func, expected)


@kernel
def see(model, data, node, rotation, position, omega, velocity):
    """Fill what a law sees of a node: orientation, place and velocities along world axes."""
    base = model.custom.base
    for i in range(3):
        position[i] = base[9 + i]
        for j in range(3):
            rotation[i, j] = 0.0
            position[i] += base[3 * i + j] * data.position[node, j]
            for c in range(3):
                rotation[i, j] += base[3 * i + c] * data.rotation[node, 3 * c + j]
    for i in range(3):
        omega[i], velocity[i] = 0.0, 0.0
        for j in range(3):
            omega[i] += rotation[i, j] * data.eta[node, j]
            velocity[i] += rotation[i, j] * data.eta[node, 3 + j]


@unit
def custom_wrenches(model, data):
    """Subtract the wrenches of all laws from data.wrench; note the power in W of each."""
    custom = model.custom
    rotation, position = np.zeros((3, 3)), np.zeros(3)
    omega, velocity, moment, force = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for e in range(len(custom.node)):
        node, share = custom.node[e], custom.share[e] * data.now[1]
        see(model, data, node, rotation, position, omega, velocity)
        moment[:], force[:] = 0.0, 0.0
        p = bare(custom.parameters)[e]
        call_wrench(
            data.laws[e, 0], p, rotation, position, omega, velocity, data.now[0], moment, force
        )
        power = 0.0
        for i in range(3):
            power += share * (moment[i] * omega[i] + force[i] * velocity[i])
            for j in range(3):
                data.wrench[node, i] -= share * rotation[j, i] * moment[j]
                data.wrench[node, 3 + i] -= share * rotation[j, i] * force[j]
        data.custom_power[e] = power


@unit
def custom_matrices(model, data, node, out):
    """Subtract the derivatives of laws on a node from its G and D, rows 6 … of out (18, 8)."""
    custom, base = model.custom, model.custom.base
    rotation, position = np.zeros((3, 3)), np.zeros(3)
    omega, velocity, moment, force = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    by_pose, by_twist = np.zeros((6, 6)), np.zeros((6, 6))
    carry, shift = np.zeros((6, 6)), np.eye(6)
    at = data.position[node]
    # δp = v − p × θ of a spatial twist (θ; v)
    shift[3, 1], shift[3, 2] = at[2], -at[1]
    shift[4, 0], shift[4, 2] = -at[2], at[0]
    shift[5, 0], shift[5, 1] = at[1], -at[0]
    for i in range(3):
        for j in range(6):
            for c in range(3):
                carry[i, j] += base[3 * i + c] * shift[c, j]
                carry[3 + i, j] += base[3 * i + c] * shift[3 + c, j]
    for e in range(custom.ptr[node], custom.ptr[node + 1]):
        share = custom.share[e] * data.now[1]
        see(model, data, node, rotation, position, omega, velocity)
        p, now = bare(custom.parameters)[e], data.now[0]
        moment[:], force[:] = 0.0, 0.0
        by_pose[:], by_twist[:] = 0.0, 0.0
        call_wrench(data.laws[e, 0], p, rotation, position, omega, velocity, now, moment, force)
        if data.laws[e, 1] != 0:
            call_slopes(
                data.laws[e, 1], p, rotation, position, omega, velocity, now, by_pose, by_twist
            )
        else:
            differences(
                data.laws[e, 0], p, rotation, position, omega, velocity, now, by_pose, by_twist
            )
        for i in range(6):
            for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                # B (θ × ω; θ × v)
                by_pose[i, a] += by_twist[i, c] * omega[b] - by_twist[i, b] * omega[c]
                by_pose[i, a] += by_twist[i, 3 + c] * velocity[b] - by_twist[i, 3 + b] * velocity[c]
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # F × θ
            by_pose[c, b] += moment[a]
            by_pose[b, c] -= moment[a]
            by_pose[3 + c, b] += force[a]
            by_pose[3 + b, c] -= force[a]
        congruent(carry, by_twist, -share, out, 6)
        congruent(carry, by_pose, -share, out, 12)


@kernel
def custom_power(data):
    """Return the power in W of all laws, at the last residual."""
    total = 0.0
    for e in range(len(data.custom_power)):
        total += data.custom_power[e]
    return total
