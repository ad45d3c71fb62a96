"""Folders and files that only this user can have written: what lies in them may be run."""

from __future__ import annotations

import os
import stat
import tempfile
import uuid
from pathlib import Path

_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def usable(root: Path, name: str) -> tuple[Path, str]:
    """Return the folder ``name`` in ``root``, or a private one in its place with the reason.

    Parameters
    ----------
    root : where the user wants it
    name : of the folder in it

    Returns
    -------
    tuple of Path and str
        the folder, which need not exist yet, and what is wrong with ``root``; empty if nothing
    """
    refusal = _refusal(root, name)
    if not refusal:
        return root / name, ""
    private = Path(tempfile.gettempdir()) / f"soft_sim_ros-{os.geteuid()}"
    if _refusal(private, name):  # another user made it first
        private = Path(tempfile.mkdtemp(prefix="soft_sim_ros-"))
    return private / name, refusal


def _refusal(root: Path, name: str) -> str:
    """Say why a folder in ``root`` cannot be used; empty if it can."""
    for path in (root, root / name):
        try:
            status = path.stat()
        except FileNotFoundError:
            continue  # made when it is needed
        except OSError as error:
            return f"{path}: {error.strerror}"
        mine = (os.geteuid(), 0) if path == root else (os.geteuid(),)  # root may do all anyway
        if not stat.S_ISDIR(status.st_mode):
            return f"{path} is no folder"
        if status.st_uid not in mine:
            return f"{path} belongs to another user ({status.st_uid})"
        # with the sticky bit (/tmp) users cannot replace files of others
        sticky = path == root and status.st_mode & stat.S_ISVTX
        if status.st_mode & _OTHERS and not sticky:
            return f"{path} can be written by others (chmod go-w {path} would mend that)"
    if not (root / name).exists() and not os.access(_nearest(root), os.W_OK | os.X_OK):
        return f"{root} cannot be made"
    for path in root.resolve().parents:
        mode = path.stat().st_mode if path.exists() else 0
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"{root} can be replaced by others, who can write to {path}"
    return ""


def _nearest(path: Path) -> Path:
    """Return the nearest folder above that exists, or the path itself."""
    while not path.exists() and path != path.parent:
        path = path.parent
    return path


def make_private(folder: Path) -> None:
    """Make a folder, and the one it lies in, that only this user can write to."""
    folder.parent.parent.mkdir(parents=True, exist_ok=True)
    for path in (folder.parent, folder):
        path.mkdir(mode=0o700, exist_ok=True)


def read_own(path: str) -> bytes | None:
    """Return the content of a file that only this user can write; None if there is none."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError:
        return None
    try:
        status = os.fstat(file)
        mine = status.st_uid == os.geteuid() and not status.st_mode & _OTHERS
        if not stat.S_ISREG(status.st_mode) or not mine:
            return None
        with open(file, "rb", closefd=False) as stream:
            return stream.read()
    except OSError:
        return None
    finally:
        os.close(file)


def write_own(path: str, content: bytes) -> None:
    """Write a file atomically, with write permission for this user only."""
    if os.path.isdir(path):
        os.rename(path, f"{path}.{uuid.uuid4().hex[:8]}.not-a-file")
    new = f"{path}.tmp.{uuid.uuid4().hex[:16]}"
    file = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with open(file, "wb") as stream:
            stream.write(content)
        os.replace(new, path)
    except OSError:
        os.unlink(new)
        raise
