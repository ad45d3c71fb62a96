"""How long a first and a later start take: ``python -m benchmarks.startup``.

A first start compiles the kernels: it is measured with an empty folder for them, once for the
default arm, then once more for all other packaged scenes. Later starts load them: import, scene,
simulation and first step of the default arm, each the best of several processes. Wall times are
those of the machine as it is; CPU times, of all processes, are disturbed less by other work.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from . import machine

FILE = Path(__file__).parent / "results" / "startup.json"
ROOT = Path(__file__).parents[1]
DEFAULT = "soft_arm"
STARTS = 5
COMPILE = """
import sys
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.scene import load_scene, packaged_scenes
for name in sys.argv[1:] or packaged_scenes():
    warm_up(load_scene(name))
"""
START = """
import json, sys, time
times, last = {}, time.perf_counter()
def book(what):
    global last
    now = time.perf_counter()
    times[what], last = now - last, now
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene
book("import")
scene = load_scene(sys.argv[1])
book("scene")
simulation = Simulation(scene)
book("simulation")
simulation.advance(1)
book("first step")
print(json.dumps(times))
"""


def run(code: str, folder: str, *arguments: str) -> tuple[dict[str, float], str]:
    """Run code in a process of its own, kernels in ``folder``; return wall and CPU s and output."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=os.environ | {"NUMBA_CACHE_DIR": folder},
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"wall_s": round(wall, 2), "cpu_s": round(cpu, 2)}, done.stdout


def measured() -> dict[str, object]:
    """Return everything that is measured."""
    with tempfile.TemporaryDirectory() as folder:
        first, _ = run(COMPILE, folder, DEFAULT)
        rest, _ = run(COMPILE, folder)
        whole, parts = [], []
        for _ in range(STARTS):
            total, told = run(START, folder, DEFAULT)
            whole.append(total)
            parts.append(json.loads(told))
    return {
        f"first start, {DEFAULT}": first,
        "then all other packaged scenes": rest,
        f"later start, {DEFAULT}": {key: min(one[key] for one in whole) for key in rest},
        "of which": {key: round(min(one[key] for one in parts), 3) for key in parts[0]},
    }


def main() -> None:
    """Measure, store, tell."""
    found = measured()
    FILE.write_text(json.dumps({"starts": found, "machine": machine.facts()}, indent=1) + "\n")
    for name, values in found.items():
        assert isinstance(values, dict)
        told = ", ".join(f"{key} {value:.3g}" for key, value in values.items())
        print(f"{name:34} {told}")


if __name__ == "__main__":
    main()
