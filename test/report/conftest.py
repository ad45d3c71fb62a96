"""A recording whose every number is known: a straight arm that turns once about the vertical."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from soft_sim_ros.recording import cdr
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter

LENGTH, TURN = 0.5, 4.0  # m, s
STEPS = 400
SCENE = "name: turning <arm> & more\n"
NAMES = "kinetic,elastic,gravity,actuator_work,load_work,dissipated,residual"


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    """Record the turning arm, with a summary beside it."""
    directory = tmp_path / "turning"
    poses = cdr.PoseArrayBuffer("world", 6)
    tip = cdr.PoseStampedBuffer("world")
    joints = cdr.JointStateBuffer(["yaw", "pitch"])
    strains = cdr.JointStateBuffer(["yaw"], effort=False)
    energy = cdr.Float64MultiArrayBuffer(7, NAMES)
    s = np.linspace(0, LENGTH, 6)
    with BagWriter(
        directory,
        recorded_topics("/soft_arm"),
        metadata={"node": "/soft_arm"},
        attachments={"scene.yaml": SCENE.encode()},
    ) as bag:
        bag.write("command", 0, cdr.encode_floats([0.25, 0.0]))
        bag.write("events", 1_000_000_000, cdr.encode_string("reset"))
        for index in range(STEPS + 1):
            time_ns = index * 10_000_000
            angle = 2 * np.pi * index / STEPS
            values = np.zeros((6, 7))
            values[:, 0], values[:, 1] = s * np.cos(angle), s * np.sin(angle)
            values[:, 5], values[:, 6] = np.sin(angle / 2), np.cos(angle / 2)
            speed = 2 * np.pi / TURN
            bag.write("backbone", time_ns, poses.fill(time_ns, values))
            bag.write("tip_pose", time_ns, tip.fill(time_ns, values[-1]))
            state = joints.fill(time_ns, [angle, 0], [speed, 0], [0.25, -0.75])
            bag.write("joint_states", time_ns, state)
            bag.write("strain_state", time_ns, strains.fill(time_ns, [angle], [speed]))
            ledger = [0.2, 0, -0.5, 0.7, 0, 0, 0.002 * index / STEPS]
            bag.write("energy", time_ns, energy.fill(ledger))
    summary = {
        "real_time_factor": 0.998,
        "overruns": 3,
        "ended_by": "SIGINT",
        "recording": {"dropped": 0},
        "step_cost": {
            "p50_us": 310.0,
            "p99_us": 520.0,
            "worst_us": 1210.5,
            "histogram": [
                {"from_us": 0.0, "to_us": 300.0, "steps": 60},
                {"from_us": 300.0, "to_us": 600.0, "steps": 39},
                {"from_us": 600.0, "to_us": None, "steps": 1},
            ],
        },
    }
    (directory / "summary.json").write_text(json.dumps(summary))
    return directory
