"""What all tests share: a quiet corner of DDS, and processes that are gone when a test is over."""

from __future__ import annotations

import faulthandler
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

# as the program itself has it, and before numpy is imported
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
GRACE = 30.0  # s that a process gets to end in order

# One profile for all: the same examples every time, and no verdict about how long one took.
# `pytest --hypothesis-profile=search` looks for new ones.
UNTIMED = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("suite", derandomize=True, **UNTIMED)
settings.register_profile("search", max_examples=1000, **UNTIMED)
settings.load_profile("suite")


def domain() -> int:
    """Return a domain of DDS for this process: each worker of a run has one of its own."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if not worker:
        return random.randint(1, 60)
    return int(os.environ["ROS_DOMAIN_ID"]) + 1 + int(worker.removeprefix("gw"))


# Tests must neither hear nor disturb anybody else, on this machine or beyond.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(domain())
# A shell that runs the tests in the background has them ignore Ctrl-C, ``nohup`` a closed terminal,
# and they would hand that on.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


# Where compiled code never comes back, no thread of Python (pytest-timeout has one) ends the test.
STUCK = 60.0  # s after the limit of a test at which its process ends itself, and says where it was
_STDERR = pytest.StashKey[int]()


def pytest_configure(config: pytest.Config) -> None:
    """Keep the way to the terminal, which is captured while a test runs."""
    config.stash[_STDERR] = os.dup(2)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """End the process in which a test is stuck; pytest-xdist then goes on in another one."""
    marker = item.get_closest_marker("timeout")
    limit = float(marker.args[0] if marker else item.config.getini("timeout"))
    faulthandler.dump_traceback_later(limit + STUCK, exit=True, file=item.config.stash[_STDERR])
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


# Programs that talk over DDS, and measure how fast: never two of them at a time.
TALKING = ("test/node/", "test/package/test_readme.py")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that take long, so that no worker is left with one at the end."""
    dear = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: (_chain(item.nodeid) != TALKING[0], item.path not in dear))


def _chain(node: str) -> str:
    """Return what has to stay in one worker: a file, which shares what it has simulated."""
    file = node.partition("::")[0]
    return TALKING[0] if file.startswith(TALKING) else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Hand out whole files, in the order of collection."""
    from xdist.scheduler import LoadScopeScheduling

    class ByChain(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return _chain(nodeid)

        def remove_node(self, node: Any) -> str | None:
            crashed = super().remove_node(node)
            if crashed is not None:  # once is enough: the next worker goes on behind it
                self.workqueue[_chain(crashed)][crashed] = True
            return crashed

    config.option.loadscopereorder = False
    return ByChain(config, log)


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
