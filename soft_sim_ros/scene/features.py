"""Places where the data of a section change so fast that the rod has to be cut there.

A basis of low degree with a few nodes misses a soft spot of 2 mm in an arm of 0.3 m, and so does
every finer companion. So the data themselves are searched, at samples that resolve every profile
(sampling.py), and the section is cut into as few pieces as possible on which a polynomial of low
degree approximates stiffness, compliance, damping, inertia and reference strain. Smooth data need
no cut.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.polynomial.legendre import legvander

from soft_sim_ros.scene.profile import CHECKED
from soft_sim_ros.scene.sampling import FINEST, Unresolved
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.taper import Floats, Taper

MOST_PIECES = 256
DEGREE, FIT = 6, 0.05  # of the polynomial on a piece, and its error over the largest value there

SLIGHT = 1e-3  # rad: a reference shape that turns by less is treated as straight


def cuts(section: Section) -> tuple[float, ...]:
    """Return the places x in (0, 1) where a section is cut because of its data.

    Raises
    ------
    Unresolved
        if there would be over MOST_PIECES
    """
    profiles = [p for p in section.profiles if not isinstance(p, Taper)]
    if not profiles:
        return ()
    x = np.unique(np.concatenate([CHECKED[::4], *(profile.resolving for profile in profiles)]))
    bounds = [0.0, *section.kinks, 1.0]  # it is cut there anyway
    x = np.union1d(x, bounds)
    values, scale = _data(section, x)
    if not len(values.T):
        return ()
    found: list[float] = []
    for begin, end in itertools.pairwise(bounds):
        inside = slice(np.searchsorted(x, begin), np.searchsorted(x, end) + 1)
        found += _pieces(x[inside], values[inside], scale)
    if len(found) > MOST_PIECES:
        raise Unresolved(f"data that {MOST_PIECES} pieces of the section show")
    return tuple(found)


def _data(section: Section, x: Floats) -> tuple[Floats, Floats]:
    """Return what varies (N, k), and a size (k,) to compare it with; NaN: its own on a piece."""
    stiffness, strain = section.stiffness(x), section.strain0(x)
    with np.errstate(all="ignore"):
        columns = [stiffness, 1.0 / stiffness, section.damping(x), section.inertia(x)]
    own = np.concatenate(columns, axis=1)
    bend = max(np.abs(strain[:, :3]).max(), SLIGHT / section.length)
    scale = np.concatenate(
        [np.full(own.shape[1], np.nan), np.full(3, bend), np.full(3, np.abs(strain[:, 3:]).max())]
    )
    values = np.concatenate([own, strain], axis=1)
    varies = np.isfinite(values).all(axis=0)
    varies &= np.ptp(np.where(np.isfinite(values), values, 0.0), axis=0) > 0.0
    return values[:, varies], scale[varies]


def _pieces(x: Floats, values: Floats, scale: Floats) -> list[float]:
    """Return the places where the data between the ends of x (N,) have to be cut."""
    found: list[float] = []
    first, last = 0, len(x) - 1
    while not _fits(x[first:], values[first:], scale):
        good, bad = first + 1, last  # a piece up to ``good`` fits, one up to ``bad`` does not
        while bad - good > 1:
            middle = (good + bad) // 2
            if _fits(x[first : middle + 1], values[first : middle + 1], scale):
                good = middle
            else:
                bad = middle
        found.append(float(x[good]))
        first = good
        if len(found) > MOST_PIECES:
            break
    return _apart(found)


def _apart(found: Iterable[float]) -> list[float]:
    """Return places without those that are next to the one before: a jump needs one cut only."""
    kept: list[float] = []
    for place in found:
        if not FINEST < place < 1.0 - FINEST:
            continue
        if kept and place - kept[-1] <= 10.0 * FINEST:
            kept[-1] = 0.5 * (place + kept[-1])
        else:
            kept.append(place)
    return kept


def _fits(x: Floats, values: Floats, scale: Floats) -> bool:
    """Whether a polynomial of DEGREE approximates all data (N, k) at x (N,)."""
    if len(x) < 3:
        return True
    t = 2.0 * (x - x[0]) / (x[-1] - x[0]) - 1.0
    size = np.where(np.isnan(scale), np.abs(values).max(axis=0), scale)
    wanted = values / np.where(size > 0.0, size, 1.0)
    matrix = legvander(t, min(DEGREE, len(x) - 2))
    rest = matrix @ np.linalg.lstsq(matrix, wanted, rcond=None)[0] - wanted
    return bool(np.abs(rest).max() <= FIT)
