"""From what the user gave at the start to settings, and what of them a recording keeps."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node

from soft_sim_ros.foreign import listed
from soft_sim_ros.node.parameter_files import passed_over, shared_names
from soft_sim_ros.node.parameters import OWN, USE_SIM_TIME, Settings, declare, strangers
from soft_sim_ros.node.quality import check_overrides
from soft_sim_ros.recording.topics import EVENTS, INPUTS, OUTPUTS, VIEWS


def read_settings(node: Node, args: Sequence[str]) -> Settings:
    """Declare the parameters and return their values; say what is for others.

    Parameters
    ----------
    node : Node
        The node that was made with ``args``.
    args : words of the command line

    Raises
    ------
    ParameterError
        With all that is wrong with parameters, or with qualities of service.
    """
    log, name = node.get_logger(), node.get_fully_qualified_name()
    for text in passed_over(args, name):
        log.warning(text)
    shared = shared_names(args, name)
    others = strangers(node, shared)
    settings = declare(node, others, shared)
    clock = ["/clock"] if settings.publish_clock else []
    published = [topic for topic, _, _ in (*OUTPUTS.values(), *EVENTS.values())]
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


def run_metadata(settings: Settings, prefix: str) -> dict[str, str]:
    """Everything besides the scene that a re-simulation of the run needs to know, as text."""
    names = (
        "command_timeout", "command_ramp", "frame_id", "poses", "publish_rate", "control_rate",
        "real_time_factor", "joint_command_hold", "time",
    )  # fmt: skip
    return {"node": prefix} | {name: repr(getattr(settings, name)).strip("'") for name in names}
