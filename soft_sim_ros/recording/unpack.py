"""Reads records of an MCAP file within bounds: their stated sizes are checked."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile

from soft_sim_ros.errors import RecordingError

ANYWAY = 128 * 1024 * 1024  # bytes that even a tiny file may unpack to ...
RATIO = 256  # ... and times its own size beyond that: lz4 cannot do better honestly
OVERHEAD = 160  # bytes that a message costs in memory beyond its data
MOST_RECORD = 256 * 1024 * 1024  # bytes


class Strict(ReadDataStream):
    """The body of a record; what ends too early is an error, not something shorter."""

    def __init__(self, body: bytes) -> None:
        super().__init__(BytesIO(body))

    def read(self, length: int) -> bytes:
        """Return exactly so many bytes."""
        data = super().read(length)
        if len(data) != length:
            raise EndOfFile
        return data


@dataclass
class Budget:
    """How much a recording may still unpack to; every byte that is read adds to it.

    Parameters
    ----------
    path : of the recording
    left : bytes
    """

    path: Path
    left: int = ANYWAY

    def add(self, read: int) -> None:
        """Take note of bytes read from the file."""
        self.left += RATIO * read

    def spend(self, size: int) -> None:
        """Take note of bytes unpacked; raise RecordingError when it is too much."""
        self.left -= size
        if self.left < 0:
            raise RecordingError(
                self.path,
                f"unpacks to more than {ANYWAY >> 20} MiB and {RATIO} times its own size: "
                "expected a recording",
            )


def unpacked(body: bytes, budget: Budget) -> bytes:
    """Return the records inside a chunk.

    Raises
    ------
    ValueError, and what decompressors raise
        if the chunk is damaged
    RecordingError
        if it unpacks to more than the budget has left
    """
    chunk = records.Chunk.read(Strict(body))
    # an impossible size is damage; a possible one is trusted up to the budget only
    size = chunk.uncompressed_size
    most = min(size, budget.left) + 1
    content = _decompressed(chunk.compression, chunk.data, most)
    if len(content) > budget.left:
        budget.spend(len(content))
    if len(content) != size:
        raise ValueError(f"unpacks to {len(content)} bytes or more, not to {size}")
    if chunk.uncompressed_crc not in (0, zlib.crc32(content)):
        raise ValueError("its checksum is another")
    return content


def _decompressed(kind: str, data: bytes, most: int) -> bytes:
    """Return at most ``most`` bytes of what was compressed."""
    if kind == "":
        return data[:most]
    if kind == "lz4":
        result = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most)
        return bytes(result)
    if kind == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(data) as stream:
            parts, left = [], most
            while left and (part := stream.read(min(left, 1 << 20))):
                parts.append(part)
                left -= len(part)
            return b"".join(parts)
    raise ValueError(f"is compressed by {kind[:20]!r}")


def attachment(body: bytes) -> Any:
    """Return an attachment.

    Raises
    ------
    ValueError, McapError
        if it is damaged
    """
    found = records.Attachment.read(Strict(body))
    crc = int.from_bytes(body[-4:], "little")
    if crc not in (0, zlib.crc32(body[:-4])):
        raise ValueError("its checksum is another")
    return found
