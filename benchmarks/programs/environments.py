"""Environments of the peers under benchmarks/.envs, made on demand with pinned versions."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

ENVS = Path(__file__).resolve().parent.parent / ".envs"
PINS = {
    "elastica": ("pyelastica==1.0.0", "numba==0.68.1", "numpy==2.4.6"),
    "exudyn": ("exudyn==1.13.6", "numpy==2.4.6"),
    "mujoco": ("mujoco==4.0.0", "numpy==2.4.6"),
    "soromox": ("soromox==0.5.0", "jax==0.10.2", "diffrax==0.7.2", "numpy==2.4.6"),
}
# Guards and libraries of a sourced ROS do not belong into the peers' processes.
FOREIGN = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH", "PYTHONPATH")


def clean() -> dict[str, str]:
    """Return the process environment without what belongs to ROS; one thread for everything."""
    kept = {key: value for key, value in os.environ.items() if key not in FOREIGN}
    single = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
    return kept | dict.fromkeys(single, "1") | {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}


def interpreter(name: str) -> Path:
    """Return the Python of a peer's environment, making it if it is missing or of other pins."""
    home = ENVS / name
    python, stamp = home / "bin" / "python", home / "pins.txt"
    wanted = "\n".join(PINS[name])
    if stamp.is_file() and stamp.read_text() == wanted:
        return python
    print(f"making the environment of {name}: {', '.join(PINS[name])}", flush=True)
    shutil.rmtree(home, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "venv", str(home)], check=True)
    command = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*command, *PINS[name]], check=True, env=clean())
    stamp.write_text(wanted)
    return python
