"""A peer for all tests of the node; test/conftest.py has chosen the corner of DDS before."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

# without ROS 2 there is no node to test; everything else is
if find_spec("rclpy") is None:
    collect_ignore_glob = ["test_*.py"]
else:
    import rclpy
    from peer import Peer, Program


def pytest_collection_modifyitems(items):
    """Leave time for kernels to be compiled: whichever test starts the first node pays for it."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.timeout(400))


@pytest.fixture(scope="session", autouse=True)
def _no_orphans():
    yield
    Program.kill_since(0)


@pytest.fixture(autouse=True)
def _no_leftovers():
    """Let no program that a failed test has started talk to the next test."""
    begin = Program.count()
    yield
    Program.kill_since(begin)


@pytest.fixture(scope="session")
def context():
    """An rclpy context for the session."""
    result = rclpy.Context()
    rclpy.init(context=result)
    yield result
    rclpy.shutdown(context=result)


@pytest.fixture(scope="session")
def _peer(context):
    result = Peer(context)
    yield result
    result.close()


@pytest.fixture
def peer(_peer):
    """A node in the test process; discovery takes seconds, so there is one for all tests."""
    yield _peer
    _peer.forget()
