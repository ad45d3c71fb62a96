"""A clean recording put in the place of a torn one, in steps that can be taken up again.

It is written into the folder ``.recovering``. When it is whole and on the disk, a plan of what goes
where is put beside that folder: before that moment nothing has happened, after it only the rest of
the plan has to be carried out, by the next call. The plan is deleted last.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from soft_sim_ros.errors import RecordingError, UnfitFile
from soft_sim_ros.files import read_bytes
from soft_sim_ros.recording.find import PENDING

WORKING = ".recovering"
BACKUP = "torn"
_RESULT = {"messages", "counts", "last_time", "torn", "damaged_chunks"}
_MOST_PLAN = 4_000_000  # bytes


def commit(target: Path, originals: Sequence[str], result: Mapping[str, Any]) -> None:
    """Decide that the clean recording in ``.recovering`` takes its place.

    Parameters
    ----------
    target : folder in which it lies
    originals : names of files in it that go aside first
    result : what ``finish`` shall return
    """
    backup, number = BACKUP, 1
    while originals and (target / backup).exists():
        number += 1
        backup = f"{BACKUP}{number}"
    working = target / WORKING
    plan = {
        "originals": list(originals),
        "backup": backup if originals else None,
        "clean": sorted(file.name for file in working.iterdir()),
        "result": dict(result),
    }
    draft = target / (PENDING + ".new")
    with draft.open("w", encoding="utf-8") as stream:
        json.dump(plan, stream)
        stream.flush()
        os.fsync(stream.fileno())
    _sync(working)
    draft.replace(target / PENDING)


def finish(target: Path) -> dict[str, Any] | None:
    """Carry out what is left of a plan and return its result; None if there is no plan.

    Raises
    ------
    RecordingError
        if files cannot be moved, after which it can be called again; or if the plan is invalid
    """
    if not (target / PENDING).exists():
        return None
    working = target / WORKING
    try:
        plan = _checked(target, _read(target / PENDING))
        result: dict[str, Any] = plan["result"] | {"backup": None}
        if plan["backup"]:
            result["backup"] = backup = target / plan["backup"]
            _put_aside(target, backup, plan)
        for name in plan["clean"]:
            if (working / name).exists():
                (working / name).rename(target / name)
        _sync(target)
        if working.exists():
            working.rmdir()
        (target / PENDING).unlink()
    except OSError as error:
        raise RecordingError(target, f"cannot be written: {error.strerror}") from error
    return result


def _put_aside(target: Path, backup: Path, plan: Mapping[str, Any]) -> None:
    backup.mkdir(exist_ok=True)
    begun = any((backup / name).exists() for name in plan["originals"])
    if not begun:
        missing = [name for name in plan["clean"] if not (target / WORKING / name).exists()]
        if missing:
            reason = f"{WORKING} lacks {missing[0]}: remove {PENDING} and recover again"
            raise RecordingError(target, reason)
    for name in plan["originals"]:
        # the clean ones come later: what has the name now, and is not aside, is an original
        if not (backup / name).exists() and (target / name).exists():
            (target / name).rename(backup / name)
    _sync(backup)


def _checked(target: Path, plan: Any) -> dict[str, Any]:
    """Return a plan that moves nothing out of its folder: it may come from anywhere."""
    try:
        names = [*plan["originals"], *plan["clean"]]
        plain = all(name not in ("", ".", "..") and "/" not in name for name in names)
        backup = plan["backup"] is None or re.fullmatch(rf"{BACKUP}\d*", plan["backup"])
        whole = bool(plain and backup and plan["result"].keys() == _RESULT)
    except (KeyError, TypeError, AttributeError):
        whole = False
    if not whole:
        raise RecordingError(target / PENDING, "is no plan of a recovery")
    return dict(plan)


def _read(path: Path) -> Any:
    try:
        return json.loads(read_bytes(path, _MOST_PLAN))
    except (ValueError, RecursionError, UnfitFile):
        return None


def _sync(folder: Path) -> None:
    """Have the disk know the names in a folder."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
