"""Coarser and finer numerics of a scene: steps in time, elements and orders, nodes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

from soft_sim_ros.core.compile.outline import Outline
from soft_sim_ros.core.compile.scene import build_chain
from soft_sim_ros.scene import Basis, Free, Numerics, Rod, Scene
from soft_sim_ros.scene.numerics import FIXED_ORDER, NODES
from soft_sim_ros.scene.put import edited

# First guesses, over the tolerance τ. Runs end up to 8 times further off than one of their steps
# may; a clamped arm that bends by a right angle is off by 1e-4 with 9 segments (order four).
STEP_ERROR, SEGMENTS = 0.04, 1.3
FINER_STEP, FINER_ORDER, FINER_NODES = 0.1, 2, 1.5
LEAST_ERROR, MOST_NODES, MOST_ELEMENTS = 1e-12, int(NODES.high), 256
SPLIT = 6  # an element that would need a higher order is split instead, where it may be
MOST_ORDER = 20
BENDING = ("bend_y", "bend_z")


class Refinement:
    """What may be chosen for a scene, and what finer means.

    Parameters
    ----------
    scene : its numerics say what is free
    tolerance : of the tip's position over the length
    """

    def __init__(self, scene: Scene, tolerance: float) -> None:
        self._scene, self._tolerance = scene, tolerance
        self.free: Free = scene.numerics.free
        self._known: dict[str, dict[str, tuple[int, int]]] = {}

    def first(self) -> Numerics:
        """Return the first guess."""
        numerics = self._scene.numerics
        order = max(1, min(SPLIT, round(-math.log10(self._tolerance))))
        rods = dict(numerics.rods)
        for name, sections in self._sections().items():
            basis = rods[name]
            if name in self.free.order:
                bending = max(1, order - round(math.log2(sections)))
                lower = {"torsion": bending - 1} | dict.fromkeys(BENDING, bending)
                orders = {
                    strain: min(self._most_order(name), max(0, lower.get(strain, bending - 2)))
                    for strain in basis.order
                }
                rods[name] = replace(basis, order=orders)
        numerics = replace(numerics, rods=rods)
        if self.free.time:
            error = min(0.1, STEP_ERROR * self._tolerance)
            numerics = replace(numerics, integrator="adaptive", options={"error": error})
        segments = 9.0 * (1e-4 / (0.2 * self._tolerance)) ** 0.25
        wanted = {name: segments / k for name, k in self._sections().items()}
        return self._chosen(numerics, wanted)

    def finer(self, numerics: Numerics) -> Numerics:
        """Return the companion of a choice, whatever is free in it."""
        return self.finer_time(self.finer_nodes(self.finer_space(numerics)))

    def finest(self, numerics: Numerics) -> Numerics:
        """Return the companion of the companion: with its elements cut in two.

        Where the shape has a narrow layer, more elements show more than more orders do.
        """
        finer = self.finer(numerics)
        segments = self._segments(finer)
        halves = {name: replace(b, elements=2 * b.elements) for name, b in finer.rods.items()}
        wanted = {name: FINER_NODES * k for name, k in segments.items()}
        split = self._with_nodes(replace(finer, rods=halves), halves, wanted)
        return self.finer_time(split)

    def finer_time(self, numerics: Numerics) -> Numerics:
        """Return a choice with a tenth of the error in time."""
        error = numerics.options.get("error", STEP_ERROR * self._tolerance)
        error = max(LEAST_ERROR, FINER_STEP * min(error, STEP_ERROR * self._tolerance))
        return replace(numerics, integrator="adaptive", options={"error": error})

    def finer_space(self, numerics: Numerics) -> Numerics:
        """Return a choice with two more orders, or twice as many elements if orders are fixed."""
        rods = {}
        for name, basis in numerics.rods.items():
            if basis.kind in FIXED_ORDER:
                rods[name] = replace(basis, elements=2 * basis.elements)
            else:
                orders = {strain: order + FINER_ORDER for strain, order in basis.order.items()}
                rods[name] = replace(basis, order=orders)
        return self._with_nodes(replace(numerics, rods=rods), rods, self._segments(numerics))

    def finer_nodes(self, numerics: Numerics) -> Numerics:
        """Return a choice with half as many segments again."""
        segments = {name: FINER_NODES * k for name, k in self._segments(numerics).items()}
        return self._with_nodes(numerics, numerics.rods, segments)

    def more_time(self, numerics: Numerics, excess: float) -> Numerics:
        """Return a choice with a smaller error in time; excess: over the permitted error."""
        if not self.free.time:
            return numerics
        error = numerics.options["error"] * max(0.01, 0.7 / max(excess, 1.4))
        return replace(numerics, options={"error": max(LEAST_ERROR, error)})

    def more_nodes(self, numerics: Numerics, excess: float) -> Numerics:
        """Return a choice with more nodes: their error falls with the fourth power."""
        factor = min(2.5, max(1.1, 1.05 * excess**0.25))
        return self._chosen(
            numerics, {name: factor * k for name, k in self._segments(numerics).items()}
        )

    def more_space(
        self, numerics: Numerics, top: Mapping[tuple[str, str], float], slow: bool = False
    ) -> Numerics:
        """Return a choice with more orders, or elements, for the strains that need them.

        top : (rod, strain) → what two more orders would move, over what is permitted
        slow : more orders gained little; elements may do better
        """
        freed = {
            key: way for key, way in top.items() if key[0] in self.free.order | self.free.elements
        }
        if not freed:
            return numerics
        most = max(freed.values())
        least = max(min(0.5, most), 0.03 * most)
        needy = {key: 2 if way > 20.0 else 1 for key, way in freed.items() if way >= least}
        rods, kept = dict(numerics.rods), self._segments(numerics)
        for name in sorted({rod for rod, _ in needy}):
            basis, most = rods[name], self._most_order(name)
            more = {s: o + needy.get((name, s), 0) for s, o in basis.order.items()}
            splits = slow or name not in self.free.order or max(more.values()) > min(SPLIT, most)
            if splits and name in self.free.elements and basis.elements < MOST_ELEMENTS:
                if name in self.free.order:
                    more = {s: min(order, SPLIT - 1, most) for s, order in more.items()}
                else:
                    more = basis.order
                rods[name] = replace(basis, elements=2 * basis.elements, order=more)
            elif name in self.free.order:
                rods[name] = replace(basis, order={s: min(o, most) for s, o in more.items()})
        return self._chosen(replace(numerics, rods=rods), kept)

    def all_finer(self, numerics: Numerics) -> Numerics:
        """Return a choice that is finer in everything that is free."""
        every = {(name, s): 1.0 for name, basis in numerics.rods.items() for s in basis.order}
        return self.more_nodes(self.more_space(self.more_time(numerics, 10.0), every), 5.0)

    def _sections(self) -> dict[str, int]:
        rods = (body for body in self._scene.bodies if isinstance(body, Rod))
        return {rod.name: len(rod.sections) for rod in rods}

    def _most_order(self, name: str) -> int:
        """Return the highest order that a rod may get: written nodes carry so many only."""
        nodes = self._scene.numerics.rods[name].nodes
        return MOST_ORDER if nodes is None else min(MOST_ORDER, nodes - 2)

    def _counts(self, numerics: Numerics) -> dict[str, tuple[int, int]]:
        """Return the nodes per element that each rod needs at least, and those it gets by itself.

        The largest of all its elements; the reference shape has a part in both.
        """
        rods = {name: replace(basis, nodes=None) for name, basis in numerics.rods.items()}
        key = repr(rods)
        if key not in self._known:
            scene = replace(self._scene, numerics=replace(numerics, rods=rods))
            chain = build_chain(scene, Outline())
            self._known[key] = {
                name: (
                    max(element.least_nodes for element in rod.elements),
                    max(element.nodes for element in rod.elements),
                )
                for name, rod in chain.rods.items()
            }
        return self._known[key]

    def _segments(self, numerics: Numerics) -> dict[str, float]:
        """Return the segments per section of each rod."""
        if all(basis.nodes is not None for basis in numerics.rods.values()):
            nodes = {name: basis.nodes or 0 for name, basis in numerics.rods.items()}
        else:
            counts = self._counts(numerics)
            nodes = {name: b.nodes or counts[name][1] for name, b in numerics.rods.items()}
        return {name: float(b.elements * (nodes[name] - 1)) for name, b in numerics.rods.items()}

    def _chosen(self, numerics: Numerics, segments: Mapping[str, float]) -> Numerics:
        """Return numerics with so many segments per section, or more, where nodes are free.

        A scene may write MOST_NODES: where an element needs more it is cut in two. Where it must
        not be cut, its nodes are automatic, if those are more.
        """
        free = self.free
        while True:
            wanted = self._with_nodes(numerics, free.nodes, segments)
            full = {
                name
                for name in free.nodes & free.elements
                if (wanted.rods[name].nodes or 0) > MOST_NODES
                and wanted.rods[name].elements < MOST_ELEMENTS
            }
            if not full:
                break
            rods = dict(numerics.rods)
            for name in full:
                rods[name] = replace(rods[name], elements=2 * rods[name].elements)
            numerics = replace(numerics, rods=rods)
        rods = dict(wanted.rods)
        for name in free.nodes:
            if (rods[name].nodes or 0) > MOST_NODES:
                automatic = self._counts(wanted)[name][1]
                rods[name] = replace(
                    rods[name], nodes=None if automatic > MOST_NODES else MOST_NODES
                )
        return replace(wanted, rods=rods)

    def _with_nodes(
        self, numerics: Numerics, rods: Iterable[str], segments: Mapping[str, float]
    ) -> Numerics:
        """Return numerics in which some rods have so many segments per section, or more."""
        counts, bases = self._counts(numerics), dict(numerics.rods)
        for name in rods:
            basis: Basis = bases[name]
            nodes = 1 + math.ceil(segments[name] / basis.elements - 1e-9)
            bases[name] = replace(basis, nodes=max(counts[name][0], nodes))
        return replace(numerics, rods=bases)


def source_with(scene: Scene, numerics: Numerics) -> str:
    """Return the text of a scene in which the numerics stand that were left free in it."""
    free, values = scene.numerics.free, {}
    if free.time:
        values["numerics.integrator"] = numerics.integrator
        values["numerics.options.error"] = repr(numerics.options["error"])
    for name, basis in numerics.rods.items():
        at = f"numerics.rods.{name}"
        if name in free.order:
            values[f"{at}.order"] = str(basis.order).replace("'", "")
        if name in free.elements:
            values[f"{at}.elements"] = str(basis.elements)
        if name in free.nodes:
            values[f"{at}.nodes"] = str(basis.nodes or "auto")
    return edited(scene.source, scene.file, values)


def words(numerics: Numerics) -> str:
    """Say a choice in words."""
    said = []
    for name, basis in numerics.rods.items():
        orders = ", ".join(f"{strain} {order}" for strain, order in basis.order.items())
        elements = f"{basis.elements} elements, " if basis.elements > 1 else ""
        nodes = "" if basis.nodes is None else f", {basis.nodes} nodes"
        said.append(f"{name}: {elements}orders {orders}{nodes}")
    error = numerics.options.get("error")
    steps = f"{numerics.integrator}, steps of {numerics.step:g} s"
    return "; ".join([*said, steps if error is None else f"error of a step {error:.2g}"])
