"""Parameter files whose entries are all for other nodes, which ROS passes over in silence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import yaml

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.files import read_bytes
from soft_sim_ros.foreign import listed, one_line
from soft_sim_ros.node.start import parameter_files
from soft_sim_ros.scene.document import MOST_TEXT, words_of

_ENTRIES = "ros__parameters"


def passed_over(args: Sequence[str], node: str) -> Iterator[str]:
    """Give a sentence for every ``--params-file`` that has entries, but none for this node.

    Parameters
    ----------
    args : words of the command line, which ROS has accepted
    node : full name of the node, such as ``/left/soft_arm``
    """
    for file in parameter_files(args):
        try:
            # bytes: YAML says itself how they are encoded
            names = list(_nodes(words_of(read_bytes(file, MOST_TEXT)), ""))
        except (SoftSimError, yaml.YAMLError, ValueError, RecursionError, OSError) as error:
            what = type(error).__name__
            yield f"{one_line(file)} cannot be searched for names of nodes ({what})"
            continue
        if names and not any(_matches(name, node) for name in names):
            yield (
                f"{one_line(file)} has parameters for {listed(names, write=one_line)}, "
                f"but this node is {node}: "
                "nothing of it is used"
            )


def _nodes(tree: object, above: str) -> Iterator[str]:
    """Yield the full name or pattern of every node that a parameter file speaks of."""
    if not isinstance(tree, dict):
        return
    for key, inner in tree.items():
        if key == _ENTRIES:
            yield above
        else:
            yield from _nodes(inner, f"{above}/{str(key).strip('/')}")


def _matches(pattern: str, node: str) -> bool:
    """Whether a name matches, with ``*`` for one part of it and ``**`` for any number of them."""
    parts = node.strip("/").split("/")
    reached = {0}  # how many parts the words so far can stand for
    for word in pattern.strip("/").split("/"):
        if word == "**":
            reached = {i for first in reached for i in range(first, len(parts) + 1)}
        else:
            reached = {i + 1 for i in reached if i < len(parts) and word in ("*", parts[i])}
    return len(parts) in reached
