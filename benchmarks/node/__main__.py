"""The simulator node as a process: ``python -m benchmarks.node [--seconds S] [--starts N]``.

Writes benchmarks/results/node.json. The node that users start runs the default arm at a fixed step
of 1 ms in real time and publishes at 100 Hz; its peers are processes of their own on this machine.
Its CPU time comes from /proc/<pid>/stat, over ``--seconds`` after a second in which it settles; so
only Linux can run this. On a machine that is too busy the node runs slower than real time, which
costs less; so the share is also given over the real-time factor that was reached. A start is the
time from the birth of the process to the first pose that a peer, which waits for it, receives;
kernels are compiled before.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import statistics
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from soft_sim_ros.scene import load_scene
from soft_sim_ros.scene.edit import with_numbers

from .. import machine
from . import loop
from .processes import Process, process

FILE = Path(__file__).parents[1] / "results" / "node.json"
STEP, RATE = 0.001, 100.0  # s, Hz
SHARE_BAR, START_BAR = 0.10, 3.0
SETTLE = 1.0  # s

NODE = ["-m", "soft_sim_ros", "simulate", "--ros-args"]
PEER = ["-m", "benchmarks.node.peer"]
# What a node costs that does nothing: rclpy, its executor and DDS.
IDLE = (
    "import rclpy; from rclpy.experimental import EventsExecutor; rclpy.init(); "
    "e = EventsExecutor(); e.add_node(rclpy.create_node('idle')); print('ready: ', flush=True)\n"
    "try:\n  while rclpy.ok(): e.spin_once(timeout_sec=0.1)\nexcept BaseException: pass"
)


@dataclass(frozen=True)
class Case:
    """One way of running the node."""

    name: str
    peers: tuple[str, ...] = ()
    parameters: dict[str, Any] = field(default_factory=dict)
    record: bool = False
    program: list[str] | None = None


CASES = (
    Case("heard and commanded", ("listen", "drive")),
    Case("heard, commanded and recorded", ("listen", "drive"), record=True),
    Case("heard", ("listen",)),
    Case("nobody listens"),
    Case("paused, nobody listens", parameters={"start_paused": True}),
    Case("an rclpy node that does nothing", program=["-c", IDLE]),
)

HEARD = ("backbone", "joint_states")
# name, topics that are built, whether torques change with every message
LOOPS = (("heard and commanded", HEARD, True), ("heard", HEARD, False), ("nobody", (), False))


def arm(folder: Path) -> Path:
    """Write the scene: the default arm with a step of 1 ms."""
    scene = load_scene("soft_arm")
    path = folder / "arm.yaml"
    path.write_text(with_numbers(scene.source, scene.file, {"numerics.step": STEP}))
    return path


def command(scene: Path, **parameters: Any) -> list[str]:
    """Return the words that start the node."""
    given = {"scene": scene, "publish_rate": RATE, "real_time_factor": 1.0} | parameters
    return NODE + [word for item in given.items() for word in ("-p", "{}:={}".format(*item))]


def cost(case: Case, seconds: float, folder: Path) -> dict[str, Any]:
    """Run a case and return its share of a core, by thread too."""
    domain = random.randint(1, 200)
    parameters = dict(case.parameters)
    if case.record:
        parameters["record"] = tempfile.mkdtemp(dir=folder)
    words = case.program or command(folder / "arm.yaml", **parameters)
    with ExitStack() as stack:
        peers = [stack.enter_context(process([*PEER, role], domain)) for role in case.peers]
        for peer in peers:
            peer.wait_for("ready")
        node = stack.enter_context(process(words, domain))
        node.wait_for("ready: ")
        if "listen" in case.peers:
            peers[case.peers.index("listen")].wait_for("pose")
        time.sleep(SETTLE)
        begin, cpu, by, woke = time.monotonic(), node.cpu(), node.threads(), node.switches()
        time.sleep(seconds)
        wall, used, sleeps = time.monotonic() - begin, node.cpu() - cpu, node.switches() - woke
        threads = {
            name: (later - by.get(name, 0.0)) / wall for name, later in node.threads().items()
        }
        heard = [peer.result() for peer in peers]
    told = re.search(r"real-time factor ([\d.e+-]+)", node.last_words)
    factor = float(told[1]) if told else None
    return {
        "case": case.name,
        "share": used / wall,
        "real_time_factor": factor,
        "share_at_real_time": used / wall / (factor or 1.0),
        "sleeps_per_s": sleeps / wall,
        "seconds": wall,
        "threads": {name: share for name, share in sorted(threads.items()) if share > 0.0},
        "peers": dict(zip(case.peers, heard, strict=True)),
    }


def start(folder: Path) -> dict[str, float]:
    """Start the node once; return wall and CPU time in s to the first pose that is received."""
    domain = random.randint(1, 200)
    with process([*PEER, "listen"], domain) as listener:
        listener.wait_for("ready")
        begin = time.monotonic()
        with process(command(folder / "arm.yaml"), domain) as node:
            listener.wait_for("pose")
            cpu = node.cpu()
            node.wait_for("ready: ")
            first = listener.result()["first_pose"]
    return {"wall_s": first - begin, "cpu_s": cpu}


def starts(count: int, folder: Path) -> dict[str, Any]:
    """Return the best and the median of several starts."""
    runs = [start(folder) for _ in range(count)]
    return {
        key: {"best": min(values), "median": statistics.median(values), "all": values}
        for key in ("wall_s", "cpu_s")
        for values in ([run[key] for run in runs],)
    }


def compile_kernels(folder: Path) -> None:
    """Start the node once, so that everything it needs is on disk."""
    node: Process
    with process(command(folder / "arm.yaml"), random.randint(1, 200)) as node:
        node.wait_for("ready: ")


def main() -> int:
    """Measure, tell, and keep."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.node", description=__doc__)
    parser.add_argument("--seconds", type=float, default=15.0, help="of every case")
    parser.add_argument("--starts", type=int, default=7)
    parser.add_argument("--cases", nargs="*", help="parts of their names; all unless told")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        arm(folder)
        compile_kernels(folder)
        rows = []
        for case in CASES:
            if given.cases is not None and not any(part in case.name for part in given.cases):
                continue
            rows.append(cost(case, given.seconds, folder))
            print(f"{case.name:34} {100 * rows[-1]['share_at_real_time']:5.1f} % of a core, "
                  f"real-time factor {rows[-1]['real_time_factor'] or 0:.2f}, "
                  f"{rows[-1]['sleeps_per_s']:5.0f} sleeps per s")  # fmt: skip
            for thread, share in sorted(rows[-1]["threads"].items(), key=lambda row: -row[1])[:5]:
                print(f"    {thread:30} {100 * share:5.1f} %")
        computing = {}
        for name, heard, commanded in LOOPS:
            shares = [loop.share(folder / "arm.yaml", heard, commanded, 10.0) for _ in range(3)]
            computing[name] = min(shares)
            print(f"computing alone, {name:21} {100 * computing[name]:5.1f} %")
        first = starts(given.starts, folder) if given.starts else None
    if first:
        for key, values in first.items():
            print(f"start to first pose, {key}: best {values['best']:.2f}, "
                  f"median {values['median']:.2f}")  # fmt: skip
    if given.cases is None and first:
        kept = {
            "step_s": STEP,
            "publish_rate_hz": RATE,
            "share_bar": SHARE_BAR,
            "start_bar_s": START_BAR,
            "cases": rows,
            "computing_alone": computing,
            "start": first,
            "machine": machine.facts(),
        }
        FILE.write_text(json.dumps(kept, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
