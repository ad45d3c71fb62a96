"""Recovery of a clean recording from one that was not closed."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.bag import Bag
from soft_sim_ros.recording.mcap_file import RECORD_NAME
from soft_sim_ros.recording.metadata import FILE_NAME
from soft_sim_ros.recording.scan import Scan, scan
from soft_sim_ros.recording.swap import WORKING, commit, finish


@dataclass(frozen=True)
class Recovered:
    """The result of a recovery.

    Parameters
    ----------
    directory : the clean recording
    messages : number of messages in it
    counts : number of messages by topic
    last_time : time of the last message, s
    torn : whether the original lacked its end
    damaged_chunks : parts of the original that had to be left out
    backup : where the original files went, if it was recovered in place
    """

    directory: Path
    messages: int
    counts: dict[str, int]
    last_time: float
    torn: bool
    damaged_chunks: int
    backup: Path | None


def recover(directory: str | Path, out: str | Path | None = None) -> Recovered:
    """Write a clean recording with everything that is whole in a torn one.

    Topics, definitions, qualities of service, attachments and metadata stay as they were. Other
    files of the directory, such as ``summary.json``, are copied along. Killed at any moment, it can
    be called again with the same arguments: nothing is lost, and it ends as if it had not been.

    Parameters
    ----------
    directory : rosbag2 directory, or one MCAP file
    out : where the clean recording goes, ``<directory>_recovered`` if not given; the same
        directory means in place, with the original files moved to ``torn/`` inside it

    Raises
    ------
    RecordingError
        if there is nothing to read, or ``out`` already holds a recording
    """
    source = Path(directory).resolve()
    folder = source.parent if source.is_file() else source
    stem = source.stem if source.is_file() else source.name
    target = Path(out).resolve() if out is not None else folder.parent / f"{stem}_recovered"
    in_place = target == folder
    for place in {folder, target}:
        finished = finish(place)  # an attempt that was cut short while it moved files
        if finished is not None and place == target:
            return Recovered(place, **finished)
    last = 0

    def note(time_ns: int, _index: int, _data: bytes) -> None:
        nonlocal last
        last = max(last, time_ns)

    content = scan(source, note)  # first the topics, then, in a second pass, the messages
    if not in_place:
        _refuse_to_overwrite(target)
    elif source.is_file() and len(list(folder.glob("*.mcap"))) > 1:
        reason = "is one of several files: give the directory to recover them in place"
        raise RecordingError(source, reason)
    result: dict[str, Any] = {
        "messages": 0,
        "counts": {},
        "last_time": last / 1e9,
        "torn": content.torn,
        "damaged_chunks": content.damaged,
    }
    described = (folder / FILE_NAME).exists()
    if in_place and described and not content.torn and not content.damaged:
        counts = _counts(source, content)
        return Recovered(
            target, **result | {"messages": sum(counts.values()), "counts": counts}, backup=None
        )
    new, working = not target.exists(), target / WORKING
    try:
        target.mkdir(parents=True, exist_ok=True)
        if working.exists():
            shutil.rmtree(working)  # left by an attempt that was cut short; nothing was moved yet
        result["counts"] = _write(content, source, working, target.name)
        if not in_place and source.is_dir():
            _copy_others(source, working, target)
    except (OSError, RecordingError) as reason:
        shutil.rmtree(working, ignore_errors=True)
        if new and target.is_dir() and not any(target.iterdir()):
            target.rmdir()
        if isinstance(reason, RecordingError):
            raise
        raise RecordingError(target, f"cannot be written: {reason.strerror}") from reason
    result["messages"] = sum(result["counts"].values())
    originals = [file.name for file in content.files] if in_place else []
    originals += [FILE_NAME] if in_place and described else []
    try:
        commit(target, originals, result)
    except OSError as reason:
        raise RecordingError(target, f"cannot be written: {reason.strerror}") from reason
    finished = finish(target)
    assert finished is not None  # it was committed just now
    return Recovered(target, **finished)


def _counts(source: Path, content: Scan) -> dict[str, int]:
    """Count the messages of a whole recording, by topic."""
    counts = dict.fromkeys((channel.topic for channel in content.channels), 0)

    def count(time_ns: int, index: int, data: bytes) -> None:
        counts[content.channels[index].topic] += 1

    scan(source, count)
    return counts


def _write(content: Scan, source: Path, working: Path, name: str) -> dict[str, int]:
    """Write the clean recording into a folder of its own; return what is in it, by topic."""
    bag = Bag(
        working,
        content.channels,
        metadata=content.metadata.get(RECORD_NAME, {}),
        attachments=content.attachments,
        name=name,
    )

    def copy(time_ns: int, index: int, data: bytes) -> None:
        bag.add(index, time_ns, data)
        if bag.staged:
            bag.commit()

    try:
        scan(source, copy)
        bag.close()
    except BaseException:
        bag.abandon()
        raise
    return bag.kept()


def _refuse_to_overwrite(target: Path) -> None:
    held = sorted(target.glob("*.mcap")) if target.is_dir() else []
    held += [target / FILE_NAME] if (target / FILE_NAME).exists() else []
    if held:
        reason = f"already holds a recording ({held[0].name}); expected a new or an empty directory"
        raise RecordingError(target, reason)


def _copy_others(source: Path, working: Path, target: Path) -> None:
    for file in source.iterdir():
        wanted = file.is_file() and file.suffix != ".mcap" and file.name != FILE_NAME
        if wanted and not (target / file.name).exists():
            shutil.copy2(file, working / file.name)
