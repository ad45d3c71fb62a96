"""A rosbag2 directory: MCAP files and their ``metadata.yaml``, written synchronously."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording import messages
from soft_sim_ros.recording.mcap_file import RECORD_NAME, McapFile
from soft_sim_ros.recording.metadata import (
    FILE_NAME,
    Channel,
    FileSummary,
    describe,
    dump,
    qos_profiles,
    write_metadata,
)
from soft_sim_ros.recording.topics import Topic

SPLIT_BYTES = 2 * 1024**3
SPLIT_COMMITS = 20_000  # at four a second, after an hour and a half at least


def channel(topic: Topic) -> Channel:
    """Describe one of our topics as a channel."""
    return Channel(
        topic.name,
        topic.type,
        messages.schema(topic.type),
        {
            "offered_qos_profiles": dump(qos_profiles(topic.qos)),
            "topic_type_hash": messages.TYPE_HASHES[topic.type],
        },
    )


class Bag:
    """A recording being written.

    Long runs are cut into files of at most about ``split_bytes``, so that the indices kept in
    memory stay small. ``commit`` and ``close`` raise OSError when the disk fails; nothing is
    lost by that as long as they are called again before the next ``add``.

    Parameters
    ----------
    directory : where the recording goes; made if missing, refused if it holds a recording
    channels : topics, in the order of the indices given to ``add``
    metadata : facts about the run, by name
    attachments : files kept inside the recording, by name
    name : beginning of the file names; the name of the directory if not given
    split_bytes : size at which a new file is begun
    """

    def __init__(
        self,
        directory: Path,
        channels: Sequence[Channel],
        *,
        metadata: Mapping[str, str],
        attachments: Mapping[str, bytes],
        name: str | None = None,
        split_bytes: int = SPLIT_BYTES,
    ) -> None:
        self.directory = directory = Path(directory)
        present = sorted(directory.glob("*.mcap")) if directory.is_dir() else []
        if present or (directory / FILE_NAME).exists():
            held = present[0].name if present else FILE_NAME
            reason = f"already holds a recording ({held}); expected a new or an empty directory"
            raise RecordingError(directory, reason)
        self._name = name or directory.resolve().name
        self._channels = tuple(channels)
        self._metadata = dict(metadata)
        self._attachments = dict(attachments)
        self._split_bytes = split_bytes
        self._files: list[FileSummary] = []
        self._gone: set[str] = set()  # finished files that others have removed
        try:
            directory.mkdir(parents=True, exist_ok=True)
            self._file = self._next_file()
            self._file.commit()
            write_metadata(directory, self._describe())
        except OSError as reason:
            raise RecordingError(directory, f"cannot be written: {reason.strerror}") from reason

    @property
    def staged(self) -> int:
        """Bytes waiting for the disk, without the chunk in progress."""
        return self._file.staged

    def taken(self) -> dict[str, int]:
        """Count the messages taken so far, by topic."""
        return self._sum([file.counts for file in self._present()])

    def kept(self) -> dict[str, int]:
        """Count the messages on disk, by topic."""
        finished = [file.counts for file in self._present() if file is not self._file.summary]
        return self._sum([*finished, self._file.kept])

    def add(self, channel: int, time_ns: int, data: bytes, sequence: int = 0) -> None:
        """Take one message of the channel with this index."""
        self._file.add(channel, time_ns, data, sequence)

    def commit(self) -> None:
        """Put every message on disk, and begin a new file if this one has become large."""
        self._file.commit()
        if self._file.size >= self._split_bytes or self._file.commits >= SPLIT_COMMITS:
            self._file.finish(self._describe())
            self._file.commit()
            self._file.sync()
            self._file.close()
            self._file = self._next_file()

    def close(self) -> None:
        """Complete the recording."""
        self._file.finish(self._describe())
        self._file.commit()
        self._file.sync()
        self._file.close()
        write_metadata(self.directory, self._describe())

    def abandon(self) -> None:
        """Stop recording without closing: the files are complete up to the last commit."""
        self._file.close()

    def trouble(self) -> str:
        """Describe changes of the open file by other programs; empty if none."""
        trouble = self._file.trouble()
        return trouble and f"{self._file.path} {trouble}"

    def gone(self) -> list[FileSummary]:
        """Find finished files that are no longer there; each is given once, and then forgotten."""
        missing = [
            file
            for file in self._present()
            if file is not self._file.summary and not (self.directory / file.path).exists()
        ]
        self._gone.update(file.path for file in missing)
        return missing

    def let_go(self) -> None:
        """Complete the file, also if it was moved; a deleted one is not counted."""
        self._file.forget()
        self._file.finish(self._describe())
        self._file.commit()
        self._file.forget()

    def _next_file(self) -> McapFile:
        path = self.directory / f"{self._name}_{len(self._files)}.mcap"
        summaries = [*self._present(), FileSummary(path.name)]
        description = describe(self._channels, summaries, self._metadata)
        records = {
            RECORD_NAME: self._metadata,
            "rosbag2": {"serialized_metadata": dump(description)},
        }
        file = McapFile(path, self._channels, records, self._attachments)
        self._files.append(file.summary)
        return file

    def _describe(self) -> dict[str, Any]:
        return describe(self._channels, self._present(), self._metadata)

    def _present(self) -> list[FileSummary]:
        return [file for file in self._files if file.path not in self._gone]

    @staticmethod
    def _sum(parts: Sequence[Mapping[str, int]]) -> dict[str, int]:
        total: dict[str, int] = {}
        for part in parts:
            for topic, count in part.items():
                total[topic] = total.get(topic, 0) + count
        return total
