"""What each constraint of a classical rod model saves: cost of a step, as a ratio to Cosserat's.

    python -m benchmarks.models

One hanging rod, pulled aside and let go, with the same basis, nodes and step for every model.
Models take turns, so that whatever else the machine does hits all of them; only the ratios mean
anything.
"""

from __future__ import annotations

import time

import numpy as np
import yaml

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.rod_model import MODELS

ROUNDS, STEPS = 15, 100
# Without damping, so that strings and beams have the same terms; stiff enough to stay resolved.
MATERIAL = {"young_modulus": 1e7, "poisson_ratio": 0.4, "density": 1000.0}


def simulation_of(model: str) -> Simulation:
    """Return the rod as one of the models."""
    section = {
        "name": "all", "length": 1.0, "material": "m",
        "cross_section": {"shape": "circle", "radius": 0.01},
    }  # fmt: skip
    document = {
        "base": {"rpy": [0.0, float(np.pi / 2), 0.0]},
        "materials": {"m": MATERIAL},
        "bodies": [{"rod": "rod", "model": model, "sections": [section]}],
        "initial": {"strains": {"rod/all": {"bend_y": 0.4, "bend_z": 0.3}}},
        "numerics": {"step": 1e-3, "basis": {"order": 3, "elements": 4, "nodes": 8}},
    }
    return Simulation(parse_scene(yaml.safe_dump(document), model))


def main() -> None:
    """Measure and print."""
    simulations = {model: simulation_of(model) for model in MODELS}
    best = dict.fromkeys(MODELS, np.inf)
    per_evaluation = dict.fromkeys(MODELS, np.inf)
    for simulation in simulations.values():
        simulation.advance(5)
    for _ in range(ROUNDS):
        for model, simulation in simulations.items():
            before = simulation.statistics().evaluations
            begin = time.process_time()
            simulation.advance(STEPS)
            cost = time.process_time() - begin
            best[model] = min(best[model], cost / STEPS)
            made = simulation.statistics().evaluations - before
            per_evaluation[model] = min(per_evaluation[model], cost / made)
    print("model            active  coordinates  step  evaluation   (Cosserat = 1)")
    for model, simulation in simulations.items():
        active = len(simulation.scene.bodies[0].strains)
        print(
            f"{model:16} {active:6} {simulation.n_coordinates:12}"
            f" {best[model] / best['cosserat']:5.2f}"
            f" {per_evaluation[model] / per_evaluation['cosserat']:11.2f}"
        )


if __name__ == "__main__":
    main()
