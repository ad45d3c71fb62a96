"""The ``metadata.yaml`` of a rosbag2 directory, version 9 as ROS 2 Jazzy writes it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from soft_sim_ros.recording.claims import profiles, qualities
from soft_sim_ros.recording.topics import Qos

FILE_NAME = "metadata.yaml"
DISTRIBUTION = "jazzy"
_FOREVER = {"sec": 9223372036, "nsec": 854775807}


@dataclass(frozen=True)
class Channel:
    """One topic as a recording describes it: enough to publish it again, or to copy it.

    Parameters
    ----------
    topic, type : full names
    schema : definition of the type, encoded as ``schema_encoding`` says
    metadata : of the MCAP channel: ``offered_qos_profiles`` and ``topic_type_hash``
    encoding, schema_encoding : ``cdr`` and ``ros2msg``
    """

    topic: str
    type: str
    schema: str
    metadata: dict[str, str]
    encoding: str = "cdr"
    schema_encoding: str = "ros2msg"

    @property
    def qos(self) -> Qos:
        """Quality of service recorded for the topic; what is not known is the default."""
        return Qos(**qualities(self.metadata.get("offered_qos_profiles", "")))


@dataclass
class FileSummary:
    """Counts and times of one MCAP file; times in ns."""

    path: str
    start: int = 0
    end: int = 0
    counts: dict[str, int] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(self.counts.values())


def qos_profiles(qos: Qos) -> list[dict[str, Any]]:
    """Describe a quality of service the way rosbag2 does."""
    return [
        {
            "history": qos.history,
            "depth": qos.depth,
            "reliability": qos.reliability,
            "durability": qos.durability,
            "deadline": dict(_FOREVER),
            "lifespan": dict(_FOREVER),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(_FOREVER),
            "avoid_ros_namespace_conventions": False,
        }
    ]


def dump(value: object) -> str:
    """Write YAML in the given order; rosbag2's parser gets neither aliases nor wrapped lines."""
    return yaml.safe_dump(value, sort_keys=False, default_flow_style=False, width=1_000_000)


def describe(
    channels: Sequence[Channel], files: Sequence[FileSummary], custom: dict[str, str]
) -> dict[str, Any]:
    """Describe a recording in the fields and the order of rosbag2."""
    filled = [file for file in files if file.count]
    start = min((file.start for file in filled), default=0)
    end = max((file.end for file in filled), default=0)
    topics = []
    for channel in channels:
        offered = profiles(channel.metadata.get("offered_qos_profiles", ""))
        topics.append(
            {
                "topic_metadata": {
                    "name": channel.topic,
                    "type": channel.type,
                    "serialization_format": channel.encoding,
                    "offered_qos_profiles": deepcopy(list(offered)),  # shared, it were an alias
                    "type_description_hash": channel.metadata.get("topic_type_hash", ""),
                },
                "message_count": sum(file.counts.get(channel.topic, 0) for file in files),
            }
        )
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(file.count for file in files),
        "topics_with_message_count": topics,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.path for file in files],
        "files": [
            {
                "path": file.path,
                "starting_time": {"nanoseconds_since_epoch": file.start},
                "duration": {"nanoseconds": file.end - file.start},
                "message_count": file.count,
            }
            for file in files
        ],
        "custom_data": dict(custom) or None,
        "ros_distro": DISTRIBUTION,
    }


def write_metadata(directory: Path, description: dict[str, Any]) -> None:
    """Write ``metadata.yaml`` so that at any moment a whole one is there, the old or the new."""
    temporary = directory / f".{FILE_NAME}.{os.getpid()}"
    try:
        temporary.write_text(dump({"rosbag2_bagfile_information": description}), "utf-8")
        temporary.replace(directory / FILE_NAME)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
