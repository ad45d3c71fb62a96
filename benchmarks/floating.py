"""What a floating-frame link costs and misses, beside the rod of the same data, in one run.

The two scenes flexible_manipulator and floating_frame under the same torques, both with bending
only, and links with a single mode. Ratios of the same run; nothing here is an absolute time.

    python -m benchmarks.floating
"""

from __future__ import annotations

import time

import numpy as np
import yaml

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene, parse_scene

STEPS = 500
EFFORTS = (1.0, -0.4)  # N·m


def bending_only() -> str:
    """Return flexible_manipulator with two bending strains, as the links have."""
    document = yaml.safe_load(load_scene("flexible_manipulator").source)
    for body in document["bodies"]:
        if "rod" in body:
            body["strains"] = ["bend_y", "bend_z"]
    document["numerics"]["basis"]["order"] = {"bend_y": 3, "bend_z": 3}
    return yaml.safe_dump(document)


def links_of(modes: dict[str, int]) -> str:
    """Return floating_frame with other modes."""
    document = yaml.safe_load(load_scene("floating_frame").source)
    for body in document["bodies"]:
        if "flexible_link" in body:
            body["strains"], body["modes"] = list(modes), modes
    return yaml.safe_dump(document)


def main() -> None:
    """Measure and print."""
    scenes = {
        "rods": load_scene("flexible_manipulator"),
        "rods, bending only": parse_scene(bending_only()),
        "links": load_scene("floating_frame"),
        "links, bending only": parse_scene(links_of({"bend_y": 1, "bend_z": 2})),
        "links of one mode": parse_scene(links_of({"bend_z": 1})),
    }
    best = dict.fromkeys(scenes, np.inf)
    tips = {}
    for _ in range(5):
        for name, scene in scenes.items():
            simulation = Simulation(scene)
            simulation.set_efforts(np.array(EFFORTS))
            simulation.advance(3)
            begin = time.process_time()
            simulation.advance(STEPS)
            best[name] = min(best[name], time.process_time() - begin)
            tips[name] = simulation.dynamics.node_poses(simulation.q)[-1][:3, 3]
    for name, scene in scenes.items():
        simulation = Simulation(scene)
        size = (
            f"{simulation.n_coordinates:3d} coordinates, {len(simulation.model.half):3d} segments"
        )
        apart = np.linalg.norm(tips[name] - tips["rods"]) * 1e3
        print(
            f"{name:20s} {size}, cost {best[name] / best['rods']:.2f} of the "
            f"rods', tip {apart:.2f} mm from theirs after {STEPS} steps"
        )


if __name__ == "__main__":
    main()
