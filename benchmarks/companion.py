"""What watching the tolerance costs a node: ``python -m benchmarks.companion``.

Writes benchmarks/results/companion.json. The default arm with a tolerance and nothing else written,
driven as the node drives it: six random torques every 100 ms, advanced from one control period of
4 ms to the next; alone, and with the companion that watches its error (docs/accuracy.md). The ratio
of the CPU times, the best of some runs, is what the companion costs.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.contract import choose
from soft_sim_ros.core.inputs import Inputs
from soft_sim_ros.core.refinement import words
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.core.watch import WatchedInputs
from soft_sim_ros.scene import Scene, load_scene, parse_scene

from . import machine
from .realtime import SHARE

FILE = Path(__file__).parent / "results" / "companion.json"
TOLERANCES = (1e-2, 1e-3, 1e-4)
STEP, PERIOD, HOLD, SECONDS, REPEATS = 0.001, 4, 100, 2.0, 3


def chosen(tolerance: float) -> Scene:
    """Return the default arm with what a tolerance makes of its numerics."""
    document = yaml.safe_load(load_scene("soft_arm").source)
    document["numerics"] = {"step": STEP, "tolerance": tolerance}
    return choose(parse_scene(yaml.safe_dump(document), "soft_arm.yaml")).scene


def seconds(inputs: Inputs) -> float:
    """Return the CPU time in s of a run."""
    high = np.array([actuator.limits[1] for actuator in inputs.simulation.scene.actuators])
    random = np.random.default_rng(1)
    inputs.reset()
    spent = 0.0
    for _ in range(round(SECONDS / (STEP * HOLD))):
        inputs.command(SHARE * high * random.uniform(-1.0, 1.0, len(high)))
        begin = time.process_time()
        for _ in range(HOLD // PERIOD):
            inputs.advance(PERIOD)
        spent += time.process_time() - begin
    return spent


def row_of(tolerance: float) -> dict[str, Any]:
    """Measure one tolerance."""
    scene = chosen(tolerance)
    alone = Inputs(Simulation(scene), 0.0, 0.0)
    watched = WatchedInputs(Simulation(scene), 0.0, 0.0)
    spent = [min(seconds(inputs) for _ in range(REPEATS)) for inputs in (alone, watched)]
    return {
        "tolerance": tolerance,
        "numerics": words(scene.numerics),
        "companion": words(watched.companion.scene.numerics),
        "alone_s": spent[0],
        "watched_s": spent[1],
        "ratio": spent[1] / spent[0],
        "estimate_rel": watched.error_rel,
    }


def main() -> int:
    """Measure, tell, and keep."""
    rows = []
    for tolerance in TOLERANCES:
        rows.append(row_of(tolerance))
        print(json.dumps(rows[-1]), flush=True)
    kept = {"simulated_s": SECONDS, "rows": rows, "machine": machine.facts()}
    FILE.write_text(json.dumps(kept, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
