"""The folders of the package's own files: in a source tree, a colcon workspace or a pip prefix."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

PACKAGE = "soft_sim_ros"


def _candidates() -> Iterator[Path]:
    """Folders that may hold ``config`` and ``launch``, the one that came with this code first."""
    here = Path(__file__).resolve()
    for parent in here.parents:
        if (parent / "package.xml").is_file() and parent / PACKAGE == here.parent:
            yield parent  # a source tree, also behind an editable or a symlink install
        yield parent / "share" / PACKAGE  # the prefix whose site-packages hold this file
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        yield Path(prefix) / "share" / PACKAGE
    yield Path(sys.prefix) / "share" / PACKAGE


def config_directory() -> Path:
    """Give the folder of the scenes that come with the package.

    Raises
    ------
    FileNotFoundError
        if the package was installed without its data files
    """
    tried = []
    for folder in _candidates():
        config = folder / "config"
        if config.is_dir():
            return config
        tried.append(str(config))
    raise FileNotFoundError(f"no scenes of {PACKAGE} in any of: {', '.join(tried)}")
