"""The accuracy contract put to the test: every case at several tolerances, against the references.

    python -m benchmarks.contract [case …]

The cases of the benchmark, compared where they publish, and the kinds that deceive a companion
(kinds.py), compared at every step. Fails unless in every run the true error is within the
tolerance and no larger than the estimate, or the run is refused; where a refusal says that an
answer holds up to some time, a run that is so long has to keep the tolerance. Writes
benchmarks/results/contract.json; a part of the cases replaces only its own entries.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from soft_sim_ros.core.accuracy.contract import choose
from soft_sim_ros.core.accuracy.drive import Drive
from soft_sim_ros.core.refine.refinement import words
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import ToleranceMissed
from soft_sim_ros.scene import Scene

from . import machine, reference
from .cases import CASES, Case
from .kinds import KINDS, Kind
from .programs import ours, settings

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
WITHIN, SHARE = 10.0, 0.95
RESULT = reference.RESULTS / "contract.json"


def scene_of(case: Case, tolerance: float) -> Scene:
    """Return a case as a scene that asks for a tolerance."""
    step = settings.dividing(case, case.output_period)
    return ours.scene_of(case, {"tolerance": tolerance, "step": step})


def entry_of(case: Case, tolerance: float) -> dict[str, Any]:
    """Choose, run, compare with the reference of a case."""
    exact, agreement = reference.load(case)
    scene = scene_of(case, tolerance)
    drive = ours.drive_of(case, round(scene.numerics.step * 1e9))
    entry: dict[str, Any] = {"case": case.name, "kind": "benchmark", "tolerance": tolerance}

    def error(simulation: Simulation) -> float:
        return reference.distance(drive.tip(simulation)[1:], exact, case.length)

    return entry | {"reference_agreement": agreement} | _outcome(scene, drive, error)


def hard_entry_of(kind: Kind, tolerance: float) -> dict[str, Any]:
    """Choose, run, compare at every step with a run that is much finer, or a closed form."""
    scene, drive = kind.scene(tolerance), kind.drive()
    every = replace(drive, every=1)
    entry: dict[str, Any] = {"case": kind.name, "kind": kind.kind, "tolerance": tolerance}

    def error(simulation: Simulation) -> float:
        away = np.linalg.norm(every.tip(simulation) - _reference(kind)[0], axis=1)
        return float(away.max() / simulation.length)

    entry |= _outcome(scene, drive, error)
    if entry["outcome"] == "completed":
        return entry | {"reference_agreement": _reference(kind)[1]}
    return entry | _until(kind, tolerance, entry["holds_s"])


def _until(kind: Kind, tolerance: float, holds: float) -> dict[str, Any]:
    """Ask for the part of a run that is said to hold, and compare that."""
    steps = int(0.98 * holds / kind.step)
    if steps == 0:
        return {}
    entry = hard_entry_of(replace(kind, duration=kind.step * steps), tolerance)
    keys = ("outcome", "error_rel", "estimate_rel", "reference_agreement")
    return {f"until_{key}": entry[key] for key in keys if key in entry}


@cache
def _reference(kind: Kind) -> tuple[np.ndarray, float]:
    return kind.reference()


def _outcome(scene: Scene, drive: Drive, error: Callable[[Simulation], float]) -> dict[str, Any]:
    """Search, run, and tell how it ended."""
    begin = time.process_time()
    try:
        choice = choose(scene, drive)
    except ToleranceMissed as missed:
        return {
            "outcome": "refused",
            "error_class": type(missed).__name__,
            "estimate_rel": missed.estimate,
            "holds_s": missed.holds,
            "choice": str(missed),
            "search_cpu_s": time.process_time() - begin,
        }
    search = time.process_time() - begin
    simulation = Simulation(choice.scene)
    begin = time.process_time()
    drive.tip(simulation)
    spent = time.process_time() - begin
    return {
        "outcome": "completed",
        "error_rel": error(Simulation(choice.scene)),
        "estimate_rel": choice.estimate,
        "contraction": choice.contraction,
        "coordinates": simulation.n_coordinates,
        "choice": words(choice.scene.numerics),
        "rounds": choice.rounds,
        "cpu_s": spent,
        "search_cpu_s": search,
    }


def honest(entry: dict[str, Any]) -> bool:
    """Whether a run is within its tolerance and its estimate, or refused, as far as it says."""
    prefix = "" if entry["outcome"] == "completed" else "until_"
    error = entry.get(f"{prefix}error_rel")
    if error is None:
        return True
    known = entry[f"{prefix}reference_agreement"]
    within = error <= entry["tolerance"] + known
    return bool(within and error <= entry[f"{prefix}estimate_rel"] + known)


def main(names: Sequence[str]) -> int:
    """Measure some cases, all by default; print, write, judge."""
    names = list(names) or [*CASES, *KINDS]
    here = machine.facts()
    entries = []
    print(
        "case            tolerance  error    estimate  est./error  coordinates  run CPU  search CPU"
    )
    for name in names:
        for tolerance in TOLERANCES if name in CASES else KINDS[name].tolerances:
            if name in CASES:
                entry = entry_of(CASES[name], tolerance)
            else:
                entry = hard_entry_of(KINDS[name], tolerance)
            entries.append(entry | {"machine": here})
            print(_row(entry), flush=True)
    done = [entry for entry in entries if entry["outcome"] == "completed"]
    ratios = np.array([entry["estimate_rel"] / entry["error_rel"] for entry in done])
    bad = [entry for entry in entries if not honest(entry)]
    near = int(np.sum((ratios >= 1.0) & (ratios <= WITHIN)))
    print(f"completed: {len(done)}; refused: {len(entries) - len(done)}; not honest: {len(bad)}")
    if done:
        print(f"estimate over error: {ratios.min():.2f} to {ratios.max():.2f}")
        print(f"in 1 to {WITHIN:g}: {near} of {len(done)}")
    _keep(entries)
    return 1 if bad or near < SHARE * len(done) else 0


def _keep(entries: list[dict[str, Any]]) -> None:
    """Write entries in place of those of the same cases."""
    order, new = [*CASES, *KINDS], {entry["case"] for entry in entries}
    kept = json.loads(RESULT.read_text()) if RESULT.is_file() else []
    entries = entries + [entry for entry in kept if entry["case"] not in new]
    entries.sort(key=lambda entry: (order.index(entry["case"]), -entry["tolerance"]))
    RESULT.write_text(json.dumps(entries, indent=1) + "\n")


def _row(entry: dict[str, Any]) -> str:
    """Return an entry in words."""
    head = f"{entry['case']:15} {entry['tolerance']:9.0e}  "
    if entry["outcome"] != "completed":
        until = entry.get("until_error_rel")
        told = "" if until is None else f"; error until then {until:.1e}"
        return f"{head}refused ({entry['search_cpu_s']:.1f} s): {entry['choice']}{told}"
    ratio = entry["estimate_rel"] / entry["error_rel"]
    return (
        f"{head}{entry['error_rel']:.1e}  {entry['estimate_rel']:.1e}"
        f"   {ratio:8.2f}    {entry['coordinates']:8}  {entry['cpu_s']:8.3f} s"
        f" {entry['search_cpu_s']:8.2f} s"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
