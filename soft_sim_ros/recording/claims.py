"""Checks of the metadata of a recording before it is used.

Recordings may come from anywhere. Texts and numbers from their metadata, attachments and summaries
are checked here: an invalid one leads to a RecordingError that names it, or is left out if nothing
depends on it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from soft_sim_ros.errors import RecordingError, SceneError, UnfitFile
from soft_sim_ros.files import read_bytes
from soft_sim_ros.foreign import printable
from soft_sim_ros.scene.document import Document
from soft_sim_ros.scene.edit import child

MOST_POSES = 10_000
MOST_JSON = 16_000_000  # bytes of a summary
MOST_YAML = 1_000_000  # characters of YAML that rosbag2 writes
_DEEPEST = 20  # levels of it
_LONGEST_WAIT = 1.0e6  # s of a timeout
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_QUALITIES = {
    "reliability": ("reliable", "best_effort"),
    "durability": ("volatile", "transient_local"),
    "history": ("keep_last", "keep_all"),
}
_DEEPEST_QUEUE = 100_000
REMAPPED = "remapped"  # key of a JSON mapping: a topic's own name → the one it was heard under


def words(path: object, name: str, data: bytes) -> str:
    """Return a text from inside a recording.

    Raises
    ------
    RecordingError
        if it is not UTF-8
    """
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        reason = f"holds a {name} that is no text (byte {error.start}): expected UTF-8"
        raise RecordingError(path, reason) from error


def plain_yaml(text: str) -> Any:
    """Return the content of a YAML text of rosbag2; None if it is not plain YAML.

    Plain is what rosbag2 writes: without aliases, and not very deep.
    """
    if len(text) > MOST_YAML:
        return None
    try:
        depth = 0
        for event in yaml.parse(text, Loader=_Loader):
            if isinstance(event, yaml.AliasEvent):
                return None
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
            if depth > _DEEPEST:
                return None
        return yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        return None


@lru_cache(maxsize=256)
def profiles(text: str) -> tuple[dict[str, Any], ...]:
    """Return the qualities of service of a channel as they are written; nothing if they are odd."""
    found = plain_yaml(text)
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        return ()
    return tuple(found)


def qualities(text: str) -> dict[str, Any]:
    """Return the valid policies and the depth of the first profile of a channel.

    ``ros2 bag record`` writes what a subscription cannot know as ``unknown`` and depth 0.
    """
    first = next(iter(profiles(text)), {})
    known = {
        key: first[key]
        for key, allowed in _QUALITIES.items()
        if isinstance(first.get(key), str) and first[key] in allowed
    }
    depth = first.get("depth")
    if type(depth) is int and 0 < depth <= _DEEPEST_QUEUE:
        known["depth"] = depth
    return known


@dataclass(frozen=True)
class Facts:
    """The facts that a re-simulation needs in addition to the scene.

    Parameters
    ----------
    node : full name of the node
    poses : number of backbone poses
    frame_id : frame of the poses
    command_timeout, command_ramp : s
    joint_command_hold : whether joint commands have no timeout while their sender is there
    """

    node: str
    poses: int
    frame_id: str
    command_timeout: float
    command_ramp: float
    joint_command_hold: bool = False


def facts(path: object, metadata: Mapping[str, str]) -> Facts:
    """Return the facts of a recording that has them all.

    Raises
    ------
    RecordingError
        which names the fact, what it says, and what was expected
    """
    return Facts(
        metadata["node"],
        int(_number(path, metadata, "poses", 2, MOST_POSES, whole=True)),
        metadata["frame_id"],
        _number(path, metadata, "command_timeout", 0.0, _LONGEST_WAIT),
        _number(path, metadata, "command_ramp", 0.0, _LONGEST_WAIT),
        metadata.get("joint_command_hold") == "True",  # older recordings have none
    )


def remapped(path: object, metadata: Mapping[str, str]) -> dict[str, str]:
    """Return the topics that were heard under another name than their own, with that name.

    Raises
    ------
    RecordingError
        if it is not a mapping of texts
    """
    if REMAPPED not in metadata:
        return {}
    found = _json(path, f"says {REMAPPED} that ", metadata[REMAPPED].encode())
    if not all(isinstance(name, str) for name in found.values()):
        raise RecordingError(path, f"says {REMAPPED} with names that are no texts")
    return found


def _number(
    path: object,
    metadata: Mapping[str, str],
    key: str,
    low: float,
    high: float,
    whole: bool = False,
) -> float:
    written = metadata[key]
    try:
        value = float(written)
    except ValueError:
        value = math.nan
    if not low <= value <= high or (whole and value != int(value)):
        kind = "a whole number" if whole else "a number"
        said = f"{key} = {printable(written[:60])!r}"
        raise RecordingError(path, f"says {said}: expected {kind} from {low:g} to {high:g}")
    return value


def scene_name(text: str) -> str | None:
    """Return the name that the text of a scene gives it; None if it gives none, or is no scene."""
    try:
        found = child(Document.parse(text, "scene.yaml").root, "name")
    except SceneError:
        return None  # it could be simulated once: a scene of a later version, or damaged
    return str(found.value) if isinstance(found, yaml.ScalarNode) else None


def machine(path: object, attachments: Mapping[str, bytes]) -> dict[str, str]:
    """Return the facts of the machine, those that are texts; nothing if none are inside.

    Raises
    ------
    RecordingError
        if they cannot be read
    """
    data = attachments.get("machine.json")
    found = {} if data is None else _json(path, "holds a machine.json that ", data)
    return {key: value for key, value in found.items() if isinstance(value, str)}


def summary(path: Path) -> dict[str, Any]:
    """Return the summary beside a recording without invalid entries; {} if there is none.

    Raises
    ------
    RecordingError
        if it cannot be read
    """
    try:
        data = read_bytes(path, MOST_JSON)
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except UnfitFile as error:
        raise RecordingError(path, f"{error.found}: expected {error.expected}") from error
    except OSError as error:
        raise RecordingError(path, f"cannot be read: {error.strerror}") from error
    found = _json(path, "", data)
    kinds: dict[str, Any] = {
        "real_time_factor": _is_number, "overruns": _is_number, "ended_by": _is_text,
        "last_error": _is_text, "recording": _is_mapping, "step_cost": _is_mapping,
        "solver": _is_mapping, "accuracy": _is_mapping, "estimate": _is_mapping,
        "space": _is_mapping,
    }  # fmt: skip
    fitting = {key: value for key, value in found.items() if kinds.get(key, _anything)(value)}
    return {**fitting, **_parts(fitting)}


def _parts(found: dict[str, Any]) -> dict[str, Any]:
    """Return the parts of a summary with only those entries that are numbers where they must be."""
    out: dict[str, Any] = {}
    cost = found.get("step_cost")
    if cost is not None:
        bins = cost.get("histogram")
        whole = isinstance(bins, list) and len(bins) <= 10_000 and all(map(_is_bin, bins))
        numbers = {key: value for key, value in cost.items() if _is_number(value)}
        out["step_cost"] = numbers | {"histogram": bins if whole else []}
    recording = found.get("recording")
    if recording is not None and not _is_number(recording.get("dropped")):
        out["recording"] = {key: v for key, v in recording.items() if key != "dropped"}
    if found.get("accuracy") is not None and not _has_numbers(
        found["accuracy"], ("tolerance",), ("error_rel", "error_rad", "orientation_tolerance")
    ):
        out["accuracy"] = None
    if found.get("space") is not None and not _has_numbers(
        found["space"], ("limit",), ("error_rel",)
    ):
        out["space"] = None
    return out


def _has_numbers(found: dict[str, Any], needed: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Whether the needed entries are numbers, and others are if they are there."""
    return all(_is_number(found.get(key)) for key in needed) and all(
        found.get(key) is None or _is_number(found[key]) for key in others
    )


def _is_bin(one: object) -> bool:
    if not isinstance(one, dict):
        return False
    begin, end, steps = one.get("from_us"), one.get("to_us"), one.get("steps")
    ends = (0.0 if value is None else value for value in (begin, end))
    sane = all(_is_number(value) and 0.0 <= value < 1e15 for value in ends)
    return sane and begin is not None and end != 0.0 and type(steps) is int and steps >= 0


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300  # false for NaN too


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def _is_mapping(value: object) -> bool:
    return isinstance(value, dict)


def _anything(value: object) -> bool:
    return True


def _json(path: object, which: str, data: bytes) -> dict[str, Any]:
    try:
        found = json.loads(data.decode())
    except (ValueError, RecursionError) as error:  # also of bytes that are no UTF-8
        raise RecordingError(path, f"{which}is not JSON: {error}") from error
    if not isinstance(found, dict):
        kind = type(found).__name__
        raise RecordingError(path, f"{which}is a {kind}: expected names and values")
    return found
