"""Message types by name, from installed packages of messages and from nowhere else."""

from __future__ import annotations

import os
import re
import sys
from importlib import import_module
from pathlib import Path

from soft_sim_ros.recording.messages import TYPE_HASHES

_NAME = re.compile(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)")
# in which every package of messages lists what it has
_INDEX = "share/ament_index/resource_index/rosidl_interfaces"


def installed_type(name: str):
    """Class of a message type such as ``geometry_msgs/msg/PoseArray``; None if it is not installed.

    A name in a recording must not be able to import just any module: only types count that this
    package uses itself, or that an installed package has registered.
    """
    match = _NAME.fullmatch(name)
    if match is None or not (name in TYPE_HASHES or _registered(*match.groups())):
        return None
    package, short = match.groups()
    return getattr(import_module(f"{package}.msg"), short, None)


def _registered(package: str, short: str) -> bool:
    """Whether a package of messages has this type, by the index of a sourced ROS, or of ours."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    for prefix in filter(None, prefixes):
        try:
            listed = Path(prefix, _INDEX, package).read_text("utf-8").split()
        except (OSError, ValueError):
            continue
        if f"msg/{short}.msg" in listed or f"msg/{short}.idl" in listed:
            return True
    return False
