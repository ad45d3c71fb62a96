"""Error against the number of coordinates, for every kind of basis.

    python -m benchmarks.convergence

Polynomials over the whole rod converge spectrally: every further order divides the error by the
same number. Bases on more and more elements converge algebraically: with a power of their number.
Time is resolved far below, by ``adaptive``, and so are the integrals along the rod.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from . import machine
from .cases import CASES, Case
from .programs.ours import run
from .programs.settings import plane_of
from .reference import RESULTS, distance, load

FILE = RESULTS / "convergence.json"
# Highest orders. Beyond order 5 monomials are conditioned so badly that rounding, not the motion,
# sets the steps: the same error costs 15 times as much.
POLYNOMIALS = {"legendre": 8, "chebyshev": 8, "monomial": 5}
NAMES = ("heavy_arm", "tendon_step")
PIECEWISE = {"constant": (1, 2, 4, 8, 16, 32), "linear": (1, 2, 4, 8, 16, 32)}
FIXED = {"legendre, order 1": 1, "legendre, order 2": 2}
ERROR = 1e-9


def settings_of(case: Case) -> list[tuple[str, dict[str, Any]]]:
    """Return (name, settings) of every run: polynomials of rising order, then rising elements."""
    common = {"step": case.output_period, "integrator": "adaptive", "options": {"error": ERROR}}
    common |= plane_of(case)
    out: list[tuple[str, dict[str, Any]]] = []
    for kind, highest in POLYNOMIALS.items():
        for order in range(highest + 1):
            basis = {"kind": kind, "order": order, "elements": 1, "nodes": 3 * order + 12}
            out.append((kind, common | basis))
    for kind, counts in PIECEWISE.items():
        nodes = {1: 16, 2: 12, 4: 8}
        out += [
            (kind, common | {"kind": kind, "elements": n, "nodes": nodes.get(n, 6)}) for n in counts
        ]
    for name, order in FIXED.items():
        out += [
            (name, common | {"order": order, "elements": n, "nodes": {1: 16, 2: 12}.get(n, 8)})
            for n in (1, 2, 4, 8, 16)
        ]
    return out


def rate(rows: list[dict[str, Any]], floor: float) -> dict[str, float]:
    """Return the rate fitted to the runs whose error is above what is resolved.

    Polynomials: the factor by which one more coordinate per strain divides the error; others: the
    power of the number of elements with which the error falls, over its last half.
    """
    seen = [row for row in rows if row["error_rel"] > 10 * floor]
    errors = np.log([row["error_rel"] for row in seen])
    if rows[0]["basis"] in POLYNOMIALS:
        slope = np.polyfit([row["order"] for row in seen], errors, 1)[0]
        return {"error divided per order by": float(np.exp(-slope))}
    last = slice(len(seen) // 2 - 1, None)
    slope = np.polyfit(np.log([row["elements"] for row in seen])[last], errors[last], 1)[0]
    return {"power of the number of elements": float(-slope)}


def main() -> None:
    """Run, fit, write."""
    rows: list[dict[str, Any]] = []
    rates: dict[str, dict[str, Any]] = {}
    for name in NAMES:
        case = CASES[name]
        exact, agreement = load(case)
        for basis, chosen in settings_of(case):
            done = run(case, chosen, repeats=1)
            rows.append({
                "case": name, "basis": basis, "order": chosen.get("order", 0),
                "elements": chosen["elements"], "coordinates": done.coordinates,
                "error_rel": distance(done.tip, exact, case.length), "cpu_s": done.cpu,
            })  # fmt: skip
        for basis in dict.fromkeys(row["basis"] for row in rows):
            mine = [row for row in rows if (row["case"], row["basis"]) == (name, basis)]
            rates.setdefault(name, {})[basis] = fit = rate(mine, max(agreement, ERROR))
            ((what, value),) = fit.items()
            print(f"  convergence: {name}, {basis}: {what} {value:.2g}", flush=True)
    kept = {"rows": rows, "rates": rates, "machine": machine.facts()}
    FILE.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
