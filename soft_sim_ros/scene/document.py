"""A YAML text as a tree of nodes with their places in the text.

The nodes are not converted to Python values: YAML 1.1 would read ``1e6`` as text, ``1:30`` as 90
and ``on`` as true, so the reader decides what a word means from what the scene expects there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import yaml

from soft_sim_ros.errors import SceneError

LONGEST_QUOTE = 60
MOST_TEXT = 2_000_000  # characters
MOST_ENTRIES = 80_000  # keys, words and lists that are written
MOST_MEANT = 1_000_000  # the same with every alias and merge expanded
MERGE = "tag:yaml.org,2002:merge"


class _Bounded(yaml.SafeLoader):
    """Composes nodes; refuses texts with too many entries."""

    def __init__(self, text: str | bytes) -> None:
        super().__init__(text)
        self._entries = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose the next node."""
        self._entries += 1
        if self._entries > MOST_ENTRIES:
            problem, mark = f"more than {MOST_ENTRIES} entries", self.peek_event().start_mark
            raise yaml.composer.ComposerError(None, None, problem, mark)
        return super().compose_node(parent, index)


class _Loader(_Bounded):
    """Composes nodes; refuses tags, which have no meaning here."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose the next node."""
        event = self.peek_event()
        tag = getattr(event, "tag", None)
        if tag is not None:
            raise yaml.composer.ComposerError(None, None, f"found the tag {tag}", event.start_mark)
        return super().compose_node(parent, index)


@dataclass(frozen=True)
class Document:
    """A text, the name of its file, and the root of its YAML tree.

    ``inlined`` is what stands for parts of the text that name other files: begin → (end, text).
    """

    file: str
    text: str
    root: yaml.Node
    inlined: dict[int, tuple[int, str]] = field(default_factory=dict)

    @staticmethod
    def parse(text: str, file: str) -> Document:
        """Compose the one YAML document of a text; syntax errors name file and line."""
        if len(text) > MOST_TEXT:
            found = f"({len(text)} characters)"
            raise SceneError(file, "", found, f"at most {MOST_TEXT} characters")
        try:
            root = yaml.compose(text, Loader=_Loader)
            meant = 0 if root is None else _meant(root, {})
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            problem = error.problem or error.context or "not YAML"
            raise _syntax_error(file, problem, mark.line + 1 if mark else None) from error
        except (yaml.YAMLError, ValueError, OverflowError) as error:
            raise _syntax_error(file, str(error).partition("\n")[0]) from error
        except RecursionError as error:
            raise _syntax_error(file, "nested too deeply") from error
        if root is None:
            raise SceneError(file, "", None, "a mapping with the key 'bodies', not an empty file")
        if meant > MOST_MEANT:
            found = f"(aliases and merges that stand for {meant:.1e} entries)"
            raise SceneError(file, "", found, f"at most {MOST_MEANT} entries, aliases in full")
        return Document(file, text, root)

    @property
    def source(self) -> str:
        """The text with the content of other files put in their place: it means the same alone."""
        text = self.text
        for begin in sorted(self.inlined, reverse=True):
            end, content = self.inlined[begin]
            written = text[begin:end]
            text = text[:begin] + content + written[len(written.rstrip()) :] + text[end:]
        return text

    def quote(self, node: yaml.Node) -> str:
        """Return what was written for a node, cut after its first line."""
        written = self.text[node.start_mark.index : node.end_mark.index]
        first, *more = written.strip().splitlines() or ["(nothing)"]
        if more or len(first) > LONGEST_QUOTE:
            return first[: LONGEST_QUOTE - 2].rstrip() + " …"
        return first


def words_of(text: bytes) -> object:
    """Return a YAML text of another program as words, lists and mappings, within the same bounds.

    Raises
    ------
    yaml.YAMLError, ValueError, RecursionError
        if it is no YAML, or too much
    """
    root = yaml.compose(text, Loader=_Bounded)
    if root is None:
        return None
    if (meant := _meant(root, {})) > MOST_MEANT:
        raise ValueError(f"aliases that stand for {meant:.1e} entries, at most {MOST_MEANT}")
    return yaml.constructor.BaseConstructor().construct_document(root)


def _syntax_error(file: str, problem: str, line: int | None = None) -> SceneError:
    return SceneError(file, "", f"({problem})", "valid YAML", line)


def _meant(node: yaml.Node, known: dict[int, int]) -> int:
    """Count the entries below a node with every alias in full; at most a million times too many."""
    if isinstance(node, yaml.ScalarNode):
        return 1
    if id(node) not in known:
        known[id(node)] = -1
        parts = node.value if isinstance(node, yaml.SequenceNode) else sum(node.value, ())
        count = 1 + sum(_meant(part, known) for part in parts)
        known[id(node)] = min(count, MOST_MEANT**2)
    if known[id(node)] < 0:
        raise ValueError("an alias stands for something that holds it")
    return known[id(node)]


def is_null(node: yaml.Node) -> bool:
    """Tell whether nothing (or null, ~) is written for a node."""
    return isinstance(node, yaml.ScalarNode) and node.tag == "tag:yaml.org,2002:null"
