"""Parameter files whose entries are all for other nodes, which ROS passes over in silence."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import yaml

_FLAG, _ENTRIES = "--params-file", "ros__parameters"


def passed_over(args: Sequence[str], node: str) -> Iterator[str]:
    """Give a sentence for every ``--params-file`` that has entries, but none for this node.

    Parameters
    ----------
    args : words of the command line, which ROS has accepted
    node : full name of the node, such as ``/left/soft_arm``
    """
    for flag, file in zip(args, args[1:], strict=False):
        if flag != _FLAG:
            continue
        with open(file, encoding="utf-8") as stream:
            names = list(_nodes(yaml.safe_load(stream), ""))
        if names and not any(_matches(name, node) for name in names):
            yield (
                f"{file} has parameters for {', '.join(names)}, but this node is {node}: "
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
    parts = {"*": r"/[^/]+", "**": r"(/[^/]+)*"}
    words = pattern.strip("/").split("/")
    return re.fullmatch("".join(parts.get(w, "/" + re.escape(w)) for w in words), node) is not None
