"""Print what the automatic number of nodes costs: the table in docs/theory.md."""

from dataclasses import replace

import numpy as np
from scenes import ALL, rod_document, scene_of

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.element import default_nodes
from soft_sim_ros.core.settled import Dynamics

STIFFNESS, LENGTH = 1e6 * np.pi * 0.03**4 / 4, 0.6


def tip(order: int, turns: float, nodes: int | None = None) -> np.ndarray:
    """Return the tip (3,) of a rod bent by a moment to some turns, with half as much torsion."""
    scene = scene_of(rod_document(strains=ALL[:4], order=order))
    rods = {name: replace(basis, nodes=nodes) for name, basis in scene.numerics.rods.items()}
    dynamics = Dynamics(replace(scene, numerics=replace(scene.numerics, rods=rods)))
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
            np.linalg.norm(tip(order, turns) - tip(order, turns, 300)) / LENGTH
            for turns in (0.5, 1.0)
        ]
        nodes = default_nodes({"any": order})
        print(f"| {order} | {nodes} | {errors[0]:.1e} | {errors[1]:.1e} |")


if __name__ == "__main__":
    main()
