"""Scenes of several branches, and a short run of each, shared by all tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from branched import NAMES, file_of

from soft_sim_ros.batch.programme import Programme
from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import Scene, load_scene


@pytest.fixture(scope="session")
def scenes() -> dict[str, Scene]:
    """Give the scenes by name."""
    return {name: load_scene(file_of(name)) for name in NAMES}


@pytest.fixture(scope="session")
def moved(scenes: dict[str, Scene]) -> dict[str, Simulation]:
    """Give a simulation of each scene, a moment after its start."""
    found = {name: Simulation(scene) for name, scene in scenes.items()}
    for simulation in found.values():
        simulation.advance(40)
    return found


@pytest.fixture(scope="session")
def recorded(scenes: dict[str, Scene], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Give a recording of 0.1 s of each scene, with a command."""
    folder = tmp_path_factory.mktemp("forest")
    for name, scene in scenes.items():
        count = len(scene.actuators)
        programme = Programme(np.array([0.02]), np.full((1, count), 0.5)) if count else None
        Rollout(scene, folder / name, programme, space=False).run(0.1)
    return {name: folder / name for name in scenes}
