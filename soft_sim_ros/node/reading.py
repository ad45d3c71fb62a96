"""From what the user gave at the start to settings, and what of them a recording keeps."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rclpy.node import Node

from soft_sim_ros.foreign import listed
from soft_sim_ros.node.parameter_files import passed_over, shared_names
from soft_sim_ros.node.parameters import (
    OWN,
    ROWS,
    USE_SIM_TIME,
    Settings,
    declare,
    strangers,
)
from soft_sim_ros.node.quality import check_overrides
from soft_sim_ros.recording.claims import REMAPPED
from soft_sim_ros.recording.topics import CONTACTS, EVENTS, FELT, INPUTS, OUTPUTS, VIEWS
from soft_sim_ros.scene import load_scene


def named(node: Node, args: Sequence[str]) -> Node:
    """Return the node, or another one in its place that is called after the scene.

    Parameters
    ----------
    node : Node
        The node that was made with ``args``; its parameters are not declared yet.
    args : words of the command line

    Raises
    ------
    SceneError
        If there is no such scene.
    """
    given = {name: parameter.value for name, parameter in node._parameter_overrides.items()}
    scene = given.get("scene", ROWS["scene"].default)
    if given.get("name_from") != "scene" or not isinstance(scene, str):
        return node
    other = Node(
        load_scene(scene).name,
        namespace=node.get_namespace(),
        cli_args=without_node_name(args),
        use_global_arguments=False,
        parameter_overrides=list(node._parameter_overrides.values()),
    )
    node.destroy_node()
    return other


def without_node_name(args: Sequence[str]) -> list[str]:
    """Return the words of a command line without rules that give nodes another name."""
    words: list[str] = []
    for word in args:
        before = words[-1] if words else ""
        if before in ("-r", "--remap") and word.partition(":=")[0].rpartition(":")[2] == "__node":
            words.pop()
        else:
            words.append(word)
    return words


def read_settings(node: Node, args: Sequence[str], name: str = "") -> Settings:
    """Declare the parameters and return their values; say what is for others.

    Parameters
    ----------
    node : Node
        The node that was made with ``args``.
    args : words of the command line
    name : str
        Full name under which parameter files speak to it; empty = its own.

    Raises
    ------
    ParameterError
        With all that is wrong with parameters, or with qualities of service.
    """
    log, name = node.get_logger(), name or node.get_fully_qualified_name()
    for text in passed_over(args, name):
        log.warning(text)
    shared = shared_names(args, name)
    others = strangers(node, shared)
    settings = declare(node, others, shared)
    clock = ["/clock"] if settings.publish_clock else []
    published = [topic for topic, _, _ in (*OUTPUTS.values(), FELT[CONTACTS], *EVENTS.values())]
    subscribed = [topic for topic, _, _ in INPUTS.values()]
    if settings.time != OWN:
        subscribed.append("/clock")
    views = [topic for topic, _, _ in VIEWS.values()] if settings.marker_rate else []
    others += check_overrides(node, published + views + clock, subscribed, shared)
    if settings.publish_clock and USE_SIM_TIME in shared:
        log.info(
            "use_sim_time is said to all nodes, so this one owns time and publishes /clock; "
            "publish_clock:=false follows another clock"
        )
    if others:
        log.info(f"passed over, since not for this node: {listed(others, 20)}")
    return settings


def run_metadata(settings: Settings, prefix: str, remapped: dict[str, str]) -> dict[str, str]:
    """Everything besides the scene that a re-simulation or a replay needs to know, as text.

    ``remapped`` are topics by their own names, with those under which they are heard.
    """
    names = (
        "command_timeout", "command_ramp", "frame_id", "poses", "publish_rate", "control_rate",
        "real_time_factor", "joint_command_hold", "time",
    )  # fmt: skip
    moved = {own: heard for own, heard in remapped.items() if own != heard}
    other = {REMAPPED: json.dumps(moved)} if moved else {}
    return (
        {"node": prefix}
        | other
        | {name: repr(getattr(settings, name)).strip("'") for name in names}
    )
