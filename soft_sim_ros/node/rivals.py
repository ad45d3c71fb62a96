"""Other nodes that publish what only this one may."""

from __future__ import annotations

from collections.abc import Callable


class Rivals:
    """Watches for a second node of the same name, and for a second owner of time.

    Parameters
    ----------
    node : rclpy.node.Node
        The node that should be the only one.
    topic : str
        Full name of a topic that carries the node's name.
    clock : bool
        Whether this node owns time.
    warn : callable
        Told once, when there is a rival, and again when another one comes after it has left.
    follows : bool
        Whether this node follows the clock of another, of which there may be one.
    """

    def __init__(
        self, node, topic: str, clock: bool, warn: Callable[[str], None], follows: bool = False
    ):
        name = node.get_fully_qualified_name()
        self._node, self._warn = node, warn
        self._advice = {
            topic: f"is there a second {name}, or a replay? Give one of them another name "
            "(--ros-args -r __node:=NAME) or namespace (-r __ns:=/NAME)",
        }
        if clock:
            self._advice["/clock"] = (
                "time jumps for all who follow it; use_sim_time:=true, or publish_clock:=false, "
                "for all but one"
            )
        if follows:
            self._advice["/clock"] = "time jumps between them; leave one owner of time"
        self._follows = follows
        self._told: dict[str, bool] = {}

    def look(self) -> str | None:
        """Return what is wrong, in a sentence; warn if it is new."""
        found = None
        for topic, advice in self._advice.items():
            others = self._node.count_publishers(topic) - 1
            if others > 0:
                text = f"{others} other node{'s publish' if others > 1 else ' publishes'} {topic}"
                if self._follows and topic == "/clock":
                    text = f"{others + 1} nodes publish {topic}"
                found = found or text
                if not self._told.get(topic):
                    self._warn(f"{text}: {advice}")
            self._told[topic] = others > 0
        return found
