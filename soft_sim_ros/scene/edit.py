"""Numbers of a scene by key path, read and replaced in its text: comments and layout stay."""

from __future__ import annotations

import re
from collections.abc import Mapping

import yaml

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.document import MERGE, Document
from soft_sim_ros.scene.words import to_number

_PART = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def number_at(text: str, file: str, path: str) -> float:
    """Return the number at a key path such as ``materials.rubber.density``.

    Entries of lists go by their number, ``bodies[0]``, or by their name, ``bodies.arm``.

    Raises
    ------
    SceneError
        if no number is written there
    """
    return to_number(_node_at(Document.parse(text, file), path))


def with_numbers(text: str, file: str, values: Mapping[str, float]) -> str:
    """Return the text with the numbers at some key paths replaced, each exact to the bit.

    A number behind an anchor (``&name``) changes wherever the anchor is used.

    Raises
    ------
    SceneError
        if no number is written at a path, or two paths lead to the same one
    """
    document = Document.parse(text, file)
    spots: dict[int, tuple[int, float]] = {}
    for path, value in values.items():
        node = _node_at(document, path)
        begin = node.start_mark.index
        if begin in spots:
            expected = "every number once (another path leads here, too)"
            raise SceneError(file, path, value, expected, node.start_mark.line + 1)
        spots[begin] = node.end_mark.index, value
    for begin in sorted(spots, reverse=True):
        end, value = spots[begin]
        text = f"{text[:begin]}{float(value)!r}{text[end:]}"
    return text


def _node_at(document: Document, path: str) -> yaml.Node:
    """Return the node of a number."""
    parts = [name or int(index) for name, index in _PART.findall(path)]
    node = document.root
    for depth, part in enumerate(parts):
        inner = child(node, part)
        if inner is None:
            known = ", ".join(names(node)) or "nothing"
            expected = (
                f"a key path to a number that is written there: {part!r} is not among {known}"
            )
            place = ".".join(map(str, parts[:depth])) or "scene"
            raise SceneError(document.file, path, f"(in {place})", expected)
        node = inner
    if to_number(node) != to_number(node):  # NaN: no number
        line = node.start_mark.line + 1
        raise SceneError(document.file, path, document.quote(node), "a number", line)
    return node


def child(node: yaml.Node, part: str | int) -> yaml.Node | None:
    """Return what is written for a key, a number in a list, or the entry of that name."""
    if isinstance(node, yaml.SequenceNode):
        if isinstance(part, int):
            return node.value[part] if part < len(node.value) else None
        return dict(zip(names(node), node.value, strict=True)).get(part)
    if not isinstance(node, yaml.MappingNode):
        return None
    merged = None
    for key, value in node.value:
        if key.value == part:
            return value
        if key.tag == MERGE:
            merged = child(value, part)
    return merged


def names(node: yaml.Node) -> list[str]:
    """Return the keys of a mapping, or the names of the entries of a list."""
    if isinstance(node, yaml.MappingNode):
        return [str(key.value) for key, _ in node.value]
    out = []
    for i, item in enumerate(node.value if isinstance(node, yaml.SequenceNode) else []):
        word = child(item, "name")
        if word is None and isinstance(item, yaml.MappingNode) and item.value:
            word = item.value[0][1]
        out.append(str(word.value) if isinstance(word, yaml.ScalarNode) else f"[{i}]")
    return out
