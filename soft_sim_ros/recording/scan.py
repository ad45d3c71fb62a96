"""Reading MCAP files that may be torn, damaged or still being written.

The usual readers begin at the end of a file, where its indices are; a recording that was never
closed has no end. This one goes through the records from the beginning, checks every chunk, and
keeps whatever is whole.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import yaml
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.metadata import FILE_NAME, Channel

MAGIC = b"\x89MCAP0\r\n"
_RECORD = struct.Struct("<BQ")  # opcode, length of what follows
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time

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
    damaged : number of chunks that had to be left out
    """

    path: Path
    files: list[Path] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    messages: list[tuple[int, int, bytes]] = field(default_factory=list)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    torn: bool = False
    damaged: int = 0


def _number(path: Path) -> tuple[str, int]:
    match = re.fullmatch(r"(.*?)(\d*)", path.stem)
    assert match is not None  # every name matches
    return match[1], int(match[2] or -1)


def find_files(path: str | Path) -> list[Path]:
    """Find the MCAP files of a recording, in order.

    Parameters
    ----------
    path : a rosbag2 directory (``metadata.yaml`` may be missing), or one MCAP file
    """
    path = Path(path)
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise RecordingError(path, "does not exist; expected a rosbag2 directory or an .mcap file")
    files = sorted(path.glob("*.mcap"), key=_number)
    missing = [name for name in _listed(path) if not (path / name).exists()]
    if missing:
        named = ", ".join(missing)
        raise RecordingError(path, f"{FILE_NAME} names {named}, which is not there")
    if not files:
        inside = sorted(entry.name for entry in path.iterdir())
        found = ", ".join(inside[:8]) + (", …" if len(inside) > 8 else "")
        reason = f"is not a recording: expected *.mcap and {FILE_NAME}, found {found or 'nothing'}"
        raise RecordingError(path, reason)
    return files


def _listed(directory: Path) -> list[str]:
    """Give the MCAP files that metadata.yaml names; a damaged metadata.yaml names none."""
    try:
        content = yaml.safe_load((directory / FILE_NAME).read_text("utf-8"))
        names = content["rosbag2_bagfile_information"]["relative_file_paths"]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError):
        return []  # the files speak for themselves
    return [str(name) for name in names or []]


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

    for file in found.files:
        with file.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                if file.stat().st_size >= len(MAGIC):
                    raise RecordingError(file, "is not an MCAP file: its first bytes are others")
                found.torn = True
                continue
            try:
                _scan_file(stream, file.stat().st_size, found, take)
            except _Torn:
                found.torn = True
    return found


def _scan_file(stream: BinaryIO, size: int, found: Scan, take: Take) -> None:
    parser = _Parser(found, take)
    for opcode, body in _records(stream, size):
        try:
            if opcode == Opcode.CHUNK:
                parser.chunk(body)
            elif opcode == Opcode.ATTACHMENT:
                attachment = records.Attachment.read(ReadDataStream(BytesIO(body)))
                found.attachments[attachment.name] = attachment.data
            elif opcode == Opcode.METADATA:
                metadata = records.Metadata.read(ReadDataStream(BytesIO(body)))
                found.metadata[metadata.name] = metadata.metadata
            else:
                parser.record(opcode, body)
        except _BAD_BYTES:
            found.damaged += 1


def _records(stream: BinaryIO, size: int) -> Iterator[tuple[int, bytes]]:
    """Yield (opcode, body) up to the footer; raise _Torn if there is none."""
    while True:
        head = stream.read(_RECORD.size)
        if len(head) < _RECORD.size:
            raise _Torn
        opcode, length = _RECORD.unpack(head)
        if opcode == 0 or length > size - stream.tell():
            raise _Torn  # a record cut short, or bytes that are no record
        if opcode == Opcode.FOOTER:
            return
        yield opcode, stream.read(length)


class _Parser:
    """Takes the channels and messages of one file; its numbers of channels are its own."""

    def __init__(self, found: Scan, take: Take) -> None:
        self._found = found
        self._take = take
        self._schemas: dict[int, records.Schema] = {}
        self._indices: dict[int, int] = {}  # channel number: index in found.channels

    def chunk(self, body: bytes) -> None:
        chunk = records.Chunk.read(ReadDataStream(BytesIO(body)))
        content, length = get_chunk_data_stream(chunk, validate_crc=True)
        data = content.read(length)
        at = 0
        while at < length:
            opcode, size = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            self.record(opcode, data[at : at + size])
            at += size

    def record(self, opcode: int, body: bytes) -> None:
        """Take a message, channel or schema; everything else is bookkeeping of the file."""
        if opcode == Opcode.MESSAGE:
            number, _, log_time, _ = _MESSAGE.unpack_from(body)
            if number not in self._indices:
                raise ValueError(f"message of the unknown channel {number}")
            self._take(log_time, self._indices[number], body[_MESSAGE.size :])
        elif opcode == Opcode.SCHEMA:
            schema = records.Schema.read(ReadDataStream(BytesIO(body)))
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._channel(records.Channel.read(ReadDataStream(BytesIO(body))))

    def _channel(self, raw: records.Channel) -> None:
        schema = self._schemas.get(raw.schema_id) or records.Schema(0, b"", "", "")
        channel = Channel(
            raw.topic,
            schema.name,
            schema.data.decode(),
            raw.metadata,
            raw.message_encoding,
            schema.encoding,
        )
        channels = self._found.channels
        if channel not in channels:
            channels.append(channel)
        self._indices[raw.id] = channels.index(channel)
