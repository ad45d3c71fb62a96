"""Files from outside, read within bounds; files of ours, written whole or not at all."""

from __future__ import annotations

import os
import stat
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from soft_sim_ros.errors import UnfitFile

MOST_TABLE = 32_000_000  # bytes of a table of commands or of a measured motion
MOST_ARRAYS = 256_000_000  # bytes of the arrays of one .npz file
_KINDS = (
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def read_bytes(path: str | Path, most: int) -> bytes:
    """Return what a regular file of at most ``most`` bytes holds.

    Raises
    ------
    UnfitFile
        if it is something else, such as a device or a pipe that might never end, or larger
    OSError
        if it cannot be read
    """
    # without waiting for the other end of a pipe
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    try:
        status = os.fstat(file)
        for fits, kind in _KINDS:
            if fits(status.st_mode):
                raise UnfitFile(path, f"is {kind}", "a regular file")
        if status.st_size > most:
            raise UnfitFile(path, f"has {status.st_size} bytes", f"at most {most}")
        parts, size = [], 0
        while part := os.read(file, 1 << 20):
            size += len(part)
            if size > most:  # it grows, or has no known size, as files in /proc
                raise UnfitFile(path, f"has more than {most} bytes", f"at most {most}")
            parts.append(part)
        return b"".join(parts)
    finally:
        os.close(file)


def read_text(path: str | Path, most: int) -> str:
    """Return a text file of at most ``most`` bytes; a mark of its byte order is left out.

    Raises
    ------
    UnfitFile, OSError
        as ``read_bytes``, and if it is not UTF-8
    """
    try:
        return read_bytes(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UnfitFile(path, f"is no text (byte {error.start})", "UTF-8") from error


def read_npz(path: str | Path) -> dict[str, NDArray]:
    """Return the arrays of an ``.npz`` file, which may hold MOST_ARRAYS bytes in all.

    Raises
    ------
    UnfitFile, OSError
        as ``read_bytes``, and if it is no such file, or would unpack to more
    """
    content = BytesIO(read_bytes(path, MOST_ARRAYS))
    try:
        with zipfile.ZipFile(content) as archive:
            size = sum(member.file_size for member in archive.infolist())
            if size > MOST_ARRAYS:
                raise UnfitFile(path, f"unpacks to {size} bytes", f"at most {MOST_ARRAYS}")
            for member in archive.infolist():
                _check_header(archive, member)
        content.seek(0)
        with np.load(content, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name]) for name in arrays.files}
    except (ValueError, TypeError, KeyError, EOFError, OSError, zipfile.BadZipFile) as error:
        if isinstance(error, UnfitFile):
            raise
        raise UnfitFile(path, f"is no .npz file ({error})", "arrays of numbers") from error
    except (NotImplementedError, RuntimeError, SyntaxError) as error:  # of zipfile, and of headers
        raise UnfitFile(path, f"is no .npz file ({error})", "arrays of numbers") from error


def _check_header(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> None:
    """Refuse an array whose header promises more than the member holds: it would be allocated."""
    with archive.open(member) as stream:
        version = npy.read_magic(stream)
        read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
        if version not in read:
            raise ValueError(f"{member.filename} has a header of version {version}")
        shape, _, kind = read[version](stream)
        promised = kind.itemsize
        for length in shape:
            promised *= length
        if promised > member.file_size:
            raise ValueError(f"{member.filename} promises {promised} bytes")


def write_whole(path: str | Path, content: bytes | str) -> None:
    """Write a file so that at any moment a whole one is there, the old or the new."""
    path = Path(path)
    if isinstance(content, str):
        content = content.encode()
    if path.exists() and not path.is_file():  # /dev/stdout and the like
        path.write_bytes(content)
        return
    new = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        new.write_bytes(content)
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise
