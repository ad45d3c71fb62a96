"""Facts about the machine and the versions that a number was measured with."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path


def facts() -> dict[str, str | int]:
    """Return processor, cores, memory in GiB, kernel, Python and versions that matter."""
    cpu = "unknown"
    info = Path("/proc/cpuinfo")
    if info.is_file():
        lines = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = lines[0].partition(":")[2].strip() if lines else cpu
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {
        "cpu": cpu,
        "cores": os.cpu_count() or 0,
        "memory_gib": round(memory),
        "system": platform.system() + " " + platform.release(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
        "commit": commit(),
    }


def commit() -> str:
    """Return the commit of the tree, with + where files differ from it."""
    git = ["git", "-C", str(Path(__file__).parent)]
    head = subprocess.run([*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    if head.returncode:
        return "unknown"
    core = ["diff", "--quiet", "HEAD", "--", "../soft_sim_ros"]
    changed = subprocess.run([*git, *core], capture_output=True).returncode
    return head.stdout.strip() + ("+" if changed else "")
