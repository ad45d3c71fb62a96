"""Run the benchmark: ``python -m benchmarks [--cases …] [--programs …]``.

Writes benchmarks/results/work_precision.json, convergence.json, scaling.json, costs.json, plots and
the tables. A part of the cases or programs replaces only its own entries.
"""

from __future__ import annotations

import argparse
import json
import threading
import time
from typing import Any

import numpy as np

from soft_sim_ros import __version__

from . import convergence, machine, plots, reference, scaling, schedule, table
from .cases import CASES, Case
from .programs import ours, peers, settings

PROGRAMS = (schedule.OURS, *peers.PEERS)
FILE = reference.RESULTS / "work_precision.json"


class Book:
    """The entries of one program on one case."""

    def __init__(self, program: str, case: Case) -> None:
        self.program, self.case = program, case
        self.exact, self.agreement = reference.load(case)
        if any(is_coarse(chosen) for chosen in settings.ours(case)):
            reference.coarse_tip(case)  # now, because later a child may be timing itself
        self.version = __version__ if program == schedule.OURS else peers.version(program)
        self.entries: list[dict[str, Any]] = []

    def enter(self, result: dict[str, Any]) -> None:
        """Make the entry of one run: its tip becomes an error."""
        case, tip = self.case, np.array(result.pop("tip", []))
        whole = len(tip) == len(self.exact)
        error = reference.distance(tip, self.exact, case.length) if whole else None
        entry = {
            "case": case.name, "program": self.program, "version": self.version,
            "settings": result.pop("settings", {}), "coordinates": result.pop("coordinates", None),
            "wall_s": result.pop("wall_s", None), "error_rel": error,
            "estimate_rel": result.pop("estimate_rel", None), "outcome": result.pop("outcome"),
            "reference_agreement": self.agreement,
        }  # fmt: skip
        if whole and is_coarse(entry["settings"]):
            coarse = reference.coarse_tip(case)
            entry["error_own_model_rel"] = reference.distance(tip, coarse, case.length)
        self.entries.append(entry | {k: value for k, value in result.items() if value is not None})
        said = f"{error:.1e}" if error is not None else result.get("reason", "")
        wall = f"{entry['wall_s']:8.3f} s" if entry["wall_s"] is not None else "         –"
        print(f"  {case.name:13} {self.program:12} {entry['outcome']:11} {wall}  {said:10} "
              f"{entry['settings']}", flush=True)  # fmt: skip


def fill(book: Book) -> float:
    """Run one program on one case with all its settings; return CPU s."""
    program, case = book.program, book.case
    if program == schedule.OURS:
        begin = time.thread_time()
        for chosen in settings.ours(case):
            run = ours.run(case, chosen)
            result = {
                "settings": chosen, "tip": run.tip, "wall_s": run.wall, "cpu_s": run.cpu,
                "outcome": run.outcome, "coordinates": run.coordinates, "counters": run.counters,
                "estimate_rel": run.estimate, "search_cpu_s": run.search,
                "reason": run.reason or None,
            }  # fmt: skip
            book.enter(result)
        return time.thread_time() - begin
    why = peers.unsupported(program, case)
    if why:
        book.enter({"outcome": "unsupported", "reason": why})
        return 0.0
    note = {"physics": peers.differences(program, case) or None}
    chosen = getattr(settings, program)(case)
    return peers.runs(program, case, chosen, lambda result: book.enter(result | note))


def is_coarse(chosen: dict[str, Any]) -> bool:
    """Whether a run used the published model of one constant strain per section."""
    return chosen.get("kind") == "constant" or "pcs" in chosen.get("model", "")


def main() -> None:
    """Parse, run, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--cases", nargs="*", choices=list(CASES), default=list(CASES))
    parser.add_argument("--programs", nargs="*", choices=PROGRAMS, default=list(PROGRAMS))
    parser.add_argument("--only-cases", action="store_true", help="no convergence, no scaling")
    parser.add_argument("--cores", type=int, nargs="*", default=schedule.cores())
    given = parser.parse_args()
    reference.RESULTS.mkdir(exist_ok=True)
    here = machine.facts()
    begin, lock = time.monotonic(), threading.Lock()
    peers.prepare(given.programs)

    def run(job: schedule.Job) -> float:
        book = Book(job.program, CASES[job.case])
        cpu = fill(book)
        with lock:
            kept = json.loads(FILE.read_text()) if FILE.is_file() else []
            kept = [e for e in kept if (e["case"], e["program"]) != (job.case, job.program)]
            kept += [entry | {"machine": here} for entry in book.entries]
            FILE.write_text(json.dumps(in_order(kept), indent=1) + "\n")
        return cpu

    jobs = [schedule.Job(program, case) for program in given.programs for case in given.cases]
    schedule.work(jobs, run, given.cores)
    if not given.only_cases:
        convergence.main()
        scaling.main(given.programs)
    plots.main()
    table.main()
    print(f"done in {(time.monotonic() - begin) / 60:.1f} min: {reference.RESULTS}")


def in_order(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return entries by case and program, so that files of two runs can be compared."""
    cases = list(CASES)
    return sorted(entries, key=lambda e: (cases.index(e["case"]), PROGRAMS.index(e["program"])))


if __name__ == "__main__":
    main()
