"""Run the benchmark: ``python -m benchmarks [--cases …] [--programs …]``.

Writes benchmarks/results/work_precision.json, scaling.json, plots and a table. A part of the cases
or programs replaces only its own entries.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from typing import Any

import numpy as np

from soft_sim_ros import __version__

from . import machine, plots, reference, scaling, table
from .cases import CASES, Case
from .programs import ours, peers, settings

PROGRAMS = ("soft_sim_ros", "pyelastica", "soromox")
FILE = reference.RESULTS / "work_precision.json"


def entries_of(program: str, case: Case) -> list[dict[str, Any]]:
    """Run one program on one case; return its entries."""
    exact, agreement = reference.load(case)
    out = []

    def book(version: str, result: dict[str, Any]) -> None:
        tip = np.array(result.pop("tip", []))
        error = reference.distance(tip, exact, case.length) if len(tip) == len(exact) else None
        entry = {
            "case": case.name, "program": program, "version": version,
            "settings": result.pop("settings", {}), "coordinates": result.pop("coordinates", None),
            "wall_s": result.pop("wall_s", None), "error_rel": error, "estimate_rel": None,
            "outcome": result.pop("outcome"), "reference_agreement": agreement,
        }  # fmt: skip
        if len(tip) == len(exact) and is_coarse(entry["settings"]):
            coarse = reference.coarse_tip(case)
            entry["error_own_model_rel"] = reference.distance(tip, coarse, case.length)
        out.append(entry | {key: value for key, value in result.items() if value is not None})
        said = f"{error:.1e}" if error is not None else result.get("reason", "")
        wall = f"{entry['wall_s']:8.3f} s" if entry["wall_s"] is not None else "         –"
        print(f"  {program:12} {entry['outcome']:11} {wall}  {said:10} {entry['settings']}",
              flush=True)  # fmt: skip

    if program == "soft_sim_ros":
        for chosen in settings.ours(case):
            run = ours.run(case, chosen)
            result = {
                "settings": chosen, "tip": run.tip, "wall_s": run.wall, "cpu_s": run.cpu,
                "outcome": run.outcome, "coordinates": run.coordinates, "counters": run.counters,
            }  # fmt: skip
            book(__version__, result | ({"reason": run.reason} if run.reason else {}))
        return out
    version, why = peers.version(program), peers.unsupported(program, case)
    if why:
        book(version, {"outcome": "unsupported", "reason": why})
        return out
    chosen = getattr(settings, program)(case)
    note = peers.differences(program, case)
    for result in peers.runs(program, case, chosen):
        book(version, result | ({"physics": note} if note else {}))
    return out


def is_coarse(chosen: dict[str, Any]) -> bool:
    """Whether a run used the published model of one constant strain per section."""
    return chosen.get("kind") == "constant" or "pcs" in chosen.get("model", "")


def main() -> None:
    """Parse, run, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--cases", nargs="*", choices=list(CASES), default=list(CASES))
    parser.add_argument("--programs", nargs="*", choices=PROGRAMS, default=list(PROGRAMS))
    parser.add_argument("--skip-scaling", action="store_true")
    parser.add_argument("--core", type=int, default=0, help="run everything on this core")
    given = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {given.core})  # children inherit it
    reference.RESULTS.mkdir(exist_ok=True)
    here = machine.facts()
    begin = time.monotonic()
    for number, name in enumerate(given.cases, start=1):
        case = CASES[name]
        spent = time.monotonic() - begin
        print(f"[{number}/{len(given.cases)}, {spent:.0f} s] {name}: {case.title}", flush=True)
        for program in given.programs:
            fresh = [entry | {"machine": here} for entry in entries_of(program, case)]
            kept = json.loads(FILE.read_text()) if FILE.is_file() else []
            kept = [e for e in kept if (e["case"], e["program"]) != (name, program)] + fresh
            FILE.write_text(json.dumps(kept, indent=1) + "\n")
    if not given.skip_scaling:
        scaling.main(given.programs)
    plots.main()
    table.main()
    print(f"done in {time.monotonic() - begin:.0f} s: {reference.RESULTS}")


if __name__ == "__main__":
    main()
