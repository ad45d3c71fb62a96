"""Stations of hyperelastic sections: Gauss points along rods, fibres across, to integrate W."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.model.model import Fibres
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.quadrature import composite, gauss
from soft_sim_ros.scene.law import Law, Rivlin

from .chain import Chain
from .element import EXTRA, Element

COMPONENTS = 4  # torsion, bending, stretch: shear stays linear


def flatten_fibres(chain: Chain, seg_block: Ints) -> Fibres:
    """Return the stations of all elements whose material has a law."""
    laws: list[Law] = []
    entries: list[tuple[int, int, float]] = []
    entry_ptr, ptr, block, law = [0], [0], [], []
    points: list[Floats] = [np.zeros((0, 4))]
    for element in (e for rod_map in chain.rods.values() for e in rod_map.elements):
        material = element.section.material
        columns = [c for c in element.columns if c[0] < COMPONENTS]
        if material.law is None or not columns:
            continue
        if material.law not in laws:
            laws.append(material.law)
        for at, length, phi in _stations(element, columns):
            entries += phi
            entry_ptr.append(len(entries))
            rule = element.section.fibres(element.normalised(np.array(at)))
            rule[:, 2] *= length
            points.append(rule)
            ptr.append(ptr[-1] + len(rule))
            block.append(seg_block[element.first_segment])
            law.append(laws.index(material.law))
    rows, knots = _laws(laws)
    return Fibres(
        entry_ptr=ints(entry_ptr),
        entry_col=ints([e[0] for e in entries]),
        entry_comp=ints([e[1] for e in entries]),
        entry_phi=floats([e[2] for e in entries]),
        block=ints(block),
        law=ints(law),
        ptr=ints(ptr),
        points=floats(np.concatenate(points)),
        laws=rows,
        knots=knots,
    )


def _stations(
    element: Element, columns: list[tuple[int, int, int]]
) -> list[tuple[float, float, list[tuple[int, int, float]]]]:
    """Return arc length, weight in m and entries of the Gauss points of an element."""
    begin, end = element.span
    rule = gauss(element.density * (max(c[2] for c in columns) + EXTRA))
    s, w = composite(rule, element.marks(begin, end))
    values = [(c, element.values(c, s)) for c in columns]
    return [
        (
            s[i],
            w[i],
            [(c[1] + j, c[0], phi[i, j]) for c, phi in values for j in range(c[2]) if phi[i, j]],
        )
        for i in range(len(s))
    ]


def _laws(laws: list[Law]) -> tuple[Floats, Floats]:
    """Return the laws (L, 9) and the knots (N, 6) of those that are curves."""
    rows, knots = np.zeros((len(laws), 9)), [np.zeros((0, 6))]
    count = 0
    for row, law in zip(rows, laws, strict=True):
        row[:2], row[6] = law.span, law.shear_modulus
        if isinstance(law, Rivlin):
            row[2:6] = law.c10, law.c01, law.c20, law.c30
        else:
            pieces = [law.breaks[:-1, None], law.energies()[:, None], law.coefficients]
            knots.append(np.concatenate(pieces, axis=1))
            row[7:] = count, count + len(knots[-1])
            count += len(knots[-1])
    return floats(rows), floats(np.concatenate(knots))
