"""Compile every kernel that the packaged scenes need; later starts find them on disk.

Scenes may be named instead. With ``--tests`` those of every integrator too: workers that share the
tests would otherwise compile the same ones side by side.
"""

import sys

from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.scene import INTEGRATORS, Scene, load_scene, packaged_scenes, parse_scene
from soft_sim_ros.scene.put import edited


def with_integrator(name: str, integrator: str) -> Scene:
    """Return a packaged scene with another integrator."""
    scene = load_scene(name)
    return parse_scene(
        edited(scene.source, scene.file, {"numerics.integrator": integrator}), scene.file
    )


if __name__ == "__main__":
    named = [word for word in sys.argv[1:] if word != "--tests"]
    for name in named or packaged_scenes():
        warm_up(load_scene(name))
    if "--tests" in sys.argv[1:]:
        for integrator in INTEGRATORS:
            warm_up(with_integrator("cantilever", integrator))
