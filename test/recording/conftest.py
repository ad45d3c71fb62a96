"""What the tests of the recording share: a moving arm that needs no solver, and a filled bag."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import soft_sim_ros
from soft_sim_ros.recording.telemetry import LEDGER, Telemetry
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter

PREFIX = "/left/soft_arm"
SCENE = "name: test arm\nlength: 0.6  # m\n"


class SwingingArm:
    """Stands in for a simulation: a circular arc whose curvature swings, everything closed form."""

    def __init__(self, actuators: int = 3, coordinates: int = 5) -> None:
        self.time_ns = 0
        self.actuator_names = tuple(f"section{i}/bend_y" for i in range(actuators))
        self.coordinate_names = tuple(f"arm/bend_y/{i}" for i in range(coordinates))
        self.sampled = 0
        self.advance(0)

    def advance(self, step_ns: int) -> None:
        self.time_ns += step_ns
        t = self.time_ns / 1e9
        order = np.arange(len(self.coordinate_names))
        self.q = np.sin(t + order)
        self.v = np.cos(t + order)

    def sampler(self, poses: int) -> SwingingArm:
        self.s = np.linspace(0.0, 0.6, poses)
        return self

    def poses(self) -> np.ndarray:
        self.sampled += 1
        curvature = 2.0 * self.q[0] + 1e-9
        angle = curvature * self.s
        poses = np.zeros((len(self.s), 7))
        poses[:, 0] = np.sin(angle) / curvature
        poses[:, 2] = (np.cos(angle) - 1.0) / curvature
        poses[:, 4] = np.sin(angle / 2)
        poses[:, 6] = np.cos(angle / 2)
        return poses

    def ports(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n = len(self.actuator_names)
        return self.q[:n] * 0.1, self.v[:n] * 0.1, np.arange(n) * 1e-3

    def ledger(self) -> np.ndarray:
        kinetic, elastic = 0.5 * self.v @ self.v, 0.5 * self.q @ self.q
        values = [kinetic, elastic, 0.0, kinetic + elastic, 0.0, 0.0, 1e-12]
        return np.array(values[: len(LEDGER)])


@pytest.fixture
def arm() -> SwingingArm:
    """Give a fresh swinging arm."""
    return SwingingArm()


@pytest.fixture
def record(tmp_path: Path) -> Callable[..., tuple[Path, list[tuple[int, str, bytes]]]]:
    """Give a function that records a swing and returns the directory and all that was written."""

    def run(
        name: str = "swing", steps: int = 200, prefix: str = PREFIX, **options: object
    ) -> tuple[Path, list[tuple[int, str, bytes]]]:
        arm = SwingingArm()
        telemetry = Telemetry(arm, 21, "world", prefix)
        topics = recorded_topics(prefix)
        names = {topic.key: topic.name for topic in topics}
        written = []
        directory = tmp_path / name
        with BagWriter(
            directory,
            topics,
            metadata={"scene": "test arm"},
            attachments={"scene.yaml": SCENE.encode()},
            **options,  # type: ignore[arg-type]
        ) as bag:
            for _ in range(steps):
                for topic in telemetry.topics:
                    data = getattr(telemetry, topic.key)()
                    assert bag.write(topic.key, arm.time_ns, data)
                    written.append((arm.time_ns, names[topic.key], data))
                arm.advance(10_000_000)
        return directory, written

    return run


@pytest.fixture
def child() -> Iterator[Callable[..., subprocess.Popen]]:
    """Give a function that starts Python code in another process; all are ended afterwards."""
    root = str(Path(soft_sim_ros.__file__).parents[1])
    started: list[subprocess.Popen] = []

    def start(code: str, *arguments: object) -> subprocess.Popen:
        paths = [root, os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        process = subprocess.Popen(
            [sys.executable, "-c", code, *map(str, arguments)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()
