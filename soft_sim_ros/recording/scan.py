"""Reading MCAP files that may be torn, damaged or still being written.

The usual readers begin at the end of a file, where its indices are; a recording that was never
closed has no end. This one goes through the records from the beginning, checks every chunk, and
keeps whatever is whole.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap import records
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from zstandard import ZstdError

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.find import find_files
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.unpack import (
    MOST_RECORD,
    OVERHEAD,
    Budget,
    Strict,
    attachment,
    unpacked,
)

MAGIC = b"\x89MCAP0\r\n"
_RECORD = struct.Struct("<BQ")  # opcode, length of what follows
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_LATEST = 2**63 - 1  # ns
_MOST_CHANNELS = 4096

# what the decompressors and parsers of the mcap package say about bytes they cannot use
_BAD_BYTES = (McapError, ValueError, struct.error, RuntimeError, ZstdError)

Take = Callable[[int, int, bytes], None]


class _Torn(Exception):
    """The file ends, or stops making sense, before its footer."""


@dataclass
class Scan:
    """What could be read of a recording.

    Parameters
    ----------
    path : directory or file it was read from
    files : its MCAP files, in order
    channels : topics, in the order they were first seen
    messages : (log time in ns, index of the channel, data), in the order they were written;
        empty if they were handed on instead
    attachments : files kept inside, by name
    metadata : metadata records, by name; the last of each name
    torn : whether a file lacks its end
    damaged : number of chunks and records that had to be left out, or are not as they were written
    """

    path: Path
    files: list[Path] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    messages: list[tuple[int, int, bytes]] = field(default_factory=list)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    torn: bool = False
    damaged: int = 0


def scan(path: str | Path, take: Take | None = None) -> Scan:
    """Read everything that is whole in a recording.

    Parameters
    ----------
    path : rosbag2 directory, or one MCAP file
    take : called with (log time in ns, index of the channel, data) of every message, instead of
        keeping the messages in memory

    Raises
    ------
    RecordingError
        if there is no recording there, or a file is not MCAP
    """
    found = Scan(Path(path), find_files(path))
    if take is None:

        def take(time_ns: int, index: int, data: bytes) -> None:
            found.messages.append((time_ns, index, data))

    budget = Budget(found.path)
    for file in found.files:
        with file.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                if file.stat().st_size >= len(MAGIC):
                    raise RecordingError(file, "is not an MCAP file: its first bytes are others")
                found.torn = True
                continue
            try:
                _scan_file(stream, file.stat().st_size, found, take, budget)
            except _Torn:
                found.torn = True
    return found


def _scan_file(stream: BinaryIO, size: int, found: Scan, take: Take, budget: Budget) -> None:
    parser = _Parser(found, take, budget)
    crc, before = zlib.crc32(MAGIC), found.damaged
    without_magic = 0  # some leave it out of the checksum
    over = empty = False
    for opcode, head, body in _records(stream, size):
        budget.add(len(head) + len(body or b""))
        if over:
            # A summary for readers that begin at the end: it repeats what was there, and is not
            # looked at. Only an empty recording has its topics nowhere else.
            if empty and body is not None and opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                parser.one(opcode, body)
            continue
        over = opcode == Opcode.DATA_END
        empty = not found.channels
        if body is None:
            found.damaged += 1
        elif not over:
            crc, without_magic = (
                zlib.crc32(body, zlib.crc32(head, c)) for c in (crc, without_magic)
            )
            parser.one(opcode, body)
        elif found.damaged == before:
            # what no checksum of a chunk covers, such as the facts of the run
            parser.check(body, (crc, without_magic))
    found.damaged += not over


def _records(stream: BinaryIO, size: int) -> Iterator[tuple[int, bytes, bytes | None]]:
    """Yield (opcode, head, body) up to the footer; raise _Torn if there is none.

    There is no body where it would be too large to be one.
    """
    while True:
        head = stream.read(_RECORD.size)
        if len(head) < _RECORD.size:
            raise _Torn
        opcode, length = _RECORD.unpack(head)
        if opcode == 0 or length > size - stream.tell():
            raise _Torn  # a record cut short, or bytes that are no record
        if opcode == Opcode.FOOTER:
            if size - stream.tell() != length + len(MAGIC) or stream.read()[length:] != MAGIC:
                raise _Torn  # not the end, so no footer
            return
        if length > MOST_RECORD:
            stream.seek(length, 1)
            yield opcode, head, None
        else:
            yield opcode, head, stream.read(length)


class _Parser:
    """Takes the channels and messages of one file; its numbers of channels are its own."""

    def __init__(self, found: Scan, take: Take, budget: Budget) -> None:
        self._found, self._take, self._budget = found, take, budget
        self._schemas: dict[int, records.Schema] = {}
        self._indices: dict[int, int] = {}  # channel number: index in found.channels
        self._known = {_identity(channel): i for i, channel in enumerate(found.channels)}

    def one(self, opcode: int, body: bytes) -> None:
        """Take a record; count it if it cannot be used."""
        try:
            if opcode == Opcode.CHUNK:
                self._chunk(body)
            elif opcode == Opcode.ATTACHMENT:
                found = attachment(body)
                self._found.attachments[found.name] = found.data
            elif opcode == Opcode.METADATA:
                metadata = records.Metadata.read(Strict(body))
                self._found.metadata[metadata.name] = metadata.metadata
            else:
                self._inner(opcode, body)
        except _BAD_BYTES:
            self._found.damaged += 1

    def check(self, body: bytes, checksums: tuple[int, ...]) -> None:
        """Compare the checksum of everything before the end of the data with what is written."""
        try:
            (written,) = struct.unpack_from("<I", body)
        except struct.error:
            written = -1
        self._found.damaged += written not in (0, *checksums)

    def _chunk(self, body: bytes) -> None:
        data = unpacked(body, self._budget)
        at, length = 0, len(data)
        while at < length:
            opcode, size = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            if size > length - at:
                raise ValueError(f"a record of {size} bytes in the {length - at} that are left")
            self._budget.spend(size + OVERHEAD)
            try:
                self._inner(opcode, data[at : at + size])
            except _BAD_BYTES:
                self._found.damaged += 1
            at += size

    def _inner(self, opcode: int, body: bytes) -> None:
        """Take a message, channel or schema; everything else is bookkeeping of the file."""
        if opcode == Opcode.MESSAGE:
            number, _, log_time, _ = _MESSAGE.unpack_from(body)
            if number not in self._indices:
                raise ValueError(f"message of the unknown channel {number}")
            if log_time > _LATEST:
                raise ValueError(f"message at {log_time} ns, beyond {_LATEST}")
            self._take(log_time, self._indices[number], body[_MESSAGE.size :])
        elif opcode == Opcode.SCHEMA:
            schema = records.Schema.read(Strict(body))
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._channel(records.Channel.read(Strict(body)))

    def _channel(self, raw: records.Channel) -> None:
        schema = self._schemas.get(raw.schema_id) or records.Schema(0, b"", "", "")
        channel = Channel(
            raw.topic,
            schema.name,
            schema.data.decode(errors="surrogateescape"),
            raw.metadata,
            raw.message_encoding,
            schema.encoding,
        )
        channels, identity = self._found.channels, _identity(channel)
        if identity not in self._known:
            if len(channels) == _MOST_CHANNELS:
                reason = f"has more than {_MOST_CHANNELS} topics: expected a recording"
                raise RecordingError(self._found.path, reason)
            self._known[identity] = len(channels)
            channels.append(channel)
        self._indices[raw.id] = self._known[identity]


def _identity(channel: Channel) -> tuple[object, ...]:
    return (
        channel.topic, channel.type, channel.schema, channel.encoding, channel.schema_encoding,
        tuple(sorted(channel.metadata.items())),
    )  # fmt: skip
