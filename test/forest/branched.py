"""The scenes of several branches beside this file."""

from __future__ import annotations

from pathlib import Path

NAMES = ("two_arms", "palm", "ring")


def file_of(name: str) -> Path:
    """Return the file of a scene."""
    return Path(__file__).with_name(f"{name}.yaml")
