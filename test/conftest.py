"""What all tests share: a quiet corner of DDS, and processes that are gone when a test is over."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
GRACE = 30.0  # s that a process gets to end in order

# Tests must neither hear nor disturb anybody else, on this machine or beyond.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(random.randint(1, 100))
# A shell that runs the tests in the background has them ignore Ctrl-C, and they would hand that on.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def environment() -> dict[str, str]:
    """Environment of child processes: they find this tree, installed or not, wherever they run."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path, "PYTHONUNBUFFERED": "1"}


@pytest.fixture
def start(environment: dict[str, str]) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start processes; those that still run at the end of the test are ended by their own pid."""
    started: list[subprocess.Popen[str]] = []

    def start_one(*command: str, **options: object) -> subprocess.Popen[str]:
        settings = {"env": environment, "text": True, "stdout": subprocess.PIPE}
        settings |= {"stderr": subprocess.STDOUT, "start_new_session": True} | options
        started.append(subprocess.Popen(command, **settings))
        return started[-1]

    yield start_one
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.communicate(timeout=GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()


@pytest.fixture
def cli(environment: dict[str, str]) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run ``soft_sim_ros VERB …`` in a process of its own and give what came of it."""

    def run(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "soft_sim_ros", *map(str, arguments)]
        settings = {"env": environment, "text": True, "capture_output": True} | options
        return subprocess.run(command, **settings)

    return run
