"""Facts about the machine and the versions a run was made with."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "mcap")


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    """Name the processor; Linux keeps the name people know in /proc/cpuinfo."""
    try:
        lines = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    for line in lines:
        key, _, value = line.partition(":")
        if key.strip() in ("model name", "Model"):
            return value.strip()
    return platform.machine()


def _system() -> str:
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        return platform.system()
    return release.get("PRETTY_NAME", platform.system())


def machine_facts() -> dict[str, str]:
    """Give what the bits and the speed of a run may depend on, as text by name."""
    from soft_sim_ros.version import __version__

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    facts = {
        "soft_sim_ros": __version__,
        "processor": _processor(),
        "architecture": platform.machine(),
        "cores": str(cores),
        "system": _system(),
        "kernel": platform.release(),
        "python": platform.python_version(),
    }
    facts.update({name: _version(name) for name in PACKAGES})
    facts["ros_distro"] = os.environ.get("ROS_DISTRO", "")
    return facts
