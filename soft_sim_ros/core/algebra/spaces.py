"""Reading and writing dual vectors; components that vanish in a plane are literal zeros.

The algebra of dual.py is written once, for space. A planar chain uses it through these functions,
which are compiled for the type of ``model.space``: components that vanish are constants there, the
compiler drops every operation with them, and the same recursion runs on SE(2).

Matrices over the components of twists keep the rows of ``Space.components`` only: six in space,
three in a plane.
"""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from soft_sim_ros.core.backend.jit import ALGEBRA

from .motion_space import SPACES

_overload: Any = overload
Mask = tuple[bool, bool, bool]


def per_space(stub: Any) -> Callable[[Any], None]:
    """Compile ``stub`` by a factory, given the axes of rotation and those of translation."""

    def register(factory: Any) -> None:
        made: dict[Any, Any] = {}
        for space in SPACES:
            present = [c in space().components for c in range(6)]
            made[space] = factory(present[:3], present[3:])

        def choose(space, *_):
            return made.get(getattr(space, "instance_class", None))

        _overload(stub, jit_options=ALGEBRA, strict=False)(choose)

    return register


def size_of(space):
    """Return the number of components of a twist: 6 or 3."""


def axial_of(space, row):
    """Return an angular vector of an array (3,)."""


def polar_of(space, row):
    """Return a position, velocity or force of an array (3,)."""


def keep_polar(space, row, v):
    """Write a position, velocity or force."""


def twist_of(space, row):
    """Return the dual vector of an array (w, v)."""


def keep_twist(space, row, a):
    """Write a dual vector as (w, v)."""


def wrench_of(space, row):
    """Return the dual vector N + εM of an array (M, N)."""


def keep_wrench(space, row, f):
    """Write a dual vector N + εM as (M, N)."""


def rotation_of(space, row):
    """Return the rotation matrix of an array of nine."""


def keep_rotation(space, row, m):
    """Write a rotation matrix."""


@per_space(size_of)
def _size(turns: Mask, moves: Mask):
    count = sum(turns) + sum(moves)
    return lambda space: count


def _vector(present: Mask):
    x, y, z = present

    def vector(space, row):
        return (row[0] if x else 0.0, row[1] if y else 0.0, row[2] if z else 0.0)

    return vector


per_space(axial_of)(lambda turns, moves: _vector(turns))
per_space(polar_of)(lambda turns, moves: _vector(moves))


@per_space(keep_polar)
def _keep_polar(turns: Mask, moves: Mask):
    x, y, z = moves

    def keep(space, row, v):
        if x:
            row[0] = v[0]
        if y:
            row[1] = v[1]
        if z:
            row[2] = v[2]

    return keep


@per_space(twist_of)
def _twist(turns: Mask, moves: Mask):
    a, b, c = turns
    x, y, z = moves

    def twist(space, row):
        return (
            (row[0] if a else 0.0, row[1] if b else 0.0, row[2] if c else 0.0),
            (row[3] if x else 0.0, row[4] if y else 0.0, row[5] if z else 0.0),
        )

    return twist


@per_space(wrench_of)
def _wrench(turns: Mask, moves: Mask):
    a, b, c = turns
    x, y, z = moves

    def wrench(space, row):
        return (
            (row[3] if x else 0.0, row[4] if y else 0.0, row[5] if z else 0.0),
            (row[0] if a else 0.0, row[1] if b else 0.0, row[2] if c else 0.0),
        )

    return wrench


def _keep_six(turns: Mask, moves: Mask, angular: int):
    """Write part ``angular`` of a dual vector first, the other part last."""
    a, b, c = turns
    x, y, z = moves
    linear = 1 - angular

    def keep(space, row, d):
        if a:
            row[0] = d[angular][0]
        if b:
            row[1] = d[angular][1]
        if c:
            row[2] = d[angular][2]
        if x:
            row[3] = d[linear][0]
        if y:
            row[4] = d[linear][1]
        if z:
            row[5] = d[linear][2]

    return keep


per_space(keep_twist)(lambda turns, moves: _keep_six(turns, moves, 0))
per_space(keep_wrench)(lambda turns, moves: _keep_six(turns, moves, 1))


@per_space(rotation_of)
def _rotation(turns: Mask, moves: Mask):
    if all(moves):

        def spatial(space, m):
            return (m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8])

        return spatial
    x, y, z = moves
    xy, xz, yz = x and y, x and z, y and z

    def planar(space, m):
        return (
            m[0] if x else 1.0,
            m[1] if xy else 0.0,
            m[2] if xz else 0.0,
            m[3] if xy else 0.0,
            m[4] if y else 1.0,
            m[5] if yz else 0.0,
            m[6] if xz else 0.0,
            m[7] if yz else 0.0,
            m[8] if z else 1.0,
        )

    return planar


@per_space(keep_rotation)
def _keep_rotation(turns: Mask, moves: Mask):
    def keep(space, row, m):
        for i in range(9):
            row[i] = m[i]

    return keep
