"""Reads one mapping of a scene: known keys only, every value converted and checked.

Reading a mapping is a list of declarations::

    reader.only("length", "frame")
    length = reader.number("length", POSITIVE)
    frame = reader.choice("frame", ("world", "body"), default="world")

Every fault becomes a SceneError with file, line, key path, value and what was expected.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any, NoReturn, TypeVar

import numpy as np
import yaml

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.document import MERGE, Document, is_null
from soft_sim_ros.scene.interval import FINITE, Interval
from soft_sim_ros.scene.taper import Floats, Taper
from soft_sim_ros.scene.words import NAME, misspelt, nearest, to_number

REQUIRED: Any = object()
T = TypeVar("T")


class Reader:
    """The keys and values of one mapping, and its place in the file."""

    def __init__(self, document: Document, node: yaml.Node, path: str = "") -> None:
        self.document, self.node, self.path = document, node, path
        if not isinstance(node, yaml.MappingNode) and not is_null(node):
            self.refuse("a mapping (key: value)")
        self._pairs = self._collect(node) if isinstance(node, yaml.MappingNode) else {}

    # -- what is there ---------------------------------------------------------------------

    def only(self, *known: str) -> Reader:
        """Refuse keys that are not known here, naming the nearest one that is."""
        for key in self._pairs:
            if key not in known:
                self.refuse(f"a known key, {nearest(key, known)}", key)
        return self

    def has(self, key: str) -> bool:
        """Tell whether a key is written."""
        return key in self._pairs

    def keys(self) -> list[str]:
        """Return all keys in the order of the file."""
        return list(self._pairs)

    def one_of(self, keys: Sequence[str], default: str | None = None) -> str:
        """Return the only one of some alternative keys that is written."""
        found = [key for key in keys if self.has(key)]
        if len(found) > 1:
            self.refuse(f"only one of {' and '.join(found)}", found[1])
        if not found and default is None:
            wrong = misspelt(keys, self._pairs)
            expected = f"one of the keys {', '.join(keys)}"
            self.refuse(f"a known key, {nearest(wrong, keys)}" if wrong else expected, wrong)
        return found[0] if found else str(default)

    def no_effect(self, key: str, why: str) -> None:
        """Refuse a key that would be ignored."""
        if self.has(key):
            self.refuse(f"no such key: {why}", key)

    # -- values ----------------------------------------------------------------------------

    def number(self, key: str, within: Interval = FINITE, default: Any = REQUIRED) -> Any:
        """Return a number; ``default`` if the key is absent."""
        node = self._find(key, default, f"a {within}")
        return default if node is None else self._number(node, within, self._at(key))

    def whole(self, key: str, within: Interval, default: Any = REQUIRED) -> Any:
        """Return a whole number."""
        value = self.number(key, within, default)
        if key in self._pairs and value != int(value):
            self.refuse(f"a whole {within}", key)
        return int(value) if key in self._pairs else value

    def vector(
        self, key: str, size: int, within: Interval = FINITE, default: Any = REQUIRED
    ) -> Any:
        """Return a list of numbers as a read-only array (size,)."""
        expected = f"a list of {size} entries, each a {within}"
        node = self._find(key, default, expected)
        if node is None:
            return frozen(default)
        items = self._items(node, size, expected, self._at(key))
        path = self._at(key)
        return frozen([self._number(n, within, f"{path}[{i}]") for i, n in enumerate(items)])

    def numbers(self, key: str, within: Interval = FINITE) -> Floats:
        """Return a list of numbers of any length as a read-only array."""
        expected = f"a list of entries, each a {within}"
        node = self._find(key, REQUIRED, expected)
        items = [] if node is None else self._items(node, None, expected, self._at(key))
        path = self._at(key)
        return frozen([self._number(n, within, f"{path}[{i}]") for i, n in enumerate(items)])

    def matrix(self, key: str, rows: int | None, columns: int) -> Any:
        """Return a list of lists of numbers as a read-only array (rows, columns)."""
        expected = f"a list of {'' if rows is None else f'{rows} '}lists of {columns} numbers"
        node = self._find(key, REQUIRED, expected)
        path = self._at(key)
        lists = [] if node is None else self._items(node, rows, expected, path)
        return frozen([
            [
                self._number(entry, FINITE, f"{path}[{i}][{j}]")
                for j, entry in enumerate(self._items(item, columns, expected, f"{path}[{i}]"))
            ]
            for i, item in enumerate(lists)
        ])  # fmt: skip

    def taper(self, key: str, within: Interval = FINITE, default: Any = REQUIRED) -> Taper:
        """Return a number, or a pair of numbers [start, end] with a straight line between."""
        node = self._find(key, default, f"a {within} or a pair [start, end] of them")
        return Taper(default, default) if node is None else self._taper(node, within, self._at(key))

    def taper_or(
        self,
        read: Callable[[Reader], T],
        key: str,
        within: Interval = FINITE,
        default: Any = REQUIRED,
    ) -> Taper | T:
        """Return a taper, or what ``read`` makes of a mapping."""
        node = self._find(key, default, f"a {within} or a pair [start, end] of them")
        if node is None:
            return Taper(default, default)
        return self._taper_or(read, node, within, self._at(key))

    def tapers_or(
        self,
        read: Callable[[Reader], T],
        key: str,
        size: int,
        within: Interval = FINITE,
        default: Any = REQUIRED,
    ) -> tuple[Taper | T, ...]:
        """Return a list of tapers, or of what ``read`` makes of mappings."""
        expected = f"a list of {size} entries, each a number or a pair [start, end]"
        node = self._find(key, default, expected)
        if node is None:
            return (Taper(default, default),) * size
        items = self._items(node, size, expected, self._at(key))
        path = self._at(key)
        return tuple(self._taper_or(read, n, within, f"{path}[{i}]") for i, n in enumerate(items))

    def word(self, key: str, default: Any = REQUIRED, expected: str = "a text") -> Any:
        """Return a text."""
        node = self._find(key, default, expected)
        if node is None:
            return default
        if not isinstance(node, yaml.ScalarNode) or is_null(node):
            self.refuse(expected, key)
        return node.value

    def name(self, key: str, default: Any = REQUIRED, taken: Collection[str] = ()) -> Any:
        """Return a new name: letters, digits and underscores, not yet taken."""
        expected = "a name of letters, digits and _ that starts with a letter"
        name = self.word(key, default, expected)
        if not NAME.fullmatch(name):
            self.refuse(expected, key)
        if name in taken:
            self.refuse("a name that is not used twice", key)
        return name

    def choice(self, key: str, options: Collection[str], default: Any = REQUIRED) -> Any:
        """Return one of some fixed words."""
        word = self.word(key, default, nearest("", options))
        if key in self._pairs and word not in options:
            self.refuse(nearest(word, options), key)
        return word

    def choices(self, key: str, options: Sequence[str]) -> tuple[str, ...]:
        """Return some of some fixed words, each at most once, in the order of ``options``."""
        node = self._find(key, None, "")
        if node is None:
            return tuple(options)
        items = self._items(node, None, f"a list of some of {', '.join(options)}", self._at(key))
        words = [item.value if isinstance(item, yaml.ScalarNode) else "" for item in items]
        for i, (word, item) in enumerate(zip(words, items, strict=True)):
            if word not in options:
                self._refuse_node(item, f"{self._at(key)}[{i}]", nearest(word, options))
            if word in words[:i]:
                self._refuse_node(item, f"{self._at(key)}[{i}]", "every word only once")
        if not words:
            self.refuse(f"at least one of {', '.join(options)}", key)
        return tuple(word for word in options if word in words)

    def reference(
        self, key: str, known: Collection[str], what: str, default: Any = REQUIRED
    ) -> Any:
        """Return the name of something defined elsewhere in the scene."""
        name = self.word(key, default, f"the name of a {what}, {nearest('', known)}")
        if name not in known:
            self.refuse(f"the name of a {what}, {nearest(name, known)}", key)
        return name

    def references(self, key: str, known: Collection[str], what: str) -> tuple[str, ...]:
        """Return names of things defined elsewhere in the scene, in the order written."""
        expected = f"a list of names, each that of a {what}"
        node = self._find(key, REQUIRED, expected)
        items = [] if node is None else self._items(node, None, expected, self._at(key))
        words = [item.value if isinstance(item, yaml.ScalarNode) else "" for item in items]
        for i, (word, item) in enumerate(zip(words, items, strict=True)):
            if word not in known:
                wanted = f"the name of a {what}, {nearest(word, known)}"
                self._refuse_node(item, f"{self._at(key)}[{i}]", wanted)
            if word in words[:i]:
                self._refuse_node(item, f"{self._at(key)}[{i}]", "every name only once")
        if not words:
            self.refuse(f"at least one name of a {what}", key)
        return tuple(words)

    def mapping(self, key: str, required: bool = False) -> Reader:
        """Return the reader of a mapping; an absent or empty one reads as ``{}``."""
        node = self._find(key, REQUIRED if required else None, "a mapping (key: value)")
        if node is None:
            node = yaml.MappingNode("", [], self.node.start_mark, self.node.start_mark)
        return Reader(self.document, node, self._at(key))

    def entries(self, key: str, required: bool = False) -> list[Reader]:
        """Return the readers of a list of mappings; absent or empty reads as ``[]``."""
        expected = "a list with at least one entry" if required else "a list"
        node = self._find(key, REQUIRED if required else None, expected)
        path = self._at(key)
        items = [] if node is None or is_null(node) else self._items(node, None, expected, path)
        if required and not items:
            self.refuse(expected, key)
        return [Reader(self.document, item, f"{path}[{i}]") for i, item in enumerate(items)]

    def written(self, key: str) -> yaml.Node | None:
        """Return what is written for a key as it is, None if nothing is."""
        return self._find(key, None, "")

    def says(self, key: str, word: str) -> bool:
        """Tell whether the value of a key is a certain word."""
        return self.has(key) and getattr(self._pairs[key][1], "value", None) == word

    def is_list(self, key: str) -> bool:
        """Tell whether the value of a key is a list."""
        return self.has(key) and isinstance(self._pairs[key][1], yaml.SequenceNode)

    def is_mapping(self, key: str) -> bool:
        """Tell whether the value of a key is a mapping."""
        return self.has(key) and isinstance(self._pairs[key][1], yaml.MappingNode)

    def inline(self, content: str) -> None:
        """Have the source of the scene say ``content`` where this mapping names a file."""
        begin, end = self.node.start_mark.index, self.node.end_mark.index
        self.document.inlined[begin] = (end, content)

    # -- refusing --------------------------------------------------------------------------

    def refuse(self, expected: str, key: str | None = None, value: object = None) -> NoReturn:
        """Raise the error for a key of this mapping, or for the mapping itself."""
        if key is None:
            self._refuse_node(self.node, self.path, expected)
        line = self._line(self.node)
        if key in self._pairs:
            line, value = self._line(self._pairs[key][0]), self.document.quote(self._pairs[key][1])
        raise SceneError(self.document.file, self._at(key), value, expected, line)

    def _refuse_node(self, node: yaml.Node, path: str, expected: str) -> NoReturn:
        document = self.document
        raise SceneError(document.file, path, document.quote(node), expected, self._line(node))

    @staticmethod
    def _line(node: yaml.Node) -> int:
        return int(node.start_mark.line) + 1

    # -- nodes -----------------------------------------------------------------------------

    def _at(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _collect(
        self, node: yaml.MappingNode, merging: int = 0
    ) -> dict[str, tuple[yaml.Node, yaml.Node]]:
        """Return key → (key node, value node), merge keys (<<) resolved."""
        own: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        merged: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                self._refuse_node(key, self.path, "a word as key")
            if key.tag == MERGE:
                if not isinstance(value, yaml.MappingNode) or merging > 8:
                    self._refuse_node(value, self._at("<<"), "one mapping to merge (<<: *anchor)")
                merged.update(self._collect(value, merging + 1))
            elif key.value in own:
                expected = f"every key once (first in line {self._line(own[key.value][0])})"
                self._refuse_node(value, self._at(key.value), expected)
            else:
                own[key.value] = key, value
        return {**merged, **own}

    def _find(self, key: str, default: Any, expected: str) -> yaml.Node | None:
        if self.has(key):
            return self._pairs[key][1]
        if default is REQUIRED:
            self.refuse(expected, key)
        return None

    def _items(
        self, node: yaml.Node, size: int | None, expected: str, path: str
    ) -> list[yaml.Node]:
        if not isinstance(node, yaml.SequenceNode) or size not in (None, len(node.value)):
            self._refuse_node(node, path, expected)
        return list(node.value)

    def _number(self, node: yaml.Node, within: Interval, path: str) -> float:
        value = to_number(node)
        if expected := within.refuses(value):
            self._refuse_node(node, path, expected)
        return value

    def _taper_or(
        self, read: Callable[[Reader], T], node: yaml.Node, within: Interval, path: str
    ) -> Taper | T:
        if isinstance(node, yaml.MappingNode):
            return read(Reader(self.document, node, path))
        return self._taper(node, within, path)

    def _taper(self, node: yaml.Node, within: Interval, path: str) -> Taper:
        if not isinstance(node, yaml.SequenceNode):
            value = self._number(node, within, path)
            return Taper(value, value)
        start, end = self._items(node, 2, f"a {within} or a pair [start, end]", path)
        return Taper(
            self._number(start, within, f"{path}[0]"), self._number(end, within, f"{path}[1]")
        )


def frozen(values: Any) -> Floats:
    """Return an array that cannot be written to."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
