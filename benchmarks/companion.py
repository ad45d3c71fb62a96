"""What watching the tolerance costs a node: ``python -m benchmarks.companion``.

Writes benchmarks/results/companion.json. The default arm with a tolerance and nothing else written,
driven as the node drives it: six random torques every 100 ms, advanced from one control period of
4 ms to the next; alone, and with the companion that watches its error (docs/accuracy.md). The ratio
of the CPU times of the thread, the best of some runs, is what the companion costs.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

from soft_sim_ros.core.accuracy.contract import choose
from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.core.refine.refinement import words
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs

from . import machine
from .realtime import INPUTS, STEP, program, scene_with

FILE = Path(__file__).parent / "results" / "companion.json"
TOLERANCES = (1e-2, 1e-3, 1e-4)
PERIOD, SECONDS, REPEATS = 4, 2.0, 8
DRIVE = next(one for one in INPUTS if one.hold == 100)


def seconds(inputs: Inputs) -> float:
    """Return the CPU time in s of a run."""
    inputs.reset()
    spent = 0.0
    for torques in program(DRIVE, inputs.simulation, SECONDS):
        inputs.command(torques)
        begin = time.thread_time()
        for _ in range(DRIVE.hold // PERIOD):
            inputs.advance(PERIOD)
        spent += time.thread_time() - begin
    return spent


def row_of(tolerance: float) -> dict[str, Any]:
    """Measure one tolerance."""
    scene = choose(scene_with({"step": STEP, "tolerance": tolerance})).scene
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
