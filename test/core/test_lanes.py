"""Four segments at once: every lane is what a segment alone would be, whatever its neighbours."""

import os
import subprocess
import sys

import numpy as np
import pytest

from soft_sim_ros.core.algebra import dual
from soft_sim_ros.core.algebra.simd import (
    each,
    four,
    fused,
    keep,
    lane,
    lanes_from,
    nine,
    one,
    six,
    three,
)
from soft_sim_ros.core.backend.jit import unit

bracket = unit(lambda a, b: dual.dcross(dual.load_twist(a), dual.load_twist(b)))


@unit
def brackets(a, b, out):
    """Fill out (n, 6) with the brackets of twists (n, 6), four at once."""
    for k in range(0, len(a), 4):
        rows = lanes_from(k, len(a))
        x, y = six(a, rows, 0), six(b, rows, 0)
        c = dual.dcross((x[:3], x[3:]), (y[:3], y[3:]))
        keep(out, rows, 0, c[0] + c[1])


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7, 8, 18])
def test_every_lane_has_the_bits_of_a_segment_alone(count):
    rng = np.random.default_rng(count)
    a, b = rng.normal(size=(2, count, 6))
    out = np.full((count, 6), np.nan)
    brackets(a, b, out)
    for k in range(count):
        assert np.array_equal(out[k], np.concatenate(bracket(a[k], b[k])))


@unit
def copied(a, out):
    """Copy rows of twelve numbers in every way there is to read them."""
    for k in range(0, len(a), 4):
        rows = lanes_from(k, len(a))
        first = each(a, rows, 0)
        middle = three(a, rows, 1)
        last = six(a, rows, 6)
        whole = (first, *middle, *four(a, rows, 4)[:2], *last)
        keep(out, rows, 0, whole)
        keep(out, rows, 12, nine(a, rows, 3))


def test_rows_are_read_and_written_where_they_are_and_nowhere_else():
    a = np.arange(84.0).reshape(7, 12)
    guard = np.full((9, 21), -1.0)
    out = guard[1:8]
    copied(a, out)
    assert np.array_equal(out[:, :12], a)
    assert np.array_equal(out[:, 12:], a[:, 3:])
    assert (guard[[0, 8]] == -1.0).all()


@unit
def once(a, b, c):
    """Return a b + c of the third lanes, fused and not."""
    lanes = fused(one(a, 0, 0), one(b, 0, 0), one(c, 0, 0))
    apart = one(a, 0, 0) * one(b, 0, 0) + one(c, 0, 0)
    return lane(lanes, 2), lane(apart, 2)


def test_fused_products_are_rounded_once_and_others_twice():
    tiny = 2.0**-30
    a = np.full((1, 4), 1.0 + tiny)
    c = np.full((1, 4), -(1.0 + 2.0 * tiny))
    assert once(a, a, c) == (tiny**2, 0.0)


BITS = """
import hashlib
import numpy as np
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import load_scene

dynamics = Dynamics(load_scene("cantilever"))
q, v, a = np.random.default_rng(0).normal(size=(3, dynamics.n))
found = [dynamics.inverse_dynamics(q, v, a), *dynamics.tangents(q, v, a)]
assert all(np.isfinite(part).all() for part in found)
print(hashlib.sha256(b"".join(part.tobytes() for part in found)).hexdigest())
"""


@pytest.mark.slow
def test_bits_are_those_of_a_processor_without_wide_registers():
    """Nor with fused multiply-adds: there a library rounds them once, too.

    The folder of compiled kernels keeps those of one processor apart from those of another, so the
    minute that this takes is spent once for every change of the kernels.
    """
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    told = [
        subprocess.run(
            [sys.executable, "-c", BITS],
            env=os.environ | other,
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        for other in ({}, plain)
    ]
    assert len(told[0].strip()) == 64
    assert told[0] == told[1]
