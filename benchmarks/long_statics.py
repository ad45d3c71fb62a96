"""Cost of an equilibrium against the number of coordinates, and its exponent.

One slender rod, clamped, bent by its weight until its tip hangs down by most of its length; the
elements grow in number. CPU time of this run, best of several, stability judged; the exponent is
the slope of log cost against log coordinates. The tip is compared with that of the most elements.

    python -m benchmarks.long_statics
"""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import parse_scene

from . import machine
from .reference import RESULTS

FILE = RESULTS / "long_statics.json"
ELEMENTS = (11, 21, 42, 84, 168, 417)
LENGTH, RADIUS = 1.0, 0.01
REPEATS = 3


def rod(elements: int) -> Dynamics:
    """Return a soft rod of so many elements of 24 coordinates, under its weight."""
    section = {
        "name": "s", "length": LENGTH, "material": "m",
        "cross_section": {"shape": "circle", "radius": RADIUS},
    }  # fmt: skip
    document = {
        "name": "long", "bodies": [{"rod": "rod", "sections": [section]}],
        "materials": {"m": {"young_modulus": 3e6, "poisson_ratio": 0.4, "density": 1000.0}},
        "numerics": {"basis": {"order": 3, "elements": elements}},
    }  # fmt: skip
    return Dynamics(parse_scene(yaml.safe_dump(document)))


def main() -> None:
    """Measure and write the results."""
    rows: list[dict[str, Any]] = []
    for elements in ELEMENTS:
        dynamics = rod(elements)
        tip = dynamics.node_poses(equilibrium(dynamics))[-1][:3, 3]
        best = np.inf
        for _ in range(REPEATS):
            begin = time.process_time()
            equilibrium(dynamics)
            best = min(best, time.process_time() - begin)
        rows.append({"coordinates": dynamics.n, "cpu_ms": 1e3 * best, "tip_m": tip.tolist()})
        print(f"{dynamics.n:6d} coordinates  {1e3 * best:8.1f} ms", flush=True)
    for row in rows:
        off = np.linalg.norm(np.subtract(row["tip_m"], rows[-1]["tip_m"])) / LENGTH
        row["tip_off_lengths"] = float(off)
    large = rows[2:]
    sizes, costs = ([row[key] for row in large] for key in ("coordinates", "cpu_ms"))
    exponent = float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
    print(f"exponent from {large[0]['coordinates']} coordinates on: {exponent:.2f}")
    out = {"machine": machine.facts(), "exponent": exponent, "rods": rows}
    FILE.write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()
