"""A sweep: a YAML file that says which runs there are.

::

    scenes: [soft_arm]
    duration: 2.0
    parameters:
      materials.silicone.young_modulus: [5e5, 7e5, 1e6]
      materials.silicone.viscosity: {from: 1e4, to: 1e5, count: 3, scale: log}
      bodies.arm.sections.distal.length: {uniform: [0.15, 0.25]}
    repeats: 4
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.batch.run import Run
from soft_sim_ros.recording.claims import MOST_POSES
from soft_sim_ros.scene import load_scene
from soft_sim_ros.scene.document import Document
from soft_sim_ros.scene.interval import FINITE, NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.load_scene import find_scene, read_scene
from soft_sim_ros.scene.put import key_path
from soft_sim_ros.scene.reader import Reader

KEYS = (
    "scenes", "duration", "commands", "publish_rate", "poses", "max_error",
    "parameters", "combine", "repeats", "seed",
)  # fmt: skip
MOST_RUNS = 1_000_000
DRAWN = ("uniform", "log_uniform", "normal")


@dataclass(frozen=True)
class Drawn:
    """A value that is drawn anew in every run."""

    kind: str
    first: float
    second: float

    def draw(self, rng: np.random.Generator) -> str:
        """Return a value as YAML."""
        if self.kind == "normal":
            return repr(float(rng.normal(self.first, self.second)))
        if self.kind == "uniform":
            return repr(float(rng.uniform(self.first, self.second)))
        return repr(float(np.exp(rng.uniform(np.log(self.first), np.log(self.second)))))


def read_sweep(
    path: str | Path, scenes: Sequence[str] = (), duration: float | None = None
) -> list[Run]:
    """Return the runs of a sweep file, in order.

    Parameters
    ----------
    path : the file; scenes and commands in it are looked up from its folder
    scenes : scene files or names, instead of those in the file
    duration : s, instead of that in the file

    Raises
    ------
    SceneError
        with file, key, value and what is expected
    """
    path = Path(path)
    document = Document.parse(read_scene(path), str(path))
    reader = Reader(document, document.root).only(*KEYS)
    files = list(scenes) or [_beside(path, name) for name in _words(reader, "scenes")]
    if not files:
        reader.refuse("a list of scene files, or of names of scenes", "scenes")
    length = reader.number("duration", POSITIVE, duration) if duration is None else duration
    if length is None:
        reader.refuse("the simulated time in s", "duration")
    commands = reader.word("commands", None)
    common: dict[str, Any] = {
        "duration": length,
        "commands": None if commands is None else _beside(path, commands),
        "publish_rate": reader.number("publish_rate", POSITIVE, 100.0),
        "poses": reader.whole("poses", Interval.parse(f"[2, {MOST_POSES}]"), 51),
        "max_error": reader.number("max_error", Interval.parse("(0, inf]"), None),
    }
    choices = _parameters(reader, commands is not None)
    rows = _combined(reader, choices)
    repeats = reader.whole("repeats", Interval.parse(f"[1, {MOST_RUNS}]"), 1)
    if repeats * len(files) * len(rows) > MOST_RUNS:
        reader.refuse(f"at most {MOST_RUNS} runs in all", "repeats", repeats)
    seed = reader.whole("seed", NONNEGATIVE, 0)
    runs: list[Run] = []
    texts = {file: read_scene(find_scene(file)) for file in files}
    for _ in range(repeats):  # outermost: more repeats leave the seeds of earlier runs alone
        for file, row in itertools.product(files, rows):
            own = seed + len(runs)
            rng = np.random.default_rng(own)
            values = {k: v.draw(rng) if isinstance(v, Drawn) else v for k, v in row.items()}
            name = str(find_scene(file))
            runs.append(Run(name, texts[file], parameters=values, seed=own, **common))
    return runs


def runs_of(scenes: Sequence[str], **common: Any) -> list[Run]:
    """Return one run per scene file or name; ``common`` goes to every Run."""
    loaded = [load_scene(name) for name in scenes]
    return [Run(scene.file, scene.source, **common) for scene in loaded]


def _words(reader: Reader, key: str) -> list[str]:
    node = reader.written(key)
    if node is None:
        return []
    items = node.value if isinstance(node, yaml.SequenceNode) else [node]
    if not items or not all(isinstance(item, yaml.ScalarNode) for item in items):
        reader.refuse("a file or name, or a list of them", key)
    return [item.value for item in items]


def _beside(path: Path, name: str) -> str:
    """Return a file next to the sweep, if there is one, else the name as it is."""
    here = path.parent / name
    return str(here) if here.is_file() else name


def _parameters(reader: Reader, commanded: bool) -> dict[str, list[str] | str | Drawn]:
    """Return key path → alternatives, one value, or how to draw it."""
    parameters = reader.mapping("parameters")
    out: dict[str, list[str] | str | Drawn] = {}
    for key in parameters.keys():
        try:
            key_path(key)
        except ValueError:
            parameters.refuse("a key path, such as bodies[0].sections[1].length", key)
        if commanded and key.startswith("efforts."):
            parameters.no_effect(key, "commands set the efforts")
        node = parameters.written(key)
        if isinstance(node, yaml.SequenceNode):
            if not node.value:
                parameters.refuse("at least one value", key)
            out[key] = [_yaml(item) for item in node.value]
        elif isinstance(node, yaml.MappingNode):
            out[key] = _range(parameters.mapping(key))
        else:
            out[key] = _yaml(node)
    return out


def _range(reader: Reader) -> list[str] | Drawn:
    kind = reader.one_of(("from", *DRAWN))
    if kind in DRAWN:
        reader.only(kind)
        within = POSITIVE if kind == "log_uniform" else FINITE
        first, second = reader.vector(kind, 2, within)
        if kind == "normal" and second < 0.0:
            reader.refuse("[mean, standard deviation >= 0]", kind)
        return Drawn(kind, float(first), float(second))
    reader.only("from", "to", "count", "scale")
    scale = reader.choice("scale", ("linear", "log"), default="linear")
    within = POSITIVE if scale == "log" else FINITE
    ends = reader.number("from", within), reader.number("to", within)
    count = reader.whole("count", Interval.parse(f"[2, {MOST_RUNS}]"))
    values = np.geomspace(*ends, count) if scale == "log" else np.linspace(*ends, count)
    return [repr(float(value)) for value in values]


def _combined(
    reader: Reader, choices: dict[str, list[str] | str | Drawn]
) -> list[dict[str, str | Drawn]]:
    """Return the rows: every combination of the lists, or their first, second, … entries."""
    combine = reader.choice("combine", ("grid", "list"), default="grid")
    listed = {key: value for key, value in choices.items() if isinstance(value, list)}
    if combine == "list":
        lengths = {len(value) for value in listed.values()}
        if len(lengths) > 1:
            told = ", ".join(f"{key} has {len(value)}" for key, value in listed.items())
            reader.refuse(f"lists of one length to go through together ({told})", "combine")
        combinations = list(zip(*listed.values(), strict=True)) if listed else [()]
    else:
        if math.prod(len(value) for value in listed.values()) > MOST_RUNS:
            reader.refuse(f"at most {MOST_RUNS} combinations", "parameters")
        combinations = list(itertools.product(*listed.values()))
    return [
        {k: v for k, v in choices.items() if not isinstance(v, list)}
        | dict(zip(listed, combination, strict=True))
        for combination in combinations
    ]


def _yaml(node: yaml.Node | None) -> str:
    """Return a node as YAML on one line."""
    if isinstance(node, yaml.ScalarNode) and node.style is None:
        return str(node.value)
    text = yaml.serialize(node, Dumper=yaml.SafeDumper, allow_unicode=True, width=10**9)
    return str(text).strip().removesuffix("...").strip()
