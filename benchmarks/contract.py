"""The accuracy contract put to the test: every case at several tolerances, against the references.

    python -m benchmarks.contract [case …]

Fails unless the true error is within the tolerance in 95 % of the runs and the estimate within a
factor of ten of it in 95 %. Writes benchmarks/results/contract.json.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from soft_sim_ros.core.contract import choose
from soft_sim_ros.core.refinement import words
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.errors import ToleranceMissed
from soft_sim_ros.scene import Scene

from . import machine, reference
from .cases import CASES, Case
from .programs import ours, settings

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
WITHIN, SHARE = 10.0, 0.95
RESULT = reference.RESULTS / "contract.json"


def scene_of(case: Case, tolerance: float) -> Scene:
    """Return a case as a scene that asks for a tolerance."""
    step = settings.dividing(case, case.output_period)
    return ours.scene_of(case, {"tolerance": tolerance, "step": step})


def entry_of(case: Case, tolerance: float) -> dict[str, Any]:
    """Choose, run, compare."""
    exact, agreement = reference.load(case)
    scene = scene_of(case, tolerance)
    drive = ours.drive_of(case, round(scene.numerics.step * 1e9))
    entry: dict[str, Any] = {"case": case.name, "tolerance": tolerance}
    begin = time.process_time()
    try:
        choice = choose(scene, drive)
    except ToleranceMissed as missed:
        return entry | {
            "outcome": "refused",
            "estimate_rel": missed.estimate,
            "choice": str(missed),
        }
    search = time.process_time() - begin
    simulation = Simulation(choice.scene)
    begin = time.process_time()
    tips = drive.tips(simulation)
    spent = time.process_time() - begin
    return entry | {
        "outcome": "completed",
        "error_rel": reference.distance(tips[1:], exact, case.length),
        "estimate_rel": choice.estimate,
        "reference_agreement": agreement,
        "coordinates": simulation.n_coordinates,
        "choice": words(choice.scene.numerics),
        "rounds": choice.rounds,
        "cpu_s": spent,
        "search_cpu_s": search,
    }


def main(names: Sequence[str]) -> int:
    """Measure some cases, all by default; print, write, judge."""
    names = list(names) or list(CASES)
    here = machine.facts()
    entries = []
    print(
        "case           tolerance  error    estimate  est./error  coordinates  run CPU  search CPU"
    )
    for name in names:
        for tolerance in TOLERANCES:
            entry = entry_of(CASES[name], tolerance)
            entries.append(entry | {"machine": here})
            if entry["outcome"] != "completed":
                print(f"{name:14} {tolerance:9.0e}  refused: {entry['choice']}", flush=True)
                continue
            ratio = entry["estimate_rel"] / entry["error_rel"]
            print(
                f"{name:14} {tolerance:9.0e}  {entry['error_rel']:.1e}  {entry['estimate_rel']:.1e}"
                f"   {ratio:8.2f}    {entry['coordinates']:8}  {entry['cpu_s']:8.3f} s"
                f" {entry['search_cpu_s']:8.2f} s",
                flush=True,
            )
    done = [entry for entry in entries if entry["outcome"] == "completed"]
    met = sum(entry["error_rel"] <= entry["tolerance"] for entry in done)
    ratios = np.array([entry["estimate_rel"] / entry["error_rel"] for entry in done])
    near = int(np.sum((ratios >= 1.0 / WITHIN) & (ratios <= WITHIN)))
    print(f"within the tolerance: {met} of {len(done)}; refused: {len(entries) - len(done)}")
    print(
        f"estimate within a factor of {WITHIN:g}: {near}; {ratios.min():.2f} to {ratios.max():.2f}"
    )
    if names == list(CASES):
        RESULT.write_text(json.dumps(entries, indent=1) + "\n")
    return 0 if min(met, near) >= SHARE * len(entries) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
