"""The coordinates that a scene gives for its beginning, and where its nodes are then."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.quadrature import gauss
from soft_sim_ros.scene.initial import Initial

from .chain import Chain
from .element import EXTRA, Element


def given_coordinates(chain: Chain, initial: Initial) -> tuple[Floats, NDArray[np.bool_]]:
    """Return coordinates (n,) of the reference shape with what is given, and what joints are.

    Guesses are not given: an equilibrium finds these.
    """
    q, given = np.zeros(len(chain.names)), np.zeros(len(chain.names), dtype=bool)
    for name, value in initial.positions.items():
        columns = chain.columns(name)
        q[columns], given[columns] = value, True
    for name, value in initial.guesses.items():
        q[chain.columns(name)] = value
    for name, offset in initial.strains.items():
        rod, section = name.split("/")
        for element in chain.rods[rod].elements:
            if element.section.name == section:
                _impose(element, offset, q)
    return q, given


def _impose(element: Element, offset: Floats, q: Floats) -> None:
    """Set the coordinates of an element so that its strain is ξ₀ + offset throughout."""
    begin, end = element.span
    for columns in element.columns:
        component, first, count = columns
        s = begin + (end - begin) * gauss(element.density * (count + EXTRA))[0]
        phi = element.values(columns, s)
        solution = np.linalg.lstsq(phi, np.full(len(s), offset[component]), rcond=None)[0]
        used = np.any(phi != 0.0, axis=0)
        q[first : first + count][used] = solution[used]


def node_frames(chain: Chain, q: Floats) -> Floats:
    """Return the poses (nodes, 4, 4) of all nodes in the base frame."""
    poses = np.zeros((chain.node + 1, 4, 4))
    poses[0] = np.eye(4)
    for k, segment in enumerate(chain.segments):
        xi = np.array(segment.xi0, dtype=np.float64)
        for column, component, first, second in segment.entries:
            xi[:, component] += np.array([first, second]) * q[column]
        bracket = segment.kappa * (se3.ad(xi[0]) @ xi[1])
        poses[k + 1] = poses[segment.origin] @ se3.exp(segment.half * xi.sum(axis=0) + bracket)
    return poses
