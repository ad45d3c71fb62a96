"""Where compiled kernels are kept, so that they are never stale and processes may share them.

Numba keys its cache on the file of the function alone, so an edit to a function *called* by a
cached one would go unnoticed. Here the folder carries a digest of every kernel source, and lies in
the user's cache directory, so a read-only installation works too.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from numba.core import config as _config
from numba.core.caching import FunctionCache as _FunctionCache

_settings: Any = _config  # set at import, out of sight of type checkers
_cache: Any = _FunctionCache


def _digest() -> str:
    """Digest of all kernel sources and the numba version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Folder of the compiled kernels of exactly these sources.

    ``NUMBA_CACHE_DIR``, then ``XDG_CACHE_HOME``, then ``~/.cache`` are asked in this order.
    """
    root = os.environ.get("NUMBA_CACHE_DIR") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "soft_sim_ros"
    )
    return Path(root) / f"kernels-{_digest()}"


_FOLDER = cache_directory()


@contextmanager
def _alone() -> Iterator[None]:
    """Hold the lock of the folder, against other processes."""
    _FOLDER.mkdir(parents=True, exist_ok=True)
    with open(_FOLDER / "lock", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield  # closing the file gives the lock back


class Disk(_cache):
    """Numba's cache of one function in this folder, for several processes at once.

    Numba's own reads the index of a function, adds to it and writes it back: two processes that
    compile it for different types could leave an index that names the code of one for the types of
    the other.
    """

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, alone."""
        with _alone():
            super().save_overload(sig, data)

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
