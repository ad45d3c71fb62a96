"""Print what the default number of nodes costs: the table in docs/theory.md."""

import numpy as np
from scenes import ALL, rod

from soft_sim_ros.core.statics import equilibrium

STIFFNESS, LENGTH = 1e6 * np.pi * 0.03**4 / 4, 0.6


def tip(order: int, turns: float, nodes: int | None = None) -> np.ndarray:
    """Return the tip (3,) of a rod bent by a moment to some turns, with half as much torsion."""
    dynamics = rod(strains=ALL[:4], order=order, nodes=nodes)
    moment = 2 * np.pi * turns * STIFFNESS / LENGTH
    wrench = np.array([0.33 * moment, 0.0, moment, 0.0, 1.0, 0.5])
    q = equilibrium(dynamics, tip=wrench, tip_follows=True)
    return dynamics.node_poses(q)[-1][:3, 3]


def main() -> None:
    """Print the table."""
    print("| order | nodes | 180° | 360° |")
    print("|---|---|---|---|")
    for order in (1, 2, 3, 5, 7):
        errors = [
            np.linalg.norm(tip(order, turns) - tip(order, turns, 100)) / LENGTH
            for turns in (0.5, 1.0)
        ]
        print(f"| {order} | {order + 5} | {errors[0]:.1e} | {errors[1]:.1e} |")


if __name__ == "__main__":
    main()
