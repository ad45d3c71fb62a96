"""A clean recording out of a torn one."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.bag import Bag
from soft_sim_ros.recording.mcap_file import RECORD_NAME
from soft_sim_ros.recording.metadata import FILE_NAME
from soft_sim_ros.recording.scan import scan


@dataclass(frozen=True)
class Recovered:
    """What was saved.

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
    files of the directory, such as ``summary.json``, are copied along.

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
    last = 0

    def note(time_ns: int, _index: int, _data: bytes) -> None:
        nonlocal last
        last = max(last, time_ns)

    content = scan(source, note)  # first the topics, then, in a second pass, the messages
    folder = source.parent if source.is_file() else source
    stem = source.stem if source.is_file() else source.name
    target = Path(out).resolve() if out is not None else folder.parent / f"{stem}_recovered"
    in_place = target == folder
    working = folder / ".recovering" if in_place else target
    if in_place and working.exists():
        shutil.rmtree(working)  # left by an attempt that was cut short; the original is untouched
    bag = Bag(
        working,
        content.channels,
        metadata=content.metadata.get(RECORD_NAME, {}),
        attachments=content.attachments,
        name=target.name,
    )

    def copy(time_ns: int, index: int, data: bytes) -> None:
        bag.add(index, time_ns, data)
        if bag.staged:
            bag.commit()

    try:
        scan(source, copy)
        bag.close()
    except OSError as reason:
        bag.abandon()
        raise RecordingError(working, f"cannot be written: {reason.strerror}") from reason
    backup = None
    if in_place:
        backup = _swap(folder, working, content.files)
    elif source.is_dir():
        _copy_others(source, target)
    return Recovered(
        target,
        sum(bag.kept().values()),
        bag.kept(),
        last / 1e9,
        content.torn,
        content.damaged,
        backup,
    )


def _swap(folder: Path, working: Path, originals: list[Path]) -> Path:
    """Put the original files aside and the clean ones in their place."""
    backup = folder / "torn"
    number = 1
    while backup.exists():
        number += 1
        backup = folder / f"torn{number}"
    backup.mkdir()
    for file in [*originals, folder / FILE_NAME]:
        if file.exists():
            file.rename(backup / file.name)
    for file in working.iterdir():
        file.rename(folder / file.name)
    working.rmdir()
    return backup


def _copy_others(source: Path, target: Path) -> None:
    for file in source.iterdir():
        if file.is_file() and file.suffix != ".mcap" and file.name != FILE_NAME:
            if not (target / file.name).exists():
                shutil.copy2(file, target / file.name)
