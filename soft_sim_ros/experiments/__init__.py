"""Recorded and measured motions: simulated again, and fitted by parameters of a scene."""

from soft_sim_ros.experiments.identification import identify
from soft_sim_ros.experiments.motions import Measured, Recorded, read_motion
from soft_sim_ros.experiments.resimulation import Comparison, rerun

__all__ = ["Comparison", "Measured", "Recorded", "identify", "read_motion", "rerun"]
