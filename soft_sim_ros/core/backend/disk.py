"""Where compiled kernels are kept, so that they are never stale and processes may share them.

Numba keys its cache on the file of the function alone, so an edit to a function *called* by a
cached one would go unnoticed. Here the folder carries a digest of every kernel source, and lies in
the user's cache directory, so a read-only installation works too.

Files in it are executed. So they are used only if no other user can have written them
(``trusted.py``), and every file carries a digest of itself: a damaged one is compiled again.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import pickle
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import config as _config
from numba.core.caching import FunctionCache as _FunctionCache
from numba.core.caching import IndexDataCacheFile as _IndexDataCacheFile

from .trusted import make_private, read_own, usable, write_own

_settings: Any = _config  # set at import, out of sight of type checkers
_cache: Any = _FunctionCache
_files: Any = _IndexDataCacheFile
_DIGEST = hashlib.sha256().digest_size  # bytes, at the beginning of every file


class KernelCacheWarning(UserWarning):
    """Compiled kernels are kept elsewhere than asked for, or not at all."""


# of core/, in which kernels stand, or structs that they know by the order of their fields
ROOMS = ("backend", "algebra", "model", "contact", "terms", "recursion", "integrators")


def _digest() -> str:
    """Digest of all kernel sources and the numba version."""
    digest = hashlib.sha256(numba.__version__.encode())
    core = Path(__file__).parents[1]
    for room in ROOMS:
        for source in sorted((core / room).glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Folder of the compiled kernels of exactly these sources.

    ``NUMBA_CACHE_DIR``, then ``XDG_CACHE_HOME``, then ``~/.cache`` are asked in this order. A
    private one in the folder for temporary files stands in for one that others can write to.
    """
    root = os.environ.get("NUMBA_CACHE_DIR") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "soft_sim_ros"
    )
    folder, refusal = usable(Path(root), f"kernels-{_digest()}")
    if refusal:
        _complaints.append(f"{refusal}: compiled kernels are kept in {folder} instead")
    return folder


_complaints: list[str] = []
_said: set[str] = set()
_FOLDER = cache_directory()
with suppress(OSError):  # reported when a kernel is to be kept
    make_private(_FOLDER)  # numba would make it as open as the umask lets it


def _say() -> None:
    """Warn of a problem with the folder, once per problem."""
    while _complaints:
        text = _complaints.pop()
        if text not in _said:
            _said.add(text)
            warnings.warn(text, KernelCacheWarning, stacklevel=2)


@contextmanager
def _alone() -> Iterator[None]:
    """Hold the lock of the folder, against other processes."""
    make_private(_FOLDER)
    lock = os.open(_FOLDER / "lock", os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)  # gives the lock back


class _Files(_files):
    """Index and data of one function, each beginning with a digest of its name and content."""

    def _load_index(self) -> dict[Any, str]:
        content = self._read(self._index_path)
        version, stamp, overloads = (None, None, {}) if content is None else content
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        content = self._read(self._data_path(name))
        if content is None:
            raise OSError(f"{name} is damaged")  # numba takes that for a file that is gone
        return content

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _read(self, path: str) -> Any:
        """Return what a file holds; None if there is none, or none that can be trusted."""
        content = read_own(path)
        if content is None or content[:_DIGEST] != _sealed(path, content[_DIGEST:]):
            return None
        return pickle.loads(content[_DIGEST:])

    def _write(self, path: str, value: Any) -> None:
        content = self._dump(value)
        write_own(path, _sealed(path, content) + content)


def _sealed(path: str, content: bytes) -> bytes:
    """Digest of a file: its name belongs to it, so that none can stand in for another."""
    digest = hashlib.sha256(os.path.basename(path).encode() + b"\0")
    digest.update(content)
    return digest.digest()


class Disk(_cache):
    """Numba's cache of one function in this folder, for several processes at once.

    Numba's own reads the index of a function, adds to it and writes it back: two processes that
    compile it for different types could leave an index that names the code of one for the types of
    the other. Whatever happens to the files, the worst is that a function is compiled again.
    """

    _cache_file: Any

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        theirs = self._cache_file
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, theirs._source_stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a compiled function, None if it has to be compiled."""
        _say()
        return super().load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, alone; on a disk that refuses, it serves this process only."""
        try:
            with _alone():
                super().save_overload(sig, data)
        except OSError as error:
            _complaints.append(f"{_FOLDER}: compiled kernels cannot be kept: {error.strerror}")
            _say()

    def holds(self, sig: Any, context: Any) -> bool:
        """Return whether it is compiled for the types ``sig``."""
        return self._index_key(sig, context.codegen()) in self._cache_file._load_index()


def keep(dispatcher: Any) -> Any:
    """Let a compiled function be kept in the folder; return it."""
    before = _settings.CACHE_DIR
    _settings.CACHE_DIR = str(_FOLDER)
    try:
        if hasattr(dispatcher, "overloads"):  # not where NUMBA_DISABLE_JIT is set
            dispatcher._cache = Disk(dispatcher.py_func)  # the folder is chosen here, once
    finally:
        _settings.CACHE_DIR = before
    return dispatcher
