"""Words of a scene: what counts as a name or a number, and which known word comes nearest."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection

import yaml

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_DOTTED = re.compile(r"([+-]?)\.(inf|nan)", re.IGNORECASE)


def to_number(node: yaml.Node) -> float:
    """Return the number a YAML node means, NaN if it means none.

    Only plain words count: a quoted "1" is a text. 1e6 is a number although YAML 1.1 says
    otherwise; on, 1:30 and 0x10 are none although YAML 1.1 says they are 1, 90 and 16.
    """
    if not isinstance(node, yaml.ScalarNode) or node.style is not None:
        return math.nan
    try:
        return float(_DOTTED.sub(r"\1\2", node.value))
    except ValueError:
        return math.nan


def nearest(word: str, known: Collection[str]) -> str:
    """Finish the sentence "expected …": the known words, and the one that was probably meant."""
    if not known:
        return "but there is none"
    close = difflib.get_close_matches(word, list(known), 1, 0.6)
    listed = f"one of {', '.join(known)}"
    return f"{listed} (did you mean {close[0]}?)" if close else listed


def misspelt(wanted: Collection[str], written: Collection[str]) -> str | None:
    """Return the written word that probably means one of the wanted ones, if there is any."""
    return next((w for w in written if difflib.get_close_matches(w, list(wanted), 1, 0.7)), None)
