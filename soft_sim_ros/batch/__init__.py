"""Many runs: sweeps of parameters, processes and machines, and tables of what came out."""

from soft_sim_ros.batch.batch import run_batch
from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.batch.run import Run
from soft_sim_ros.batch.sweep import read_sweep

__all__ = ["Rollout", "Run", "read_sweep", "run_batch"]
