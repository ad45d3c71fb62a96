"""Energy of undamped free motion over a million steps, with the conservative method and without.

``python -m benchmarks.energy`` writes benchmarks/results/energy.json.
"""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import Any

from soft_sim_ros.core.settled import Simulation

from . import machine
from .cases import CASES
from .programs import ours
from .reference import RESULTS

FILE = RESULTS / "energy.json"
# A rod clamped and let go under its weight: large motions, in a plane, that never come to rest.
CASE = replace(
    CASES["heavy_arm"],
    name="undamped",
    viscosity=0.0,
    radius=0.02,
    sections=(0.6,),
    strains=("bend_y", "bend_z", "torsion", "stretch"),
    gravity=(0.0, -9.81, 3.0),
)
SETTINGS = {"order": 2, "step": 2e-3}
LOOKS = 200


def drift(integrator: str, steps: int) -> dict[str, Any]:
    """Follow the motion; return the largest deviation of its energy, over the energy exchanged.

    The energy exchanged is the largest kinetic energy: that of position has no zero of its own.
    """
    simulation = Simulation(ours.scene_of(CASE, SETTINGS | {"integrator": integrator}))
    worst = largest = 0.0
    final = 0.0
    begin = time.process_time()
    for _ in range(LOOKS):
        simulation.advance(steps // LOOKS)
        ledger = simulation.ledger()
        largest, final = max(largest, ledger[0]), ledger[-1]
        worst = max(worst, abs(final))
    return {
        "integrator": integrator,
        "steps": steps,
        "step": SETTINGS["step"],
        "coordinates": simulation.n_coordinates,
        "relative_drift_worst": worst / largest,
        "relative_drift_final": abs(final) / largest,
        "kinetic_energy_largest_j": largest,
        "cpu_s": time.process_time() - begin,
    }


def main() -> None:
    """Measure and write."""
    rows = []
    for integrator, steps in (("energy_midpoint", 10**6), ("implicit_midpoint", 10**5)):
        rows.append(drift(integrator, steps))
        row = rows[-1]
        print(
            f"{integrator}: {steps} steps, energy off by {row['relative_drift_worst']:.1e} at most "
            f"({row['cpu_s']:.0f} s)",
            flush=True,
        )
    FILE.write_text(json.dumps({"rows": rows, "machine": machine.facts()}, indent=1) + "\n")


if __name__ == "__main__":
    main()
