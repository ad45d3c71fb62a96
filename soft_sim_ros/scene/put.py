"""Put values into the YAML text of a scene, by key path."""

from __future__ import annotations

import re
from collections.abc import Mapping

import yaml

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.document import Document, is_null
from soft_sim_ros.scene.edit import child, names

MAP, TEXT = "tag:yaml.org,2002:map", "tag:yaml.org,2002:str"
PART = re.compile(r"(?:^|\.)([A-Za-z_]\w*)|\[(\d+)\]")


def key_path(text: str) -> list[str | int]:
    """Split ``bodies[0].sections.tip.length`` into its keys and indices.

    Raises
    ------
    ValueError
        if it is not a key path
    """
    parts: list[str | int] = []
    at = 0
    while at < len(text):
        found = PART.match(text, at)
        if found is None:
            raise ValueError(text)
        parts.append(found[1] if found[2] is None else int(found[2]))
        at = found.end()
    if not parts or isinstance(parts[0], int) or text[0] == ".":
        raise ValueError(text)
    return parts


def edited(text: str, file: str, values: Mapping[str, str]) -> str:
    """Return a scene with YAML ``values`` put in at their key paths.

    Entries of lists are named by their number or by their name. What a mapping lacks is added:
    whether it means anything is for the scene to say. A change at an anchor changes its aliases, a
    change at an alias nothing else, as in an editor. Comments get lost.

    Raises
    ------
    SceneError
        if a list has no such entry, or there is neither mapping nor list
    """
    root = Document.parse(text, file).root
    for path, value in values.items():
        node = Document.parse(value, f"{file}: {path}").root
        root = _with(root, key_path(path), node, False, file, path)
    return str(yaml.serialize(root, Dumper=yaml.SafeDumper, allow_unicode=True))


def _with(
    node: yaml.Node, parts: list[str | int], value: yaml.Node, shared: bool, file: str, path: str
) -> yaml.Node:
    """Return a node with a value put in: the same one, or a new one where others share it."""
    if not parts:
        return value
    first, rest = parts[0], parts[1:]
    if isinstance(node, yaml.SequenceNode):
        items, entry = list(node.value), child(node, first)
        if entry is None:
            expected = f"a path to one of {len(items)} entries ({', '.join(names(node))})"
            raise SceneError(file, path, str(first), expected)
        index = next(i for i, item in enumerate(items) if item is entry)
        items[index] = _with(items[index], rest, value, shared or _aliased(node, index), file, path)
        return _renewed(node, items, shared)
    if is_null(node):  # a key with nothing after it
        node = yaml.MappingNode(MAP, [], node.start_mark, node.end_mark, flow_style=False)
    if not isinstance(node, yaml.MappingNode) or isinstance(first, int):
        raise SceneError(file, path, str(first), "a path through mappings and lists of the scene")
    pairs = list(node.value)
    for i, (key, old) in enumerate(pairs):
        if key.value == first:
            alias = shared or old.start_mark.index < key.start_mark.index
            pairs[i] = key, _with(old, rest, value, alias, file, path)
            return _renewed(node, pairs, shared)
    merged = child(node, first) or yaml.MappingNode(MAP, [], node.start_mark, flow_style=False)
    new = _with(merged, rest, value, True, file, path)
    return _renewed(node, [*pairs, (yaml.ScalarNode(TEXT, first, node.start_mark), new)], shared)


def _renewed(node: yaml.CollectionNode, entries: list, shared: bool) -> yaml.CollectionNode:
    if shared:
        return type(node)(node.tag, entries, node.start_mark, node.end_mark, node.flow_style)
    node.value = entries
    return node


def _aliased(node: yaml.SequenceNode, index: int) -> bool:
    """Tell whether an entry is written elsewhere: before the list or its earlier entries."""
    at = node.start_mark.index
    for item in node.value[:index]:
        at = max(at, item.end_mark.index)
    return bool(node.value[index].start_mark.index < at)
