"""A second node of the same name, or a second owner of time, is noticed and said once."""

import time

import pytest
from geometry_msgs.msg import PoseArray
from peer import wait_for
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from soft_sim_ros.node.rivals import Rivals


@pytest.fixture
def nodes(context):
    made = []

    def make(name):
        made.append(Node(name, context=context))
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


def test_a_second_publisher_is_told_once_and_again_when_it_comes_back(nodes):
    name = f"arm_{time.monotonic_ns()}"
    node, told = nodes(name), []
    topic = node.create_publisher(PoseArray, "~/backbone", 1).topic_name
    rivals = Rivals(node, topic, clock=False, warn=told.append)
    wait_for(lambda: node.count_publishers(topic), "its own publisher")
    assert rivals.look() is None
    other = nodes(name)
    for times in (1, 2):
        publisher = other.create_publisher(PoseArray, "~/backbone", 1)
        assert topic in wait_for(rivals.look, "the rival")
        assert topic in rivals.look()
        assert len(told) == times
        other.destroy_publisher(publisher)
        wait_for(lambda: rivals.look() is None, "the rival to leave")
    assert f"/{name}" in told[0] and "__node:=" in told[0] and "__ns:=" in told[0]


@pytest.mark.parametrize("owner", [True, False])
def test_a_second_clock_matters_to_an_owner_of_time_only(nodes, owner):
    node, told = nodes(f"arm_{time.monotonic_ns()}"), []
    topic = node.create_publisher(PoseArray, "~/backbone", 1).topic_name
    other = nodes(f"other_{time.monotonic_ns()}")
    clocks = [one.create_publisher(Clock, "/clock", 1) for one in (node, other)]
    wait_for(lambda: node.count_publishers("/clock") >= len(clocks), "both clocks")
    rivals = Rivals(node, topic, owner, told.append)
    assert bool(rivals.look()) == owner
    assert [("publish_clock:=false" in text) for text in told] == [True] * owner
