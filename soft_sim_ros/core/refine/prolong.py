"""From one discretisation of a scene to a finer one: the model, and the states it has in both."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
from scipy import sparse

from soft_sim_ros.core.bases import ElementBasis, get_basis
from soft_sim_ros.core.compile.chain import Chain, RodMap
from soft_sim_ros.core.compile.element import Element
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.compile.shape import strain
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.quadrature import composite, gauss
from soft_sim_ros.scene import Free, Scene
from soft_sim_ros.scene.numerics import FIXED_ORDER

from .refinement import Refinement

_FINER: WeakKeyDictionary[Dynamics, dict[int, Dynamics]] = WeakKeyDictionary()
TURNING = ("torsion", "bend_y", "bend_z")
_MAPS: WeakKeyDictionary[Chain, WeakKeyDictionary[Chain, sparse.csr_matrix]] = WeakKeyDictionary()
ROUND_OFF = 1e-13
# A force of fixed direction, seen from sections that turn by θ along an element, goes like cos θ:
# polynomials show it from about degree θ/2 on, and nothing of it much below.
BEYOND, MOST_SHOWN = 3, 12


def finer(dynamics: Dynamics, turn: float = 0.0) -> Dynamics:
    """Return the same scene with a finer space, made once and remembered.

    Two more orders of every strain (twice the elements where orders are fixed), and half as many
    nodes again. Nothing else differs.

    turn : rad by which an element is turned at least; the more, the more orders it takes to see
        what is missing (the turn of the reference shape is known already)
    """
    compiled = dynamics.compiled
    least = shown(max(turn, reference_turn(compiled)))
    known = _FINER.setdefault(dynamics, {})
    if least not in known:
        known[least] = Dynamics(finer_scene(compiled.scene, least))
    known[least].carry(dynamics.attached)
    return known[least]


def finer_scene(scene: Scene, least: int = 0) -> Scene:
    """Return a scene in which only the space is finer; its source stays as it is.

    least : order that torsion and bending have at least
    """
    rules = Refinement(scene, 1e-3)  # the tolerance is for time, which is left alone
    numerics = rules.finer_space(scene.numerics)
    rods = {}
    for name, basis in numerics.rods.items():
        if basis.kind in FIXED_ORDER:
            rods[name] = basis
            continue
        order = {s: max(n, least) if s in TURNING else n for s, n in basis.order.items()}
        nodes = basis.nodes and max(basis.nodes, max(order.values(), default=0) + 5)
        rods[name] = replace(basis, order=order, nodes=nodes)
    numerics = rules.finer_nodes(replace(numerics, rods=rods))
    return replace(scene, numerics=replace(numerics, free=Free()), sensors=())


def shown(turn: float) -> int:
    """Return the order that shows what turns by so many rad along an element, in steps of two."""
    if turn < 1.0:
        return 0
    return min(MOST_SHOWN, 2 * math.ceil(0.5 * (0.5 * turn + BEYOND)))


def reference_turn(compiled: Compiled, q: Floats | None = None) -> float:
    """Return the largest turn in rad of an element in its reference shape, or bent by q (n,)."""
    most = 0.0
    for name, rod in compiled.chain.rods.items():
        for element in rod.elements:
            s = np.linspace(*element.span, 9)[1:-1]
            if q is None:
                field = element.section.strain0(element.normalised(s))
            else:
                field = strain(compiled, name, q, s)
            length = element.span[1] - element.span[0]
            most = max(most, length * float(np.linalg.norm(field[:, :3], axis=1).mean()))
    return most


def prolong(coarse: Compiled, fine: Compiled, q: Floats) -> Floats:
    """Return the coordinates that show in ``fine`` what q shows in ``coarse``.

    Exact where the strains of ``coarse`` are among those of ``fine``, as of `finer`; otherwise the
    nearest strains, ∫ |Δξ|² ds of every component and element. Joints and links are copied.

    Parameters
    ----------
    coarse, fine : two discretisations of one scene
    q : (…, n) coordinates; the map is linear, so rates and accelerations are mapped alike
    """
    return np.asarray((prolongation(coarse, fine) @ np.asarray(q, dtype=np.float64).T).T)


def prolongation(coarse: Compiled, fine: Compiled) -> sparse.csr_matrix:
    """Return the matrix of `prolong` (n of ``fine``, n of ``coarse``), made once and remembered."""
    known = _MAPS.setdefault(coarse.chain, WeakKeyDictionary())
    if fine.chain not in known:
        known[fine.chain] = _prolongation(coarse.chain, fine.chain)
    return known[fine.chain]


def _prolongation(coarse: Chain, fine: Chain) -> sparse.csr_matrix:
    out = sparse.lil_matrix((len(fine.names), len(coarse.names)))
    names = [*coarse.joints, *coarse.links]
    same = [(list(coarse.columns(name)), list(fine.columns(name))) for name in names]
    same += [(rod.pivot, fine.rods[name].pivot) for name, rod in coarse.rods.items()]
    for old, new in same:
        for i, j in zip(new, old, strict=True):
            out[i, j] = 1.0
    for name, rod in coarse.rods.items():
        for piece in _pieces(fine.rods[name]):
            _project(rod, piece, out)
    return sparse.csr_matrix(out)


def _pieces(rod: RodMap) -> Iterator[list[Element]]:
    """Give the elements of a rod, those with common coordinates together."""
    piece: list[Element] = []
    for element in rod.elements:
        if piece and element.columns != piece[0].columns:
            yield piece
            piece = []
        piece.append(element)
    if piece:
        yield piece


def _project(coarse: RodMap, piece: list[Element], out: sparse.lil_matrix) -> None:
    """Put the rows of a piece of the finer rod into ``out``."""
    begin, end = piece[0].span[0], piece[-1].span[1]
    slack = 1e-9 * coarse.length
    old = [e for e in coarse.elements if e.span[1] > begin + slack and e.span[0] < end - slack]
    if len(piece) == len(old) == 1 and _nested(old[0], piece[0]):
        for (_, i, count), (_, j, _) in zip(old[0].columns, piece[0].columns, strict=True):
            for k in range(count):
                out[j + k, i + k] = 1.0
        return
    marks = {mark for element in [*old, *piece] for mark in element.span}
    rising = [begin, *sorted(m for m in marks if begin + slack < m < end - slack), end]
    rising = [m for k, m in enumerate(rising) if k == 0 or m - rising[k - 1] > slack]
    for row, (component, first, count) in enumerate(piece[0].columns):
        most = max(count, *(element.columns[row][2] for element in old))
        s, w = composite(gauss(most + 1), rising)
        root = np.sqrt(w)[:, None]
        new_values = np.zeros((len(s), count))
        for element in piece:
            at = (s > element.span[0]) & (s < element.span[1])
            new_values[at] = element.values((component, first, count), s[at])
        for element in old:
            _, column, size = element.columns[row]
            at = (s > element.span[0]) & (s < element.span[1])
            values = np.zeros((len(s), size))
            values[at] = element.values(element.columns[row], s[at])
            found = np.linalg.lstsq(root * new_values, root * values, rcond=None)[0]
            found[np.abs(found) < ROUND_OFF * np.abs(found).max(initial=0.0)] = 0.0
            for i, j in zip(*np.nonzero(found), strict=True):
                out[first + i, column + j] += found[i, j]


def _nested(old: Element, new: Element) -> bool:
    """Whether the functions of an element are the first ones of another, on the same piece."""
    rule = get_basis(old.basis.kind)
    if old.basis.kind != new.basis.kind or not isinstance(rule, ElementBasis):
        return False
    if not np.allclose(old.span, new.span, rtol=0.0, atol=1e-12 * old.span[1]):
        return False
    t = np.linspace(-1.0, 1.0, 7)
    for name, order in old.basis.order.items():
        more = new.basis.order[name]
        if more < order:
            return False
        values = rule.values(more, t)[:, : rule.count(order)]
        if not np.allclose(values, rule.values(order, t), rtol=0.0, atol=1e-13):
            return False
    return True
