"""Draw the stability map: ``python -m benchmarks.stress``.

Writes benchmarks/results/stress.json, a list with an entry per scene, and stress.png.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from soft_sim_ros.batch.workers import cores, in_processes
from soft_sim_ros.commands.progress import Line, bar

from .. import machine
from .judge import judge
from .plots import draw
from .scenes import cases, real_cases

RESULTS = Path(__file__).resolve().parents[1] / "results"


def main() -> int:
    """Run, write, and fail if anything is wrong or a real arm is refused."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stress", description=__doc__)
    parser.add_argument("--scenes", type=int, default=2500, help="scenes all over the map")
    parser.add_argument("--real", type=int, default=500, help="more scenes, of real arms only")
    parser.add_argument("--checked", type=int, default=5, help="every so many compared with others")
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    drawn = cases(given.scenes) + real_cases(given.real)
    tasks = [(case, number % given.checked == 0) for number, case in enumerate(drawn)]
    judge(*tasks[0])  # compiles the kernels, once
    entries: list[dict[str, Any] | None] = [None] * len(tasks)
    line, begin = Line(), time.monotonic()
    for done, (number, answer) in enumerate(in_processes(judge, tasks, given.jobs), start=1):
        if isinstance(answer, Exception):
            raise answer
        entries[number] = answer
        line.show(f"{bar(done, len(tasks))} {done} of {len(tasks)} scenes")
    line.clear()
    judged = [entry for entry in entries if entry is not None]
    here = machine.facts()
    given.out.mkdir(parents=True, exist_ok=True)
    text = ",\n".join(json.dumps(entry) for entry in judged)
    (given.out / "stress.json").write_text(f"[\n{text}\n]\n")
    draw(judged, given.out / "stress.png")
    facts = here | {"wall_s": round(time.monotonic() - begin), "jobs": given.jobs}
    (given.out / "stress_machine.json").write_text(json.dumps(facts, indent=1) + "\n")
    return tell(judged, time.monotonic() - begin)


def tell(judged: list[dict[str, Any]], seconds: float) -> int:
    """Print the counts; return 1 if there is anything to mend."""
    outcomes = Counter(entry["outcome"] for entry in judged)
    print(f"{len(judged)} scenes in {seconds:.0f} s: {dict(outcomes)}")
    for why, number in Counter(e["why"] for e in judged if e["outcome"] == "refused").most_common():
        print(f"  {number:5} {why}")
    checked = [e for e in judged if e["error_rel"] is not None]
    print(f"{len(checked)} compared with refined runs")
    lost = [e for e in judged if e["real"] and e["outcome"] == "refused"]
    real = sum(entry["real"] for entry in judged)
    print(f"{real} scenes of real arms, {len(lost)} of them refused")
    wrong = [e for e in judged if e["outcome"] == "wrong"]
    for entry in wrong + lost:
        print(entry)
    return 1 if wrong or lost else 0


if __name__ == "__main__":
    sys.exit(main())
