"""Motions that joints are told: formulas in time, tables of it, or commands while the arm moves.

What a driven joint does is known, so its rate and its acceleration must be known as well: a formula
has both, and a table is joined by cubics with continuous accelerations that begin and end at rest.
A command is reached within a time, along a polynomial of fifth degree.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy

from soft_sim_ros.scene.columns import read_columns
from soft_sim_ros.scene.expression import Expression, ExpressionError
from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

SOURCES = ("formula", "table", "file", "within")


@dataclass(frozen=True)
class Formula:
    """A coordinate, in rad or m, as a formula in the time t in s."""

    expression: Expression

    @property
    def switches(self) -> tuple[float, ...]:
        """Times in s at which the acceleration jumps: none."""
        return ()


@dataclass(frozen=True, eq=False)
class TimeTable:
    """A coordinate, in rad or m, at times (N,) in s: constant before the first and after the last.

    Cubics join the values; rates and accelerations are continuous, and rates zero at both ends.
    """

    times: Floats
    values: Floats
    spline: Floats = field(init=False)  # (N − 1, 4) of each piece, constant term first

    def __post_init__(self) -> None:
        made = scipy.interpolate.CubicSpline(self.times, self.values, bc_type="clamped")
        object.__setattr__(self, "spline", made.c[::-1].T.copy())

    @property
    def switches(self) -> tuple[float, ...]:
        """Times in s at which the acceleration jumps."""
        return float(self.times[0]), float(self.times[-1])


@dataclass(frozen=True)
class Commanded:
    """A coordinate, in rad or m, that follows commands while the arm moves.

    within : s in which it reaches what was commanded; start : where it is before any command
    """

    within: float
    start: float = 0.0

    @property
    def switches(self) -> tuple[float, ...]:
        """Times in s at which the acceleration jumps: none known beforehand."""
        return ()


Course = Formula | TimeTable | Commanded


def read_courses(reader: Reader, labels: tuple[str, ...]) -> tuple[Course, ...]:
    """Read ``driven`` of a joint with some coordinates: one course, or one by each label.

    Coordinates that are not mentioned stay at 0.
    """
    if len(labels) == 1:
        return (read_course(reader, "driven"),)
    own = reader.mapping("driven", required=True)
    if own.has("within"):
        own.no_effect("start", "write within and start by coordinate: {x: {within: …, start: …}}")
        return len(labels) * (_commanded(own),)
    own.only(*labels)
    if not own.keys():
        reader.refuse(f"the courses of some of {', '.join(labels)}", "driven")
    return tuple(
        read_course(own, label) if own.has(label) else Formula(Expression("0", "t"))
        for label in labels
    )


def read_course(reader: Reader, key: str) -> Course:
    """Read what one coordinate does in time."""
    if not reader.is_mapping(key):
        return _formula(reader, key)
    own = reader.mapping(key)
    source = own.one_of(SOURCES)
    if source == "formula":
        return _formula(own.only("formula"), "formula")
    if source == "within":
        return _commanded(own)
    if source == "table":
        own.only("table")
        rows = own.matrix("table", None, 2).reshape(-1, 2)
    else:
        own.only("file", "column")
        column = own.word("column", expected="the name of a column of the file")
        rows = np.stack(read_columns(own, "file", ("time", column)), axis=1)
        own.inline(f"{{table: {rows.tolist()}}}")
    times = rows[:, 0]
    if len(times) < 2 or not np.all(np.diff(times) > 0.0):
        own.refuse("at least two rows [time in s, value], times rising", source)
    with np.errstate(all="ignore"):
        table = TimeTable(times.copy(), rows[:, 1].copy())
    if not np.isfinite(table.spline).all():
        own.refuse("values that cubics can join: these are too large or too close", source)
    return table


def _commanded(own: Reader) -> Commanded:
    own.only("within", "start")
    return Commanded(own.number("within", POSITIVE), own.number("start", default=0.0))


def _formula(reader: Reader, key: str) -> Formula:
    text = reader.word(key, expected="a formula in t, or a mapping: formula, table, file or within")
    try:
        formula = Formula(Expression(text, "t"))
    except ExpressionError as error:
        reader.refuse(f"a formula in the time t in s: {error}", key)
    if not np.isfinite(formula.expression(np.linspace(0.0, 1.0, 101))).all():
        reader.refuse("a formula that is a number at every time", key)
    return formula
