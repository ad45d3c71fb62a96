"""How far a step is from what the machine can do: ``python -m benchmarks.limit``.

For chains of 10 to 1000 elements: time, floating-point operations and bytes of the residual, the
tangent, its factors, a solution and a whole step, against peaks measured in the same run; the
exponent of the growth; and which part of the residual takes how long.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from soft_sim_ros.core.integrators import advance, dirk, newton
from soft_sim_ros.core.integrators import problem as slots
from soft_sim_ros.core.recursion import rnea, tangent
from soft_sim_ros.core.settled import Simulation

from . import machine, peak
from .counting import Counted
from .kernel_runs import PARTS, known_count, units
from .programs import ours
from .reference import RESULTS
from .scaling import CASE, STEP

FILE = RESULTS / "limit.json"
COUNTS = (10, 30, 100, 300, 1000)
ORDERS = (0, 1)
ROUNDS = 15
ELEMENTS = 3000  # evaluated in one measurement
UNITS = ("residual", "tangent", "factor", "solve")
# What a unit reads and writes, of Model, Data, System and Work.
TOUCHED = {
    "residual": (
        "half kappa xi0 entry_ptr entry_col entry_comp entry_phi inertia law_ptr law_col stiffness "
        "damping xi omega relative series step dual eta acc wrench q v a residual"
    ),
    "solve": "column square motion carry gain inverse residual",
}


def chain(order: int, elements: int, gravity: bool = True) -> Simulation:
    """Return the arm of benchmarks/scaling.py, a few steps into its motion."""
    kind: dict[str, Any] = {"kind": "constant"} if order == 0 else {"order": order}
    settings = kind | {"elements": elements, "step": STEP, "integrator": "sdirk2"}
    case = CASE if gravity else replace(CASE, gravity=(0.0, 0.0, 0.0))
    simulation = Simulation(ours.scene_of(case, settings))
    simulation.advance(5)
    return simulation


def least(run: Callable[[int], object], count: int, rounds: int = ROUNDS) -> float:
    """Return the least CPU time in s of one of ``count`` runs in a row."""
    run(1)
    times = []
    for _ in range(rounds):
        begin = time.thread_time()
        run(count)
        times.append(time.thread_time() - begin)
    return min(times) / count


class Counters:
    """Counting copies of compiled kernels, made once for each."""

    def __init__(self) -> None:
        self._made: dict[int, Counted] = {}

    def of(self, function: Any, where: int) -> Counted:
        """Return the copy of the overload of ``function`` that lies at an address."""
        if where not in self._made:
            for overload in function.overloads.values():
                name = overload.fndesc.llvm_func_name
                if overload.library.get_pointer_to_function(name) == where:
                    self._made[where] = Counted(overload)
        return self._made[where]


def steps_cost(simulation: Simulation, elements: int) -> dict[str, float]:
    """Return the median and least CPU time per step in s, and evaluations per step."""
    steps = max(3, ELEMENTS // (3 * elements))
    before, times = simulation.statistics(), []
    for _ in range(ROUNDS):
        begin = time.thread_time()
        simulation.advance(steps)
        times.append((time.thread_time() - begin) / steps)
    after = simulation.statistics()
    done = after.steps - before.steps
    return {
        "median_s": float(np.median(times)),
        "least_s": float(min(times)),
        "evaluations": (after.evaluations - before.evaluations) / done,
        "factorisations": (after.factorisations - before.factorisations) / done,
    }


def counted_steps(simulation: Simulation, counters: Counters, steps: int = 10) -> dict[str, Any]:
    """Return what a step executes, all kernels together, and how many evaluations it takes."""
    calls, entry = simulation._problem.calls, simulation._entry
    original, first = calls.copy(), entry._advance
    kinds = (rnea.inverse_dynamics, tangent.tangent, newton.solve_stage)
    copies = [counters.of(kind, int(at)) for kind, at in zip(kinds, original, strict=False)]
    copies += [
        counters.of(dirk.dirk_step, int(original[slots.STEP])),
        counters.of(advance.advance, first),
    ]
    places = slots.RESIDUAL, slots.TANGENT, slots.STAGE, slots.STEP
    for place, copy in zip(places, copies, strict=False):
        calls[place] = copy.address
    entry._advance = copies[4].address
    for copy in copies:
        copy.reset()
    before = simulation.statistics()
    simulation.advance(steps)
    after = simulation.statistics()
    calls[:], entry._advance = original, first
    names = ("residual", "tangent", "stage", "method", "advance")
    return {
        "flops": {
            name: copy.counts()["flops"] / steps for name, copy in zip(names, copies, strict=True)
        },
        "evaluations": (after.evaluations - before.evaluations) / steps,
        "factorisations": (after.factorisations - before.factorisations) / steps,
    }


def working_set(simulation: Simulation, unit: str) -> int:
    """Return the bytes of all arrays that a unit touches."""
    problem = simulation._problem
    names = TOUCHED[unit].split()
    total = 0
    for part in (problem.model, problem.data, problem.work, problem.work.system):
        for name in names:
            total += getattr(getattr(part, name, None), "nbytes", 0)
    return total


def parts(simulation: Simulation, elements: int) -> dict[str, float]:
    """Return ns per element of the parts of the residual, each run by itself."""
    problem = simulation._problem
    work = problem.work
    given = (problem.model, problem.data, work.q, work.v, work.a, work.residual.copy())
    count = max(2, ELEMENTS // elements)
    return {
        name: least(lambda times, part=part: part(times, *given), count) / elements * 1e9
        for name, part in PARTS.items()
    }


def measured(order: int, elements: int, counters: Counters) -> dict[str, Any]:
    """Return all numbers of one chain, per element."""
    simulation = chain(order, elements)
    row: dict[str, Any] = {
        "order": order,
        "elements": elements,
        "coordinates": simulation.n_coordinates,
        "segments": len(simulation.model.half),
        "working_set_bytes": {unit: working_set(simulation, unit) / elements for unit in TOUCHED},
    }
    row["step"] = steps_cost(simulation, elements)
    row["step"]["counted"] = counted_steps(simulation, counters)
    count = max(2, ELEMENTS // elements)
    for name, (function, where, run) in units(simulation).items():
        spent = least(lambda times, run=run, where=where: run(where, times), count)
        copy = counters.of(function, where)
        copy.reset()
        run(copy.address, 1)
        counts = copy.counts()
        row[name] = {
            "ns": spent / elements * 1e9,
            "flops": counts["flops"] / elements,
            "gflops": counts["flops"] / spent * 1e-9,
            "bytes": (counts["load_bytes"] + counts["store_bytes"]) / elements,
            "vector_share": counts["vector"] / counts["flops"],
            "divisions": (counts["fdiv"] + counts["sqrt"]) / elements,
            "libm": counts["libm"] / elements,
            "branches": counts["branches"] / elements,
            "instructions": counts["instructions"] / elements,
        }
    row["parts_ns"] = parts(simulation, elements)
    row["step"] |= kept_factors(row)
    return row


def kept_factors(row: dict[str, Any]) -> dict[str, float]:
    """Return time and flops per element of a step for which no factors were made: the median."""
    counted, elements = row["step"]["counted"], row["elements"]
    newton = row["residual"]["flops"] + row["solve"]["flops"]
    rest = sum(counted["flops"].values()) / elements - counted["evaluations"] * newton
    rest -= counted["factorisations"] * (row["tangent"]["flops"] + row["factor"]["flops"])
    flops = row["step"]["evaluations"] * newton + rest
    spent = row["step"]["median_s"] / elements * 1e9
    return {
        "ns": spent,
        "flops": flops,
        "gflops": flops / spent,
        "flops_but_residual_and_solve": rest,
    }


def slope(rows: list[dict[str, Any]], cost: Callable[[dict[str, Any]], float]) -> float:
    """Return the slope of log cost against log elements."""
    counts = np.log([row["elements"] for row in rows])
    return float(np.polyfit(counts, np.log([cost(row) for row in rows]), 1)[0])


def exponents(rows: list[dict[str, Any]]) -> dict[str, float]:
    """Return the exponents of a step as it comes, and of its flops, and of one Newton iteration."""

    def iteration(row: dict[str, Any]) -> float:
        return float((row["residual"]["ns"] + row["solve"]["ns"]) * row["elements"])

    large = [row for row in rows if row["elements"] >= 100]
    return {
        "step": slope(rows, lambda row: row["step"]["median_s"]),
        "step from 100 elements": slope(
            large if len(large) > 1 else rows,
            lambda row: row["step"]["median_s"],
        ),
        "step over evaluations": slope(
            rows, lambda row: row["step"]["median_s"] / row["step"]["evaluations"]
        ),
        "flops of a step": slope(rows, lambda row: row["step"]["flops"] * row["elements"]),
        "residual and solution": slope(rows, iteration),
        "tangent and factors": slope(
            rows, lambda row: (row["tangent"]["ns"] + row["factor"]["ns"]) * row["elements"]
        ),
    }


def show(result: dict[str, Any]) -> None:
    """Print the table of docs/benchmarks.md."""
    scalar, vector = result["peak_gflops"]["scalar"], result["peak_gflops"]["vector"]
    print(
        f"peak: {scalar:.1f} Gflop/s scalar, {vector:.1f} in vectors; reading {result['reading']}"
    )
    print(
        "| order, elements | what | ns | flops | Gflop/s | of scalar, vector peak | bytes | GB/s |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for row in result["rows"]:
        for name in (*UNITS, "step"):
            unit, rate = row[name], row[name]["gflops"]
            share = f"{rate / scalar:.0%}, {rate / vector:.0%}"
            moved = unit.get("bytes")
            traffic = f"{moved:.0f} | {moved / unit['ns']:.0f}" if moved else "|"
            print(
                f"| {row['order']}, {row['elements']} | {name} | {unit['ns']:.0f} | "
                f"{unit['flops']:.0f} | {rate:.2f} | {share} | {traffic} |"
            )
        inside = ", ".join(f"{name} {ns:.0f}" for name, ns in row["parts_ns"].items())
        step = row["step"]
        print(
            f"  parts: {inside}; working set {row['working_set_bytes']}; evaluations and "
            f"factorisations per step {step['evaluations']:.2f}, {step['factorisations']:.2f}; "
            f"flops but residual and solve {step['flops_but_residual_and_solve']:.0f}"
        )
    for order, fits in result["exponents"].items():
        inside = ", ".join(f"{name} n^{fit:.2f}" for name, fit in fits.items())
        print(f"order {order}: {inside}")
    print(f"at rest, nothing acts: {result['idle']}")


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--counts", type=int, nargs="+", default=list(COUNTS))
    parser.add_argument("--no-write", action="store_true", help="print only")
    options = parser.parse_args()
    counters = Counters()
    rows = []
    for order in ORDERS:
        for elements in options.counts:
            rows.append(measured(order, elements, counters))
            print(f"  order {order}, {elements} elements", flush=True)
    caches = peak.caches()
    result = {
        "known_count": known_count(),
        "peak_gflops": {
            "scalar": max(peak.arithmetic(1), peak.arithmetic(1, True)),
            "vector": max(peak.arithmetic(w, fused) for w in (2, 4) for fused in (False, True)),
        },
        "caches": caches,
        "reading": {name: f"{peak.reading(size // 2):.0f} GB/s" for name, size in caches.items()},
        "rows": rows,
        "exponents": {
            str(order): exponents([row for row in rows if row["order"] == order])
            for order in ORDERS
        },
        "idle": {str(order): steps_cost(chain(order, 100, gravity=False), 100) for order in ORDERS},
        "machine": machine.facts(),
    }
    show(result)
    if not options.no_write:
        FILE.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
