"""The model of a scene whose rods have other materials than those of a scene compiled before."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from soft_sim_ros.core.model.segments import Segment
from soft_sim_ros.scene import Basis, Rod, Scene

from .chain import Chain
from .element import Element

# of Scene: no part of the model, or looked at by itself
_APART = ("name", "initial", "source", "file", "bodies")


class SameShape(Chain):
    """A chain of the same shape as another one: it has the same segments.

    They hold geometry and trial functions; materials are in blocks and masses, made anew.
    """

    def __init__(self, other: Chain) -> None:
        super().__init__()
        self._segments = other.segments
        self._elements = [e for rod_map in other.rods.values() for e in rod_map.elements][::-1]

    def _fill(self, elements: list[Element], labels: list[str], basis: Basis) -> None:
        for element in elements:
            element.share(self._elements.pop())
        super()._fill(elements, labels, basis)

    def _step(self, element: Element, begin: float, end: float) -> Segment:
        return self._segments[self.node]


def differ_in_materials(one: Scene, two: Scene) -> bool:
    """Return whether two scenes have the same model but for the materials of rods."""
    return (
        all(_same(getattr(one, f.name), getattr(two, f.name)) for f in _parts(one, _APART))
        and len(one.bodies) == len(two.bodies)
        and all(_same_but_material(a, b) for a, b in zip(one.bodies, two.bodies, strict=True))
    )


def same_laws(one: Scene, two: Scene) -> bool:
    """Return whether the materials of rods have the same hyperelastic laws, if any."""
    laws = [
        [s.material.law for body in scene.bodies if isinstance(body, Rod) for s in body.sections]
        for scene in (one, two)
    ]
    return _same(laws[0], laws[1])


def _same_but_material(one: Any, two: Any) -> bool:
    if not (isinstance(one, Rod) and isinstance(two, Rod)):
        return _same(one, two)
    return (
        all(_same(getattr(one, f.name), getattr(two, f.name)) for f in _parts(one, ("sections",)))
        and len(one.sections) == len(two.sections)
        and all(
            _same(getattr(a, f.name), getattr(b, f.name))
            for a, b in zip(one.sections, two.sections, strict=True)
            for f in _parts(a, ("material",))
        )
    )


def _parts(value: Any, without: tuple[str, ...]) -> list[Any]:
    return [field for field in fields(value) if field.name not in without]


def _same(one: Any, two: Any) -> bool:
    """Return whether two parts of scenes say the same; in doubt they do not."""
    if one is two:
        return True
    if type(one) is not type(two):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == two.dtype and np.array_equal(one, two)
    if is_dataclass(one):
        return all(_same(getattr(one, f.name), getattr(two, f.name)) for f in fields(one))
    if isinstance(one, tuple | list):
        return len(one) == len(two) and all(map(_same, one, two))
    if isinstance(one, dict):
        return list(one) == list(two) and all(map(_same, one.values(), two.values()))
    return bool(one == two)
