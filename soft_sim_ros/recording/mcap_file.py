"""One MCAP file that stays readable when the disk fails.

The ``mcap`` writer keeps account of offsets, so a write that fails half-way would spoil all that
follows. Here it writes into a stage in memory. The stage is taken over by the disk in one piece
or not at all: after a failure the file is cut back to its last whole record and the stage is kept
for the next attempt. Whatever happens, the file is a whole beginning of a recording.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import mcap
from mcap.writer import CompressionType, Writer

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.metadata import Channel, FileSummary, dump

PROFILE = "ros2"
RECORD_NAME = "soft_sim_ros"  # of the metadata record with facts about the run
# lz4 with 256 KiB: the worst message costs 2 ms, 7 ms with 1 MiB of zstd; files are a fifth larger
CHUNK_BYTES = 256 * 1024
_MEDIA_TYPES = {".yaml": "application/yaml", ".json": "application/json", ".csv": "text/csv"}


class Stage:
    """What the ``mcap`` writer takes for its file: bytes on disk, then bytes still in memory."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        self._bytes = bytearray()
        self.committed = 0

    def __len__(self) -> int:
        return len(self._bytes)

    def write(self, data: bytes) -> int:
        """Take bytes into memory."""
        self._bytes += data
        return len(data)

    def tell(self) -> int:
        """Give the size of the file once everything is on disk."""
        return self.committed + len(self._bytes)

    def flush(self) -> None:
        """Do nothing: ``commit`` writes to the disk."""

    def commit(self) -> None:
        """Put everything on disk, or raise OSError and leave the file as it was."""
        view = memoryview(self._bytes)
        done = 0
        try:
            while done < len(view):
                done += os.pwrite(self._file, view[done:], self.committed + done)
        except OSError:
            os.ftruncate(self._file, self.committed)
            raise
        finally:
            view.release()
        self.committed += done
        self._bytes.clear()

    def sync(self) -> None:
        """Have the disk hold what the operating system has."""
        if self._file >= 0:
            os.fsync(self._file)

    def close(self) -> None:
        """Give the file up; what is still in memory is lost."""
        if self._file >= 0:
            file, self._file = self._file, -1
            os.close(file)

    def trouble(self) -> str:
        """Say what others have done to the file; empty if nothing."""
        if self._file < 0:
            return ""
        ours = os.fstat(self._file)
        if ours.st_nlink == 0:
            return "was deleted"
        if ours.st_size < self.committed:
            return f"was cut to {ours.st_size} of {self.committed} bytes by somebody else"
        try:
            there = os.stat(self.path)
        except (FileNotFoundError, NotADirectoryError):
            return "was moved away"
        # on some network disks the number of a file changes, but then it is as large as ours
        same = (there.st_dev, there.st_ino) == (ours.st_dev, ours.st_ino)
        return "" if same or there.st_size == ours.st_size else "was replaced by another file"

    @property
    def named(self) -> bool:
        """Whether the file still has a name somewhere."""
        return self._file >= 0 and os.fstat(self._file).st_nlink > 0


class McapFile:
    """One file of a recording, written synchronously.

    Parameters
    ----------
    path : file to make; it must not exist
    channels : topics, in the order of the indices given to ``add``
    records : metadata records by name, written first
    attachments : files inside the file, by name, written first
    """

    def __init__(
        self,
        path: Path,
        channels: Sequence[Channel],
        records: Mapping[str, Mapping[str, str]],
        attachments: Mapping[str, bytes],
    ) -> None:
        if not hasattr(Writer, "flush"):
            version = getattr(mcap, "__version__", "older")
            raise RecordingError(path, f"mcap {version} cannot flush; expected mcap >= 1.5")
        self.path = path
        self.summary = FileSummary(path.name)
        self.kept: dict[str, int] = {}  # messages on disk, by topic
        self.commits = 0  # each ends a chunk, whose index stays in memory
        self._channels = channels
        self._stage = Stage(path)
        self._finished = False
        self._writer = Writer(
            self._stage,  # type: ignore[arg-type]
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.LZ4,
            enable_data_crcs=True,
        )
        self._writer.start(PROFILE)
        now = time.time_ns()
        for name, entries in records.items():
            self._writer.add_metadata(name, dict(entries))
        for name, data in attachments.items():
            media_type = _MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream")
            self._writer.add_attachment(now, now, name, media_type, data)
        schemas: dict[tuple[str, str, str], int] = {}
        self._ids = []
        for channel in channels:
            key = (channel.type, channel.schema_encoding, channel.schema)
            if key not in schemas:
                schemas[key] = self._writer.register_schema(
                    channel.type,
                    channel.schema_encoding,
                    channel.schema.encode(errors="surrogateescape"),
                )
            self._ids.append(
                self._writer.register_channel(
                    channel.topic, channel.encoding, schemas[key], channel.metadata
                )
            )

    @property
    def size(self) -> int:
        """Bytes on disk and waiting for it, without the chunk in progress."""
        return self._stage.tell()

    @property
    def staged(self) -> int:
        """Bytes waiting for the disk."""
        return len(self._stage)

    def add(self, channel: int, time_ns: int, data: bytes, sequence: int = 0) -> None:
        """Take one message; nothing reaches the disk before ``commit``."""
        self._writer.add_message(self._ids[channel], time_ns, data, time_ns, sequence)
        summary, topic = self.summary, self._channels[channel].topic
        if not summary.counts:
            summary.start = summary.end = time_ns
        summary.start = min(summary.start, time_ns)
        summary.end = max(summary.end, time_ns)
        summary.counts[topic] = summary.counts.get(topic, 0) + 1

    def commit(self) -> None:
        """Put every message on disk; after an OSError, call it again later."""
        if not self._finished:
            self._writer.flush()
        self.commits += bool(self._stage)
        self._stage.commit()
        self.kept = dict(self.summary.counts)

    def finish(self, description: Mapping[str, object]) -> None:
        """Add the metadata record of rosbag2 and the indices; only ``commit`` may follow."""
        if not self._finished:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": dump(dict(description))})
            self._writer.finish()
            self._finished = True

    def sync(self) -> None:
        """Have the disk hold what the operating system has."""
        self._stage.sync()

    def trouble(self) -> str:
        """Say what others have done to the file; empty if nothing."""
        return self._stage.trouble()

    def forget(self) -> None:
        """Count no messages of a deleted file."""
        if not self._stage.named:
            self.kept = {}

    def close(self) -> None:
        """Give the file up; what is not on disk is lost."""
        self._stage.close()
