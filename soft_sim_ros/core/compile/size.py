"""Scenes that ask for more numbers than anybody waits for are refused before they are made."""

from __future__ import annotations

from soft_sim_ros.core.bases import ElementBasis, get_basis
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Basis, Rod, Scene

from .element import default_nodes

# Values of basis functions at the Gauss points of all segments: what a model mostly consists of,
# some 10 s of compilation and 0.6 GB.
MOST = 1_000_000
FULL = 25  # entries of a full matrix that cost as much as one of these values


def refuse_size(scene: Scene) -> None:
    """Refuse a scene whose elements and orders are too many together.

    Raises
    ------
    SceneError
        which names the rod with the most
    """
    sizes = {
        body.name: _size(body, scene.numerics.rods[body.name])
        for body in scene.bodies
        if isinstance(body, Rod)
    }
    if sum(sizes.values()) <= MOST:
        return
    worst = max(sizes, key=lambda name: sizes[name])
    basis = scene.numerics.rods[worst]
    orders = max(basis.order.values(), default=0)
    total = sum(sizes.values())
    value = f"{basis.elements} elements per section, order {orders}"
    expected = (
        f"fewer elements or lower orders: all rods of the scene have {total:,} values of basis "
        f"functions, at most {MOST:,} are computed"
    )
    raise SceneError(scene.file, f"numerics.rods.{worst}", value, expected)


def _size(rod: Rod, basis: Basis) -> int:
    """Return how many values of basis functions a rod has at least."""
    rule = get_basis(basis.kind)
    nodes = basis.nodes or default_nodes(basis.order)
    segments = (nodes - 1) * basis.elements * len(rod.sections)
    if not isinstance(rule, ElementBasis):
        # two functions of each strain at a place, but full matrices of all of a section
        coordinates = len(rod.strains) * (basis.elements + 1)
        return max(2 * len(rod.strains) * segments, coordinates**2 // FULL)
    return segments * sum(rule.count(basis.order[strain]) for strain in rod.strains)
