"""What a loop costs beside a chain of as many elements: ``python -m benchmarks.loops``.

Writes benchmarks/results/loops.json. A rod under its weight, once with a free end and once with its
end welded to the world where it was, of 10 to 1000 elements. Both take turns in one process, so
whatever else the machine does hits both; medians of the CPU time per evaluation of the equations
(solving included) are kept, and the exponents fitted to them.
"""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import parse_scene

from . import machine
from .reference import RESULTS

FILE = RESULTS / "loops.json"
COUNTS = (10, 30, 100, 300, 1000)
ROUNDS = 9
ELEMENTS_PER_ROUND = 4000  # element-steps of one measurement
WELD = {"name": "far", "kind": "weld", "frames": [{"body": "rod"}]}


def simulation_of(elements: int, closed: bool) -> Simulation:
    """Return a rod of some elements, its end held or not, past its first steps."""
    section = {
        "name": "s", "length": 0.5, "material": "soft",
        "cross_section": {"shape": "circle", "radius": 0.01},
    }  # fmt: skip
    strains = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
    soft = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000.0, "viscosity": 1e3}
    document: dict[str, Any] = {
        "gravity": [0.0, 1.0, -9.81],
        "materials": {"soft": soft},
        "bodies": [{"rod": "rod", "strains": strains, "sections": [section]}],
        "constraints": [WELD] if closed else [],
        "numerics": {
            "step": 1e-3, "integrator": "sdirk2",
            "basis": {"kind": "constant", "elements": elements},
        },
    }  # fmt: skip
    simulation = Simulation(parse_scene(yaml.safe_dump(document), "loops.yaml"))
    simulation.advance(3)
    return simulation


def measure(counts: tuple[int, ...] = COUNTS, rounds: int = ROUNDS) -> list[dict[str, Any]]:
    """Return the costs of both at every size, in µs per evaluation: medians of the rounds."""
    rows = []
    for count in counts:
        both = {closed: simulation_of(count, closed) for closed in (False, True)}
        costs: dict[bool, list[float]] = {False: [], True: []}
        for _ in range(rounds):
            for closed, simulation in both.items():
                before = simulation.statistics().evaluations
                begin = time.process_time()
                simulation.advance(max(1, min(100, ELEMENTS_PER_ROUND // count)))
                spent = time.process_time() - begin
                costs[closed].append(spent / (simulation.statistics().evaluations - before))
        chain, loop = (1e6 * float(np.median(costs[closed])) for closed in (False, True))
        rows.append({"elements": count, "chain_us": chain, "loop_us": loop})
    return rows


def exponent(rows: list[dict[str, Any]], key: str) -> float:
    """Return the slope of log cost against log elements."""
    counts = np.log([row["elements"] for row in rows])
    return float(np.polyfit(counts, np.log([row[key] for row in rows]), 1)[0])


def main() -> None:
    """Measure, print, write."""
    rows = measure()
    for row in rows:
        ratio = row["loop_us"] / row["chain_us"]
        print(
            f"{row['elements']:5} elements: chain {row['chain_us']:8.1f} us per evaluation, "
            f"loop {row['loop_us']:8.1f} us, {ratio:.2f}x"
        )
    large = [row for row in rows if row["elements"] >= 100]
    fits = {
        key: {"all": exponent(rows, key), "from 100 elements": exponent(large, key)}
        for key in ("chain_us", "loop_us")
    }
    for key, fit in fits.items():
        print(f"{key[:5]}: n^{fit['all']:.2f}, from 100 elements n^{fit['from 100 elements']:.2f}")
    found = {"rows": rows, "exponents": fits, "machine": machine.facts()}
    FILE.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
