"""Cost of a step against the number of elements, and the exponent fitted to it."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import Any

import numpy as np

from soft_sim_ros.core.simulation import Simulation

from . import machine
from .cases import CASES
from .programs import ours, peers
from .reference import RESULTS

FILE = RESULTS / "scaling.json"
CASE = replace(CASES["heavy_arm"], duration=0.1, outputs=1)
COUNTS = (10, 20, 50, 100, 200, 500, 1000)
STEP = 1e-3


def cost_of_step(order: int, elements: int, integrator: str) -> tuple[float, int, float]:
    """Return (best s per step on one core, coordinates, Newton iterations per step)."""
    kind: dict[str, Any] = {"kind": "constant"} if order == 0 else {"order": order}
    settings = kind | {"elements": elements, "step": STEP, "integrator": integrator}
    simulation = Simulation(ours.scene_of(CASE, settings))
    simulation.advance(3)
    steps = max(3, min(100, 20000 // elements))
    best = np.inf
    before = simulation.statistics()
    for _ in range(5):
        begin = time.process_time()
        simulation.advance(steps)
        best = min(best, (time.process_time() - begin) / steps)
    after = simulation.statistics()
    iterations = (after.iterations - before.iterations) / max(1, after.steps - before.steps)
    return best, simulation.n_coordinates, iterations


def exponent(rows: list[dict[str, Any]]) -> float:
    """Return the slope of log cost against log elements."""
    counts = np.log([row["elements"] for row in rows])
    return float(np.polyfit(counts, np.log([row["wall_s_per_step"] for row in rows]), 1)[0])


def main(programs: list[str]) -> None:
    """Measure, fit, write."""
    here = machine.facts()
    rows: list[dict[str, Any]] = []
    if "soft_sim_ros" in programs:
        for order in (0, 1):
            for count in COUNTS:
                cost, coordinates, iterations = cost_of_step(order, count, "sdirk2")
                rows.append({
                    "program": f"soft_sim_ros, order {order}", "elements": count,
                    "coordinates": coordinates, "wall_s_per_step": cost,
                    "newton_iterations_per_step": iterations, "step": STEP,
                })  # fmt: skip
                said = f"order {order}, {count} elements: {cost * 1e6:.0f} us"
                print(f"  scaling: {said} per step", flush=True)
    if "pyelastica" in programs:
        settings = [{"elements": count, "clamp": "plain"} for count in (10, 20, 50, 100, 200)]
        for result in peers.runs("pyelastica", CASE, settings):
            if result.get("steps") and result["wall_s"]:
                rows.append({
                    "program": "pyelastica", "elements": result["settings"]["elements"],
                    "coordinates": result["coordinates"], "step": result["step"],
                    "wall_s_per_step": result["wall_s"] / result["steps"],
                    "wall_s_per_simulated_s": result["wall_s"] / CASE.duration,
                })  # fmt: skip
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
