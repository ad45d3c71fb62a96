"""Cost of inverse, forward and mixed dynamics against the number of bodies, and its exponent.

Chains of equal units: hinge, soft rod, motor, hinge, floating-frame link. CPU time of this run,
best of several; the exponent is the slope of log cost against log units.

    python -m benchmarks.chains
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.mechanics.prescribed import prescribed_motion
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import parse_scene

from . import machine
from .reference import RESULTS

FILE = RESULTS / "chains.json"
UNITS = (4, 8, 16, 32, 64, 128, 256)
REPEATS = 7


def chain(units: int) -> Dynamics:
    """Return the dynamics of a chain of so many units of five bodies."""
    section = {
        "name": "s", "length": 0.1, "material": "m",
        "cross_section": {"shape": "circle", "radius": 0.01},
    }  # fmt: skip
    bodies: list[dict[str, Any]] = []
    for i in range(units):
        bodies += [
            {"joint": f"a{i}", "kind": "revolute", "axis": [0, 0, 1]},
            {"rod": f"r{i}", "strains": ["bend_y", "bend_z"], "sections": [section]},
            {"rigid_body": f"m{i}", "mass": 0.1, "inertia": [1e-4, 1e-4, 1e-4]},
            {"joint": f"b{i}", "kind": "revolute", "axis": [0, 1, 0]},
            {"flexible_link": f"l{i}", "strains": ["bend_y", "bend_z"], "sections": [section],
             "modes": 2},
        ]  # fmt: skip
    document = {
        "name": "chain", "bodies": bodies, "numerics": {"basis": {"order": 1}},
        "materials": {"m": {"young_modulus": 1e8, "poisson_ratio": 0.4, "density": 1100.0}},
    }  # fmt: skip
    return Dynamics(parse_scene(yaml.safe_dump(document)))


def cost(call: Callable[[], object]) -> float:
    """Return the best CPU time of a call in s."""
    call()
    best = np.inf
    for _ in range(REPEATS):
        begin = time.process_time()
        for _ in range(3):
            call()
        best = min(best, (time.process_time() - begin) / 3)
    return float(best)


def main() -> None:
    """Measure, fit, write and print."""
    rows = []
    for units in UNITS:
        dynamics = chain(units)
        q, v, a = np.random.default_rng(1).normal(size=(3, dynamics.n)) * 0.01
        driven = np.array(["/" not in name for name in dynamics.compiled.coordinate_names])
        rows.append({
            "bodies": 5 * units, "coordinates": dynamics.n,
            "inverse_s": cost(lambda d=dynamics, q=q, v=v, a=a: d.inverse_dynamics(q, v, a)),
            "forward_s": cost(lambda d=dynamics, q=q, v=v: d.forward_dynamics(q, v)),
            "driven_hinges_s": cost(
                lambda d=dynamics, q=q, v=v, a=a, w=driven: prescribed_motion(d, q, v, a, w)
            ),
        })  # fmt: skip
    exponents = {}
    for name in ("inverse_s", "forward_s", "driven_hinges_s"):
        large = [row for row in rows if row["bodies"] >= 80]  # below, calls cost more than sums
        counts, costs = (np.log([row[key] for row in large]) for key in ("bodies", name))
        exponents[name] = round(float(np.polyfit(counts, costs, 1)[0]), 3)
    FILE.write_text(
        json.dumps({"machine": machine.facts(), "rows": rows, "exponents": exponents}, indent=1)
        + "\n",
        encoding="utf-8",
    )
    for row in rows:
        print({key: value for key, value in row.items()})
    print("exponents from 80 bodies on:", exponents)


if __name__ == "__main__":
    main()
