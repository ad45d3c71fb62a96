"""Compile every kernel that the packaged scenes need; later starts find them on disk."""

from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.scene import load_scene, packaged_scenes

for name in packaged_scenes():
    warm_up(load_scene(name))
