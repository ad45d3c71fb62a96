"""The files of a recording, or the reason why there are none."""

from __future__ import annotations

import re
from pathlib import Path
from shlex import quote

from soft_sim_ros.errors import RecordingError, UnfitFile
from soft_sim_ros.files import read_text
from soft_sim_ros.foreign import printable
from soft_sim_ros.recording.claims import MOST_YAML, plain_yaml
from soft_sim_ros.recording.metadata import FILE_NAME

PENDING = ".recovering.json"  # says how a clean recording is put in its place
_OPTIONS = "output_bags: [{{uri: {uri}, storage_id: mcap, all: true}}]"


def find_files(path: str | Path) -> list[Path]:
    """Find the MCAP files of a recording, in order.

    Parameters
    ----------
    path : a rosbag2 directory (``metadata.yaml`` may be missing), or one MCAP file

    Raises
    ------
    RecordingError
        if there are none, or one of them is missing
    """
    path = Path(path)
    if path.is_file():
        if path.suffix == ".db3":
            raise RecordingError(path, f"is a sqlite3 bag, not an MCAP file; {convert(path)}")
        return [path]
    if not path.is_dir():
        is_what = "is no regular file" if path.exists() else "does not exist"
        raise RecordingError(path, f"{is_what}; expected a rosbag2 directory or an .mcap file")
    if (path / PENDING).exists():
        again = f"recover {quote(str(path))} --out {quote(str(path))}"
        reason = f"its recovery was cut short: `{again}` finishes it"
        raise RecordingError(path, reason)
    files = sorted(path.glob("*.mcap"), key=_number)
    missing = [name for name in _listed(path) if not (path / name).exists()]
    if missing and files:
        named = ", ".join(missing[:8])
        raise RecordingError(path, f"{FILE_NAME} names {printable(named)}, which is not there")
    if not files:
        inside = sorted(entry.name for entry in path.iterdir())
        found = printable(", ".join(inside[:8])) + (", …" if len(inside) > 8 else "")
        reason = f"is not a recording: expected *.mcap and {FILE_NAME}, found {found or 'nothing'}"
        if any(name.endswith((".db3", ".db3.zstd", ".mcap.zstd")) for name in inside):
            reason += f"; {convert(path)}"
        raise RecordingError(path, reason)
    for file in files:
        if not file.is_file():
            raise RecordingError(file, "is no regular file; expected an MCAP file")
    return files


def convert(path: Path) -> str:
    """Say how ROS makes an MCAP recording of a bag in another storage."""
    if path.suffix == ".db3" and (path.parent / FILE_NAME).exists():
        path = path.parent
    options = _OPTIONS.format(uri=path.resolve().stem + "_mcap")
    return (
        f"convert it first: echo {quote(options)} > convert.yaml && "
        f"ros2 bag convert -i {quote(str(path))} -o convert.yaml"
    )


def _number(path: Path) -> tuple[str, int]:
    match = re.fullmatch(r"(.*?)(\d*)", path.stem, re.DOTALL)
    assert match is not None  # every name matches
    return match[1], int(match[2][-18:] or -1)


def _listed(directory: Path) -> list[str]:
    """Give the MCAP files that metadata.yaml names; a damaged metadata.yaml names none."""
    try:
        content = plain_yaml(read_text(directory / FILE_NAME, MOST_YAML))
        names = content["rosbag2_bagfile_information"]["relative_file_paths"]
    except (OSError, UnfitFile, KeyError, TypeError):
        return []  # the files are found without it
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []
