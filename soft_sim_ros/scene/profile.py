"""Quantities that vary along a section: numbers, straight lines, tables, formulas, functions.

All are functions of the normalised arc length x in [0, 1]. Where they are not smooth, they say so:
``knots`` are the places where a derivative jumps, which quadrature must know; ``kinks`` those where
the slope itself does, at which a rod is cut into elements.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import scipy

from soft_sim_ros.scene.columns import read_columns
from soft_sim_ros.scene.expression import Expression, ExpressionError
from soft_sim_ros.scene.interval import FINITE, Interval
from soft_sim_ros.scene.reader import REQUIRED, Reader
from soft_sim_ros.scene.sampling import Unresolved, resolving
from soft_sim_ros.scene.taper import Floats

INTERPOLATIONS = ("linear", "monotone", "cubic")
SOURCES = ("table", "file", "function", "expression")
ROUNDING = 1e-9  # of the length of a section
CHECKED = np.linspace(0.0, 1.0, 257)

_FUNCTIONS: dict[str, Callable[[Floats], Floats]] = {}


class Profile(Protocol):
    """A quantity along a section."""

    def __call__(self, x: Floats) -> Floats:
        """Return the values at normalised arc lengths x in [0, 1], same shape as x."""

    @property
    def knots(self) -> tuple[float, ...]:
        """Places in (0, 1) where a derivative jumps."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Places in (0, 1) where the slope jumps."""

    @property
    def resolving(self) -> Floats:
        """Rising places (N,) in [0, 1] between which it changes by little."""


@dataclass(frozen=True, eq=False)
class Table:
    """Values (N,) at normalised arc lengths places (N,), joined by one of INTERPOLATIONS."""

    places: Floats
    values: Floats
    interpolation: str = "monotone"

    def __call__(self, x: Floats) -> Floats:
        """Return the values at x."""
        x = np.asarray(x, dtype=float)
        if self.interpolation == "linear":
            return np.asarray(np.interp(x, self.places, self.values))
        join = (
            scipy.interpolate.CubicSpline
            if self.interpolation == "cubic"
            else scipy.interpolate.PchipInterpolator
        )
        return np.asarray(join(self.places, self.values)(x))

    @property
    def knots(self) -> tuple[float, ...]:
        """All places between the ends."""
        return tuple(self.places[1:-1].tolist())

    @property
    def kinks(self) -> tuple[float, ...]:
        """The same if straight lines join them, else none."""
        return self.knots if self.interpolation == "linear" else ()

    @property
    def resolving(self) -> Floats:
        """All places, and three between neighbours."""
        steps = np.diff(self.places)[:, None] * np.array([0.0, 0.25, 0.5, 0.75])
        return np.append(self.places[:-1, None] + steps, 1.0)


@dataclass(frozen=True, eq=False)
class Smooth:
    """A smooth function of the arc length s in m along a section of some length in m."""

    function: Callable[[Floats], Floats]
    length: float
    knots: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def __call__(self, x: Floats) -> Floats:
        """Return the values at x."""
        s = self.length * np.asarray(x, dtype=float)
        return np.broadcast_to(np.asarray(self.function(s), dtype=float), s.shape)

    @cached_property
    def resolving(self) -> Floats:
        """Rising places (N,) in [0, 1] between which it changes by little (sampling.py)."""
        return resolving(self.function, self.length)


def register_profile(name: str, function: Callable[[Floats], Floats]) -> None:
    """Make a function known to scenes as ``{function: NAME}``.

    It gets arc lengths (N,) in m from the start of the section, and returns values (N,); it must be
    smooth there. A recording keeps the name only, so the function must be registered before a
    rerun.
    """
    _FUNCTIONS[name] = function


def profile_of(
    reader: Reader, key: str, length: float, within: Interval = FINITE, default: Any = REQUIRED
) -> Profile:
    """Return a quantity along a section of a length in m: as a taper, or a mapping."""
    return reader.taper_or(lambda own: read_profile(own, length, within), key, within, default)


def profiles_of(
    reader: Reader,
    key: str,
    size: int,
    length: float,
    within: Interval = FINITE,
    default: Any = REQUIRED,
) -> tuple[Profile, ...]:
    """Return a list of quantities along a section of a length in m."""
    return reader.tapers_or(
        lambda own: read_profile(own, length, within), key, size, within, default
    )


def read_profile(reader: Reader, length: float, within: Interval = FINITE) -> Profile:
    """Read a mapping that stands for a quantity along a section of some length in m."""
    source = reader.one_of(SOURCES)
    profile: Profile
    if source in ("table", "file"):
        keys = ("interpolation",) if source == "table" else ("interpolation", "column")
        reader.only(source, *keys)
        interpolation = reader.choice("interpolation", INTERPOLATIONS, default="monotone")
        if source == "table":
            rows = reader.matrix("table", None, 2)
        else:
            column = reader.word("column", expected="the name of a column of the file")
            rows = np.stack(read_columns(reader, "file", ("s", column)), axis=1)
            reader.inline(f"{{table: {rows.tolist()}, interpolation: {interpolation}}}")
        profile = _table(reader, source, rows, length, interpolation)
    elif source == "function":
        reader.only("function")
        profile = Smooth(_FUNCTIONS[_function_name(reader)], length)
    else:
        reader.only("expression")
        try:
            profile = Smooth(Expression(reader.word("expression")), length)
        except ExpressionError as error:
            reader.refuse(f"a formula in s: {error}", "expression")
    _check(reader, source, profile, length, within)
    return profile


def _function_name(reader: Reader) -> str:
    name: str = reader.reference("function", _FUNCTIONS, "registered function")
    return name


def _table(reader: Reader, key: str, rows: Floats, length: float, interpolation: str) -> Table:
    s = rows.reshape(-1, 2)[:, 0]
    if len(s) < 2 or not np.all(np.diff(s) > 0.0):
        reader.refuse("at least two rows, s rising (at a jump another section begins)", key)
    if abs(s[0]) > ROUNDING * length or abs(s[-1] - length) > ROUNDING * length:
        reader.refuse(f"s from 0 to the length of the section, {length:g} m", key)
    places = np.array(s / length)
    places[0], places[-1] = 0.0, 1.0
    return Table(places, rows[:, 1], interpolation)


def _check(reader: Reader, key: str, profile: Profile, length: float, within: Interval) -> None:
    """Refuse profiles that leave their interval, between the points of a table as well."""
    _check_values(reader, key, profile, length, within, CHECKED)
    try:
        with np.errstate(all="ignore"):
            places = profile.resolving
    except Unresolved as error:
        reader.refuse(str(error), key)
    _check_values(reader, key, profile, length, within, np.union1d(profile.knots, places))


def _check_values(
    reader: Reader, key: str, profile: Profile, length: float, within: Interval, places: Floats
) -> None:
    """Refuse values at some places that leave their interval."""
    with np.errstate(all="ignore"):
        try:
            values = profile(places)
        except (TypeError, ValueError, ArithmeticError) as error:
            reader.refuse(f"a function of arc lengths (N,) in m ({error})", key)
    for x, value in zip(places, values, strict=True):
        expected = within.refuses(value) if np.isfinite(value) else f"a {within}"
        if expected:
            where = f"it is {value:g} at s = {x * length:g} m"
            reader.refuse(f"{expected} all along the section ({where})", key)
