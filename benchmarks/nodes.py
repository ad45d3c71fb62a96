"""How many nodes the default arm needs: ``python -m benchmarks.nodes``.

Writes benchmarks/results/nodes.json. The arm with its own degrees and 4 to 12 nodes per section,
under the torques of ``benchmarks.realtime`` at their full limits, against the same arm with degrees
of five and 16 nodes, both by ``sdirk3`` at 1 ms: the largest distance of the tips over the run and
the length. What the degrees leave out is in it, and does not depend on nodes: where the distance
stops falling, more nodes are of no use.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.settled import Simulation

from . import machine
from .realtime import INPUTS, STEP, Input, arm, arm_numerics, program, whole

FILE = Path(__file__).parent / "results" / "nodes.json"
COUNTS = (4, 5, 6, 7, 12)
FINE = {"order": {"torsion": 3, "bend_y": 5, "bend_z": 5, "stretch": 3}, "nodes": 16}
SHARE, SECONDS = 1.0, 3.0


def with_basis(**basis: Any) -> Simulation:
    """Return the default arm with another basis."""
    basis = arm_numerics()["basis"] | basis
    return arm(integrator="sdirk3", step=STEP, basis=basis)


def tips(given: Input, simulation: Simulation) -> Floats:
    """Return the tips (k, 3) in m of a run."""
    return whole(simulation, program(given, simulation, SECONDS, SHARE), given.hold)[1]


def main() -> int:
    """Measure, tell, and keep."""
    rows = []
    for given in INPUTS:
        exact = tips(given, with_basis(**FINE))
        errors = {}
        for count in COUNTS:
            simulation = with_basis(nodes=count)
            away = np.linalg.norm(tips(given, simulation) - exact, axis=1)
            errors[count] = float(away.max() / simulation.length)
        rows.append({"input": given.name, "error_rel": errors})
        told = " | ".join(f"{error:.2e}" for error in errors.values())
        print(f"| {given.name} | {told} |", flush=True)
    kept = {"limits": SHARE, "simulated_s": SECONDS, "rows": rows, "machine": machine.facts()}
    FILE.write_text(json.dumps(kept, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
