"""The node's parameters: one table, and how the table becomes declared parameters and settings."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.parameter import Parameter

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.foreign import shown
from soft_sim_ros.node.clock import FASTEST, SLOWEST

OWN, LOCK_STEP, RESAMPLED = "own", "lock_step", "resampled"  # whose time, and how it is followed


class ParameterError(SoftSimError):
    """One or more parameters cannot be used; the message has one line for each of the first."""

    _MOST = 20

    def __init__(self, lines: list[str]) -> None:
        super().__init__(lines)
        more = [f"and {len(lines) - self._MOST} more faults"] if len(lines) > self._MOST else []
        self.lines = (*lines[: self._MOST], *more)

    def __str__(self) -> str:
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Row:
    """One parameter. The type of ``default`` is the type of the parameter."""

    name: str
    default: str | bool | int | float
    description: str
    low: float | None = None
    high: float | None = None
    live: bool = False
    zero: bool = False  # 0 is allowed, too, and means something of its own
    longest: int = 4096  # characters of a text
    choices: tuple[str, ...] = ()  # the only values of a text

    @property
    def type_name(self) -> str:
        """Type as users of parameter files call it, with its article."""
        kinds = {str: "a string", bool: "a boolean", int: "an integer", float: "a number"}
        return kinds[type(self.default)]

    def descriptor(self) -> ParameterDescriptor:
        """ROS descriptor with range and read-only flag."""
        result = ParameterDescriptor(description=self.description, read_only=not self.live)
        if self.low is not None and self.high is not None:
            if isinstance(self.default, float):
                result.floating_point_range = [
                    FloatingPointRange(
                        from_value=0.0 if self.zero else float(self.low),
                        to_value=float(self.high),
                    )
                ]
            else:
                result.integer_range = [
                    IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)
                ]
        return result

    def accept(self, value: object) -> str | bool | int | float:
        """``value`` with this parameter's type, or a ValueError that says what is expected."""
        kind = type(self.default)
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            raise ValueError(f"{self.name} = {shown(value)}: expected {self.type_name}")
        if isinstance(value, str) and not (len(value) <= self.longest and value.isprintable()):
            expected = f"at most {self.longest} characters, all printable"
            raise ValueError(f"{self.name} = {shown(value)}: expected {expected}")
        if self.choices and value not in self.choices:
            expected = " or ".join(self.choices)
            raise ValueError(f"{self.name} = {shown(value)}: expected {expected}")
        if self.low is not None and self.high is not None:
            assert isinstance(value, int | float)
            fits = math.isfinite(value) and self.low <= value <= self.high
            if not (fits or (self.zero and value == 0)):
                least = f" (0, or at least {self.low:g})" if self.zero else ""
                lowest = 0.0 if self.zero else self.low
                expected = f"{lowest:g} to {self.high:g}{least}"
                raise ValueError(f"{self.name} = {value!r}: expected {expected}")
        return value


TABLE = (
    Row("scene", "soft_arm", "scene file, or the name of one in the package's config folder"),
    Row(
        "name_from",
        "node",
        "what topics and services are called after: node = the node's name, scene = the scene's",
        choices=("node", "scene"),
    ),
    Row("record", "", "directory of the recording, new or empty; empty = no recording"),
    Row(
        "real_time_factor",
        1.0,
        "simulated seconds per second; 0 = as fast as possible",
        SLOWEST,
        FASTEST,
        live=True,
        zero=True,
    ),
    Row("publish_rate", 100.0, "state messages per simulated second, Hz", 0.1, 10000.0),
    Row(
        "control_rate",
        250.0,
        "how often commands are taken up, per simulated second, Hz; 0 = every step",
        0.1,
        100000.0,
        zero=True,
    ),
    Row(
        "command_timeout",
        1.0,
        "simulated seconds for which a command is held; 0 = for ever",
        1.0e-3,
        1.0e6,
        zero=True,
    ),
    Row(
        "command_ramp",
        0.5,
        "simulated seconds in which a stale effort then goes to the scene's safe value",
        0.0,
        1.0e6,
    ),
    Row(
        "joint_command_hold",
        True,
        "hold a ~/joint_command while its sender is there; false = command_timeout runs at once",
    ),
    Row(
        "force_limit",
        0.0,
        "N to which the force of an external wrench is cut; 0 = what follows from the arm",
        1.0e-9,
        1.0e12,
        zero=True,
    ),
    Row(
        "moment_limit",
        0.0,
        "N·m to which its moment is cut; 0 = what follows from the arm",
        1.0e-9,
        1.0e12,
        zero=True,
    ),
    Row(
        "frame_id",
        "world",
        "frame of poses, and of external wrenches that do not say 'tip'",
        longest=255,
    ),
    Row("poses", 51, "number of backbone poses, base to tip", 2, 10000),
    Row(
        "publish_clock",
        True,
        "publish /clock: exactly one node of a graph may own time; false with use_sim_time",
    ),
    Row(
        "clock_rate",
        0.0,
        "messages on /clock per simulated second, Hz; 0 = one with every state",
        0.1,
        100000.0,
        zero=True,
    ),
    Row(
        "follow_clock",
        LOCK_STEP,
        "with use_sim_time, how /clock is followed: lock_step = as soon as it has come, "
        "resampled = evenly, one tick behind",
        choices=(LOCK_STEP, RESAMPLED),
    ),
    Row("publish_tf", False, "publish the frames base and tip on /tf (needs tf2_msgs)"),
    Row("tf_frames", "", "joints and rigid bodies also on /tf, with commas; 'all' for all"),
    Row("tf_backbone", False, "publish the backbone's poses as frames on /tf, too"),
    Row(
        "marker_rate",
        30.0,
        "how often the arm is drawn on ~/markers, per real second, Hz; 0 = never",
        0.1,
        1000.0,
        zero=True,
    ),
    Row("start_paused", False, "wait for ~/pause or ~/step before the first step"),
    Row("step_count", 0, "steps of one ~/step; 0 = one publish period", 0, 1000000, live=True),
    Row("reset_time", False, "~/reset also sets the time of stamps back to 0", live=True),
    Row("exit_on_error", False, "end when the solver gives up, instead of holding the last state"),
)
ROWS = {row.name: row for row in TABLE}
# Overrides under these names belong to rclpy itself.
_RCLPY = ("use_sim_time", "start_type_description_service")
QOS = "qos_overrides."
USE_SIM_TIME = "use_sim_time"
ALIKE = 0.8  # two letters of ten: from here on a name is taken for another one, misspelt


class Settings(SimpleNamespace):
    """Values of all parameters at the start, as attributes.

    ``time`` says whose time it is: OWN, or how that of another is followed.
    """

    time = OWN


def strangers(node, shared: Collection[str]) -> list[str]:
    """Return the parameters that are for other nodes: in a shared file, and like none of ours."""
    return [name for name in _unknown_names(node) if name in shared and not _near(name, ALIKE)]


def _unknown_names(node) -> list[str]:
    return [
        name
        for name in node._parameter_overrides
        if name not in ROWS and name not in _RCLPY and not name.startswith(QOS)
    ]


def declare(node, others: Collection[str] = (), shared: Collection[str] = ()) -> Settings:
    """Declare the table on ``node``, give the values; all faults come in one ParameterError.

    ``others`` are parameters of other nodes, which are passed over; ``shared`` are those that only
    come from entries for nodes of any name.
    """
    overrides = {name: p.value for name, p in node._parameter_overrides.items()}
    unknown = [name for name in _unknown_names(node) if name not in others]
    # The nearest name costs time, and the first faults only are said.
    faults = [_unknown(name) for name in unknown[:20]] + unknown[20:]
    values = {}
    for row in TABLE:
        try:
            values[row.name] = row.accept(overrides.get(row.name, row.default))
        except ValueError as error:
            faults.append(str(error))
    if values.get("frame_id") in ("", "tip"):
        faults.append(
            f"frame_id = {values['frame_id']!r}: expected a frame other than '' and 'tip', "
            "which external wrenches give another meaning"
        )
    if faults:
        raise ParameterError(faults)
    values["publish_clock"], time = whose_time(values, overrides, shared)
    # The overrides are in the values already, and as whole numbers rclpy would refuse them.
    for row in TABLE:
        node.declare_parameter(row.name, values[row.name], row.descriptor(), ignore_override=True)
    node.add_pre_set_parameters_callback(_whole_numbers_are_numbers)
    settings = Settings(**values)
    if time != OWN:
        settings.time = time
    return settings


def whose_time(
    values: dict[str, Any], overrides: dict[str, object], shared: Collection[str]
) -> tuple[bool, str]:
    """Return whether the node publishes /clock, and OWN or how it follows another's.

    Nobody follows a clock that he publishes: an arm with ``use_sim_time`` follows, unless it is
    told to publish. Said to all nodes of a stack, ``use_sim_time`` is for those who follow: then
    the arm is the owner of time, unless it is told not to publish.
    """
    told = "publish_clock" in overrides
    publishes = bool(values["publish_clock"])
    follows = overrides.get(USE_SIM_TIME) is True
    if follows and not told and USE_SIM_TIME not in shared:
        publishes = False
    return publishes, values["follow_clock"] if follows and not publishes else OWN


def on_change(node, apply) -> None:
    """Call ``apply(name, value)`` for every live parameter that is changed to a usable value."""

    def validate(parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name in ROWS:
                try:
                    ROWS[parameter.name].accept(parameter.value)
                except ValueError as error:
                    return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def changed(parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name in ROWS:
                apply(parameter.name, parameter.value)

    node.add_on_set_parameters_callback(validate)
    node.add_post_set_parameters_callback(changed)


def _whole_numbers_are_numbers(parameters: list[Parameter]) -> list[Parameter]:
    """Let ``ros2 param set … real_time_factor 1`` mean 1.0."""
    return [
        Parameter(p.name, Parameter.Type.DOUBLE, float(p.value))
        if p.type_ == Parameter.Type.INTEGER
        and p.name in ROWS
        and isinstance(ROWS[p.name].default, float)
        else p
        for p in parameters
    ]


def _unknown(name: str) -> str:
    near = _near(name, 0.0)
    hint = f"; the nearest known one is {near[0]!r}" if near else ""
    return f"unknown parameter {shown(name, 200)}{hint}"


def _near(name: str, alike: float) -> list[str]:
    """Return the known name that is nearest to ``name``, if they are alike enough (0 to 1)."""
    return difflib.get_close_matches(name[:200].lower(), [*ROWS, *_RCLPY], n=1, cutoff=alike)
