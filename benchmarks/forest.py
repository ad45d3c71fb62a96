"""Cost of branches: a comb against a chain of the same rods, two arms in one scene against two.

CPU time of one evaluation (residual, tangent, factors and solution), best of several; what is
compared takes turns, so that whatever else the machine does hits both.

    python -m benchmarks.forest
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.recursion.elimination import factor, solve
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import parse_scene

from . import machine
from .reference import RESULTS

FILE = RESULTS / "forest.json"
RODS = (16, 64, 256)
ROUNDS = 40
ALPHA = (1.0, 1e3, 1e6)  # shares of stiffness, damping and mass in the tangent of a step of 1 ms
Body = dict[str, Any]


def rod(name: str, parent: Any = None) -> Body:
    """Return a rod of 0.1 m."""
    section = {
        "name": "s", "length": 0.1, "material": "m",
        "cross_section": {"shape": "circle", "radius": 0.01},
    }  # fmt: skip
    strains = ["torsion", "bend_y", "bend_z", "stretch"]
    out: Body = {"rod": name, "strains": strains, "sections": [section]}
    return out if parent is None else out | {"parent": parent}


def dynamics_of(bodies: list[Body]) -> Dynamics:
    """Return the dynamics of some bodies."""
    document = {
        "name": "forest", "bodies": bodies, "numerics": {"basis": {"order": 2}},
        "materials": {"m": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1100.0}},
    }  # fmt: skip
    return Dynamics(parse_scene(yaml.safe_dump(document)))


def chain(rods: int, name: str = "r", parent: Any = None) -> list[Body]:
    """Return rods one after the other."""
    return [rod(f"{name}0", parent), *(rod(f"{name}{i}", f"{name}{i - 1}") for i in range(1, rods))]


def comb(rods: int) -> list[Body]:
    """Return half of the rods one after the other, with a tooth on the end of each."""
    teeth = [
        rod(f"t{i}", {"body": f"r{i}", "offset": {"rpy": [0.0, 0.0, 1.2]}})
        for i in range(rods // 2)
    ]
    return [*chain(rods // 2), *teeth]


def hand(rods: int) -> list[Body]:
    """Return rods that all leave one rigid body."""
    fingers = [
        rod(f"f{i}", {"body": "palm", "offset": {"position": [0.0, 0.01 * i, 0.0]}})
        for i in range(rods)
    ]
    return [{"rigid_body": "palm", "mass": 1.0}, *fingers]


def evaluation(dynamics: Dynamics) -> Callable[[], None]:
    """Return one evaluation at some state, compiled and warm."""
    rng = np.random.default_rng(2)
    q, v, a = rng.normal(size=(3, dynamics.n)) * 0.02 / dynamics.model.weight
    out = np.zeros(dynamics.n)
    data = dynamics.forcing()
    model, system = dynamics.model, dynamics._system

    def evaluate() -> None:
        inverse_dynamics(model, data, q, v, a, out)
        tangent(model, data, ALPHA, system)
        factor(model, system)
        solve(model, system, out)

    evaluate()
    return evaluate


def costs(*several: list[Dynamics], rounds: int = ROUNDS) -> list[float]:
    """Return the CPU times in s of one evaluation of each of several lists of scenes."""
    calls = [[evaluation(dynamics) for dynamics in own] for own in several]
    often = max(1, 3000 // sum(dynamics.n for own in several for dynamics in own))
    best = [np.inf] * len(several)
    for _ in range(rounds):
        for i, own in enumerate(calls):
            begin = time.process_time()
            for _ in range(often):
                for call in own:
                    call()
            best[i] = min(best[i], (time.process_time() - begin) / often)
    return best


def branches_cost(rods: int, shape: Callable[[int], list[Body]], rounds: int = ROUNDS) -> float:
    """Return what a forest costs over what a chain of as many equal rods costs."""
    forest, row = costs([dynamics_of(shape(rods))], [dynamics_of(chain(rods))], rounds=rounds)
    return forest / row


def two_arms_cost(rods: int, rounds: int = ROUNDS) -> float:
    """Return what two arms in one scene cost over what two arms in two scenes cost."""
    left, right = chain(rods, "left"), chain(rods, "right", "base")
    apart = [dynamics_of(left), dynamics_of(right)]
    both, each = costs([dynamics_of([*left, *right])], apart, rounds=rounds)
    return both / each


def main() -> None:
    """Measure, write and print."""
    rows = []
    for rods in RODS:
        rows.append({
            "rods": rods,
            "comb_over_chain": round(branches_cost(rods, comb), 3),
            "hand_over_chain": round(branches_cost(rods, hand), 3),
            "two_arms_over_two_scenes": round(two_arms_cost(rods // 2), 3),
        })  # fmt: skip
        print(rows[-1], flush=True)
    content = json.dumps({"machine": machine.facts(), "rows": rows}, indent=1) + "\n"
    FILE.write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
