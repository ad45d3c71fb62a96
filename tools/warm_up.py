"""Compile every kernel that the packaged scenes need, showing progress; later starts find them."""

from soft_sim_ros.commands.progress import compiling
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import load_scene, packaged_scenes

with compiling():
    for name in packaged_scenes():
        simulation = Simulation(load_scene(name))
        simulation.advance(1)
        telemetry = Telemetry(simulation, 2, "world", "/warm_up")
        for topic in telemetry.topics:
            getattr(telemetry, topic.key)()
