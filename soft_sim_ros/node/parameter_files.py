"""Parameter files for several nodes: what in them is for this one, and what is for others."""

from __future__ import annotations

import itertools
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


def shared_names(args: Sequence[str], node: str) -> set[str]:
    """Return the parameters that only come from entries for nodes of any name, as ``/**``.

    Whoever writes such an entry speaks to a whole stack, and not every word is for every node.

    Parameters
    ----------
    args : words of the command line, which ROS has accepted
    node : full name of the node, such as ``/left/soft_arm``
    """
    shared: set[str] = set()
    own = {
        word.partition(":=")[0].rpartition(":")[2]
        for flag, word in itertools.pairwise(args)
        if flag in ("-p", "--param")
    }
    for file in parameter_files(args):
        try:
            with open(file, "rb") as stream:
                tree = yaml.load(stream, Loader=yaml.BaseLoader)
            for name, parameters in _entries(tree, ""):
                if _matches(name, node):
                    anybody = name.rpartition("/")[2] in ("*", "**")
                    (shared if anybody else own).update(_flat(parameters, ""))
        except (yaml.YAMLError, ValueError, RecursionError, OSError):
            continue  # `passed_over` says so
    return shared - own


def _flat(parameters: object, above: str) -> Iterator[str]:
    """Yield the names of parameters, those of groups with dots."""
    if not isinstance(parameters, dict):
        yield above
        return
    for key, inner in parameters.items():
        yield from _flat(inner, f"{above}.{key}" if above else str(key))


def _nodes(tree: object, above: str) -> Iterator[str]:
    """Yield the full name or pattern of every node that a parameter file speaks of."""
    for name, _ in _entries(tree, above):
        yield name


def _entries(tree: object, above: str) -> Iterator[tuple[str, object]]:
    """Yield names or patterns of nodes with what a parameter file has for them."""
    if not isinstance(tree, dict):
        return
    for key, inner in tree.items():
        if key == _ENTRIES:
            yield above, inner
        else:
            yield from _entries(inner, f"{above}/{str(key).strip('/')}")


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
