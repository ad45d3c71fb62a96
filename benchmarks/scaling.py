"""Cost of a step against the number of elements, and the exponent fitted to it.

    python -m benchmarks.scaling

Sizes take turns, so that whatever else the machine does hits all of them; the median of the CPU
time of many rounds counts. What grows besides the arithmetic is kept next to it: evaluations and
Newton iterations per step, and the bytes of a simulation, which leave one cache after the other.
"""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import Any

import numpy as np

from soft_sim_ros.core.settled import Simulation

from . import machine
from .cases import CASES
from .programs import ours, peers
from .reference import RESULTS

FILE = RESULTS / "scaling.json"
CASE = replace(CASES["heavy_arm"], duration=0.1, outputs=1)
COUNTS = (10, 20, 50, 100, 200, 500, 1000)
ORDERS = (0, 1)
STEP = 1e-3
ROUNDS = 9
ELEMENTS_PER_ROUND = 4000  # element-steps of one measurement


def simulation_of(order: int, elements: int) -> Simulation:
    """Return the heavy arm on some elements, past its first steps."""
    kind: dict[str, Any] = {"kind": "constant"} if order == 0 else {"order": order}
    settings = kind | {"elements": elements, "step": STEP, "integrator": "sdirk2"}
    simulation = Simulation(ours.scene_of(CASE, settings))
    simulation.advance(3)
    return simulation


def measure() -> list[dict[str, Any]]:
    """Return the cost of a step of every size, in CPU s: median of the rounds."""
    sizes = [(order, count) for order in ORDERS for count in COUNTS]
    simulations = {size: simulation_of(*size) for size in sizes}
    spent: dict[tuple[int, int], list[float]] = {size: [] for size in sizes}
    before = {size: simulations[size].statistics() for size in sizes}
    for _ in range(ROUNDS):
        for (order, count), simulation in simulations.items():
            steps = max(1, min(100, ELEMENTS_PER_ROUND // count))
            begin = time.process_time()
            simulation.advance(steps)
            spent[order, count].append((time.process_time() - begin) / steps)
    rows = []
    for (order, count), simulation in simulations.items():
        after, start = simulation.statistics(), before[order, count]
        cost = float(np.median(spent[order, count]))
        rows.append({
            "program": f"soft_sim_ros, order {order}", "elements": count,
            "coordinates": simulation.n_coordinates, "wall_s_per_step": cost,
            "ns_per_element": cost / count * 1e9,
            "spread": float(np.ptp(np.quantile(spent[order, count], (0.25, 0.75))) / cost),
            "newton_iterations_per_step":
                (after.iterations - start.iterations) / (after.steps - start.steps),
            "evaluations_per_step":
                (after.evaluations - start.evaluations) / (after.steps - start.steps),
            "bytes": simulation.nbytes, "step": STEP,
        })  # fmt: skip
        said = f"order {order}, {count} elements: {cost * 1e6:.0f} us"
        print(f"  scaling: {said} per step", flush=True)
    return rows


def exponent(rows: list[dict[str, Any]]) -> float:
    """Return the slope of log cost against log elements."""
    counts = np.log([row["elements"] for row in rows])
    return float(np.polyfit(counts, np.log([row["wall_s_per_step"] for row in rows]), 1)[0])


def main(programs: list[str]) -> None:
    """Measure, fit, write."""
    here = machine.facts()
    rows = measure() if "soft_sim_ros" in programs else []

    def tell(result: dict[str, Any]) -> None:
        if result.get("steps") and result["wall_s"]:
            rows.append({
                "program": "pyelastica", "elements": result["settings"]["elements"],
                "coordinates": result["coordinates"], "step": result["step"],
                "wall_s_per_step": result["wall_s"] / result["steps"],
                "wall_s_per_simulated_s": result["wall_s"] / CASE.duration,
            })  # fmt: skip

    if "pyelastica" in programs:
        settings = [{"elements": count, "clamp": "plain"} for count in (10, 20, 50, 100, 200)]
        peers.runs("pyelastica", CASE, settings, tell)
    names = dict.fromkeys(row["program"] for row in rows)
    fits = {}
    for name in names:
        mine = [row for row in rows if row["program"] == name]
        fits[name] = {"all": exponent(mine)}
        large = [row for row in mine if row["elements"] >= 50]
        if len(large) > 1:
            fits[name]["from 50 elements"] = exponent(large)
    for name, fit in fits.items():
        print(f"  scaling: {name}: cost per step grows like n^{fit['all']:.2f}", flush=True)
    FILE.write_text(json.dumps({"rows": rows, "exponents": fits, "machine": here}, indent=1) + "\n")


if __name__ == "__main__":
    main(["soft_sim_ros", "pyelastica"])
