"""Draw the stability map: ``python -m benchmarks.stress``.

Writes benchmarks/results/stress.json, a list with an entry per scene, and stress.png;
equilibria.json, the same for equilibria under dead moments and loads that follow; and touching.json
for bodies that fall on shapes and on one another.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from soft_sim_ros.batch.workers import cores, in_processes
from soft_sim_ros.commands.progress import Line, bar

from .. import machine
from .equilibria import judge_equilibrium, loads
from .judge import judge
from .plots import draw
from .scenes import cases, real_cases
from .touching import judge_touch, touches

ROUND_OFF = 1e-8  # of the energy turned over, in balances that are exact but for round-off
RESULTS = Path(__file__).resolve().parents[1] / "results"


def main() -> int:
    """Run, write, and fail if anything is wrong or a real arm is refused."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stress", description=__doc__)
    parser.add_argument("--scenes", type=int, default=2500, help="scenes all over the map")
    parser.add_argument("--real", type=int, default=500, help="more scenes, of real arms only")
    parser.add_argument("--checked", type=int, default=5, help="every so many compared with others")
    parser.add_argument(
        "--gradient", type=int, default=300, help="every so many, too, by the discrete gradient"
    )
    parser.add_argument("--equilibria", type=int, default=120, help="scenes at rest")
    parser.add_argument("--touching", type=int, default=500, help="scenes of contact")
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    drawn = cases(given.scenes) + real_cases(given.real)
    tasks = [
        (case, number % given.checked == 0, number % given.gradient == 0)
        for number, case in enumerate(drawn)
    ]
    judge(*tasks[0])  # compiles the kernels, once
    begin = time.monotonic()
    judged = _judged(judge, tasks, given.jobs, "scenes")
    at_rest = _judged(
        judge_equilibrium, [(load,) for load in loads(given.equilibria)], given.jobs, "equilibria"
    )
    judge_touch(touches(1)[0])
    touched = _judged(
        judge_touch, [(case,) for case in touches(given.touching)], given.jobs, "contacts"
    )
    here = machine.facts()
    given.out.mkdir(parents=True, exist_ok=True)
    for name, entries in (("stress", judged), ("equilibria", at_rest), ("touching", touched)):
        text = ",\n".join(json.dumps(entry) for entry in entries)
        (given.out / f"{name}.json").write_text(f"[\n{text}\n]\n")
    draw(judged, given.out / "stress.png")
    facts = here | {"wall_s": round(time.monotonic() - begin), "jobs": given.jobs}
    (given.out / "stress_machine.json").write_text(json.dumps(facts, indent=1) + "\n")
    told = tell(judged, time.monotonic() - begin), tell_equilibria(at_rest), tell_touches(touched)
    return max(told)


def _judged(
    judge: Callable[..., dict[str, Any]], tasks: list[tuple], jobs: int, what: str
) -> list[dict[str, Any]]:
    """Return what ``judge`` says of all tasks, in their order."""
    entries: list[dict[str, Any]] = [{}] * len(tasks)
    line = Line()
    for done, (number, answer) in enumerate(in_processes(judge, tasks, jobs), start=1):
        if isinstance(answer, Exception):
            raise answer
        entries[number] = answer
        line.show(f"{bar(done, len(tasks))} {done} of {len(tasks)} {what}")
    line.clear()
    return entries


def tell_equilibria(judged: list[dict[str, Any]]) -> int:
    """Print how verdicts of stability came out; return 1 if one is wrong."""
    print(f"{len(judged)} equilibria: {dict(Counter(e['outcome'] for e in judged))}")
    runs = Counter(e["run"] if isinstance(e["run"], str) else "run" for e in judged)
    print(f"  looked at by a pushed finer model: {dict(runs)}")
    wrong = [e for e in judged if e["wrong"] is not None]
    for entry in wrong:
        print(entry)
    return 1 if wrong else 0


def tell_touches(judged: list[dict[str, Any]]) -> int:
    """Print how scenes of contact came out; return 1 if one made energy."""
    print(f"{len(judged)} scenes of contact: {dict(Counter(e['outcome'] for e in judged))}")
    for why, number in Counter(e["why"] for e in judged if e["why"]).most_common():
        print(f"  {number:5} {why}")
    gained = max((e["gained_rel"] or 0.0 for e in judged), default=0.0)
    print(f"  energy made, over that turned over, at most {gained:.1e}")
    wrong = [e for e in judged if e["outcome"] == "wrong"]
    for entry in wrong:
        print(entry)
    return 1 if wrong else 0


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
    active = tell_passivity(judged)
    wrong = [e for e in judged if e["outcome"] == "wrong"]
    for entry in wrong + lost + active:
        print(entry)
    return 1 if wrong or lost or active else 0


def tell_passivity(judged: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Print how Property 1.1 came out; return the scenes that violate it.

    Damping pays for what a method makes of energy, and ``energy_midpoint`` and the discrete
    gradient make none: there nothing but round-off is allowed.
    """
    completed = [e for e in judged if e["outcome"] != "refused"]
    exact = [e for e in completed if e["damping"] > 0.0]
    free = [e for e in completed if e["damping"] == 0.0]
    closing = [e for e in free if e["integrator"] == "energy_midpoint"]
    others = [e for e in free if e["integrator"] != "energy_midpoint"]
    kinds = {"damped": exact, "undamped, energy_midpoint": closing, "undamped, others": others}
    print("passivity, (supplied - stored) / energy turned over, the least of all instants:")
    for name, rows in kinds.items():
        least = min((e["passivity_rel"] for e in rows), default=0.0)
        print(f"  {len(rows):5} completed, {name}: {least:.1e}")
    found = [e for e in judged if e["gradient_outcome"] is not None]
    ends = Counter(e["gradient_outcome"] for e in found)
    least = min((e["gradient_passivity_rel"] for e in found), default=0.0)
    worst = max((e["gradient_balance_rel"] for e in found), default=0.0)
    print(
        f"  {len(found):5} by the discrete gradient {dict(ends)}: {least:.1e}, balance {worst:.1e}"
    )
    return [e for e in exact + closing if e["passivity_rel"] < -ROUND_OFF] + [
        e for e in found if max(-e["gradient_passivity_rel"], e["gradient_balance_rel"]) > ROUND_OFF
    ]


if __name__ == "__main__":
    sys.exit(main())
