"""The internal wrench of every section along the arm, with its jumps at concentrated loads.

The recursion knows the sum of inertial minus external wrenches from each node to the tip, loads
and masses lumped at the nodes. Within an element their density is a polynomial through the nodes;
its integral replaces the steps of the lumped sums and agrees with them at the ends of the element.
Only concentrated wrenches remain as jumps: point loads and rigid bodies.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.compile.element import Element
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data, origins
from soft_sim_ros.core.quadrature import antiderivative, lobatto
from soft_sim_ros.core.recursion.rnea import place
from soft_sim_ros.scene import DistributedLoad

from .fluid import densities


class InternalWrench(NamedTuple):
    """The wrench Λ = (M; N) in N·m and N of the part beyond a section on the part before it.

    ``before`` and ``after`` are its limits on both sides of every node, in the node's own frame;
    where branches leave, ``after`` is the sum over all of them. The limits differ where a wrench is
    concentrated: after − before = the inertial minus the applied wrench there. What the ground does
    to the arm is −before[0], what is held at the tip of a chain is before[-1].

    s : (N,) arc length of the nodes from the base along the rods between in m; joints and rigid
        bodies have none
    before, after : (N, 6)
    """

    s: Floats
    before: Floats
    after: Floats


def internal_wrench(compiled: Compiled, data: Data, time: float) -> InternalWrench:
    """Return the result of ``Dynamics.internal_wrench`` from the last recursion in ``data``."""
    place(compiled.model, data)
    rotation, position = data.rotation.reshape(-1, 3, 3), data.position
    total = _to_base(data.wrench, rotation, position)
    point = total.copy()
    begins = origins(compiled.model)
    for k, p in enumerate(begins):
        point[p] -= total[k + 1]
    ends: dict[int, tuple[int, Floats]] = {}
    wet = densities(compiled, data) if compiled.scene.fluid else {}
    for rod_map in compiled.chain.rods.values():
        for element in rod_map.elements:
            count = element.nodes
            first, last = element.first_segment, element.first_segment + count - 1
            at = slice(first, last + 1)
            density = _density(compiled, data, rod_map.rod.name, element, at, time)
            density += wet.get(first, 0.0)
            density = _to_base(density, rotation[at], position[at])
            length = element.span[1] - element.span[0]
            x, weights = lobatto(count)
            point[at] -= length * weights[:, None] * density
            whole = weights @ density
            ends[last] = first, length * (whole - antiderivative(x) @ density)
    before, after = np.zeros_like(total), np.zeros_like(total)
    node = len(total) - 1
    while node >= 0:
        before[node] = after[node] - point[node]
        if node in ends:
            first, beyond = ends[node]
            inside = before[node] - beyond[:-1]
            before[first + 1 : node] = after[first + 1 : node] = inside[1:]
            after[first] += inside[0]
            node = first
        elif node > 0:
            after[begins[node - 1]] += before[node]
            node -= 1
        else:
            break
    s = np.zeros(len(total))
    for k, (p, segment) in enumerate(zip(begins, compiled.chain.segments, strict=True)):
        s[k + 1] = s[p] + (segment.span[1] - segment.span[0])
    return InternalWrench(
        s,
        _to_section(before, rotation, position),
        _to_section(after, rotation, position),
    )


def _density(
    compiled: Compiled, data: Data, rod: str, element: Element, at: slice, time: float
) -> Floats:
    """Return inertial minus external wrench per length (nodes, 6), in section axes."""
    begin, end = element.span
    s = begin + (end - begin) * lobatto(element.nodes)[0]
    # mass and principal moments as factors of M and N
    spread = [1, 2, 3, 0, 0, 0]
    inertia = element.section.inertia(element.normalised(s))[:, spread]
    damping = element.section.mass_damping(element.normalised(s))[:, spread]
    eta, acc = data.eta[at], data.acc[at]
    out: Floats = inertia * acc + damping * eta
    out[:, :3] += np.cross(eta[:, :3], inertia[:, :3] * eta[:, :3])
    out[:, 3:] += inertia[:, 3:] * np.cross(eta[:, :3], eta[:, 3:])
    rotation = data.rotation[at].reshape(-1, 3, 3)
    for load in compiled.scene.loads:
        if isinstance(load, DistributedLoad) and load.body == rod:
            if load.start < 0.5 * (begin + end) < load.end:
                wrench = load.schedule.factor(time) * np.concatenate([load.moment, load.force])
                if load.frame == "world":
                    wrench = _turned_back(compiled.to_base(wrench), rotation)
                out -= wrench
    return out


def _turned_back(wrench: Floats, rotation: Floats) -> Floats:
    """Return a wrench (6,) along base axes in the axes of frames (N, 3, 3)."""
    return np.concatenate([wrench[:3] @ rotation, wrench[3:] @ rotation], axis=1)


def _to_base(wrench: Floats, rotation: Floats, position: Floats) -> Floats:
    """Return wrenches (N, 6) on frames as wrenches about the origin, along base axes."""
    moment = np.einsum("kij,kj->ki", rotation, wrench[:, :3])
    force = np.einsum("kij,kj->ki", rotation, wrench[:, 3:])
    return np.concatenate([moment + np.cross(position, force), force], axis=1)


def _to_section(wrench: Floats, rotation: Floats, position: Floats) -> Floats:
    """Invert ``_to_base``."""
    moment = wrench[:, :3] - np.cross(position, wrench[:, 3:])
    rows = [np.einsum("kji,kj->ki", rotation, x) for x in (moment, wrench[:, 3:])]
    return np.concatenate(rows, axis=1)
