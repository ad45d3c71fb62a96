"""Actuators of a scene as the arrays of ports and paths in model.py."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.quadrature import gauss, scattered
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import ChamberActuator, JointActuator, MomentActuator, Scene, TendonActuator
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.tendon import Stretch

from .chain import Chain

GAUSS2 = gauss(2)[0]
# A path may wind by this much in rad between neighbouring nodes: two Gauss points then see its
# length to a few parts in ten thousand.
WINDING = 1.3
# A wrap below this angle in rad, over the whole path, is rounded off (terms/tendons.py: wrap).
STRAIGHT = 1e-3

Path = TendonActuator | ChamberActuator


def flat_ports(scene: Scene, chain: Chain) -> dict[str, NDArray[Any]]:
    """Return the fields of Model for the actuators.

    Raises
    ------
    SceneError
        if a path winds too fast for the nodes of its rod
    """
    actuators = scene.actuators
    ports = [_port(chain, actuator) for actuator in actuators]
    paths = [_path(chain, actuator) for actuator in actuators]
    for i, actuator in enumerate(actuators):
        if isinstance(actuator, Path):
            _check_winding(scene, chain, i, actuator)
    rest = floats([_rest_length(chain, path) for path in paths])
    # a tendon stretches over its whole length, also over the fixed pieces between its rods
    whole = rest + [_between(chain, actuator) for actuator in actuators]
    friction, length_control = np.zeros((len(actuators), 3)), np.zeros((len(actuators), 2))
    gain, columns = np.zeros(len(actuators)), [0]
    for i, actuator in enumerate(actuators):
        count = 0
        if isinstance(actuator, ChamberActuator):
            gain[i] = actuator.area
        if isinstance(actuator, TendonActuator):
            gain[i] = -1.0
            length_control[i] = (
                actuator.axial_stiffness / whole[i],
                actuator.axial_damping / whole[i],
            )
            count += actuator.control == "length"
            if actuator.friction:
                friction[i] = actuator.friction, actuator.slip_speed, STRAIGHT / rest[i]
                count += 2 * (_blocks(chain, paths[i]) - 1)
        columns.append(columns[-1] + count)
    return {
        "port_ptr": ints([0, *np.cumsum([len(p) for p in ports])]),
        "port_col": ints([column for p in ports for column, _ in p]),
        "port_gain": floats([factor for p in ports for _, factor in p]),
        "tendon_ptr": ints([0, *np.cumsum([len(path) for path in paths])]),
        "tendon_seg": ints([k for path in paths for k, _ in path]),
        "tendon_path": floats([d for path in paths for _, d in path]).reshape(-1, 2, 3, 3),
        "tendon_rest": rest,
        "tendon_gain": gain,
        "length_control": length_control,
        "friction": friction,
        "couple_ptr": ints(columns),
    }


def _port(chain: Chain, actuator: object) -> list[tuple[int, float]]:
    """Return (coordinate, gain) of the linear part of an actuator's position."""
    if isinstance(actuator, JointActuator):
        return [(chain.joints[actuator.joint][actuator.axis], 1.0)]
    if not isinstance(actuator, MomentActuator):
        return []
    gains: dict[int, float] = {}
    component = STRAINS.index(actuator.strain)
    for element in chain.rods[actuator.rod].elements:
        if element.section.name != actuator.section:
            continue
        begin, end = element.span
        for columns in element.columns:
            if columns[0] == component:
                x, w = gauss(element.density * (columns[2] + 1))
                integral = (end - begin) * w @ element.values(columns, begin + (end - begin) * x)
                for j, value in enumerate(integral):
                    gains[columns[1] + j] = gains.get(columns[1] + j, 0.0) + value
    # integrals that vanish by orthogonality are round-off
    largest = max((abs(v) for v in gains.values()), default=0.0)
    return [(c, v) for c, v in gains.items() if abs(v) > 1e-14 * largest]


def _path(chain: Chain, actuator: object) -> list[tuple[int, Floats]]:
    """Return (segment, path (2, 3, 3)) for every segment along a tendon or chamber.

    The path is [Gauss point][d, d', d''] in the section frame, in m, 1 and 1/m.
    """
    if not isinstance(actuator, Path):
        return []
    pieces = []
    for stretch in actuator.stretches:
        for k, segment in chain.rod_segments(chain.rods[stretch.rod]):
            begin, end = segment.span
            if stretch.start < 0.5 * (begin + end) < stretch.end:
                s = begin + (end - begin) * GAUSS2
                rows = [stretch.offset(s), stretch.slope(s), stretch.curvature(s)]
                pieces.append((k, np.stack(rows, axis=1)))
    return pieces


def _between(chain: Chain, actuator: object) -> float:
    """Return the length in m of the straight pieces of a path from rod to rod, which is fixed."""
    if not isinstance(actuator, Path):
        return 0.0
    total = 0.0
    for one, other in itertools.pairwise(actuator.stretches):
        pose = np.eye(4)
        for k in range(chain.rods[one.rod].last_node, chain.rods[other.rod].first_node):
            pose = pose @ se3.exp(chain.segments[k].xi0[0])
        ahead = pose[:3, :3] @ other.offset(np.array(other.start)) + pose[:3, 3]
        total += float(np.linalg.norm(ahead - one.offset(np.array(one.end))))
    return total


def _rest_length(chain: Chain, path: list[tuple[int, Floats]]) -> float:
    """Return the length of a path through the reference shape in m, by the kernels' quadrature."""
    total = 0.0
    for k, points in path:
        segment = chain.segments[k]
        for xi, (d, slope, _) in zip(segment.xi0, points, strict=True):
            total += segment.half * float(np.linalg.norm(xi[3:] + np.cross(xi[:3], d) + slope))
    return total


def _blocks(chain: Chain, path: list[tuple[int, Floats]]) -> int:
    """Return how many blocks of coordinates a path passes."""
    starts = [block.first_segment for block in chain.blocks]
    return len({int(np.searchsorted(starts, k, side="right")) for k, _ in path})


def winding(stretch: Stretch, s: Floats) -> Floats:
    """Return by how much a path winds about the backbone at arc lengths s (N,), rad/m.

    Close to the axis a path may turn fast and move little; there its displacement counts, not its
    angle.
    """
    d, slope = stretch.offset(s)[:, 1:], stretch.slope(s)[:, 1:]
    reach = np.maximum(np.linalg.norm(d, axis=1), 0.1 * np.linalg.norm(d, axis=1).max() + 1e-150)
    return np.asarray(np.abs(d[:, 0] * slope[:, 1] - d[:, 1] * slope[:, 0]) / reach**2)


def _check_winding(scene: Scene, chain: Chain, index: int, actuator: Path) -> None:
    """Refuse a path that winds about the backbone too fast for the spacing of the nodes."""
    segments = [
        (stretch, segment.span)
        for stretch in actuator.stretches
        for _, segment in chain.rod_segments(chain.rods[stretch.rod])
        if stretch.start < 0.5 * sum(segment.span) < stretch.end
    ]
    for stretch, (begin, end) in segments:
        turn = float(winding(stretch, scattered(begin, end, 9)).mean()) * (end - begin)
        if turn > WINDING:
            kind = "chamber" if isinstance(actuator, ChamberActuator) else "tendon"
            expected = (
                f"a path that winds by less than {WINDING:g} rad from node to node, here {turn:.3g}"
                f" (more nodes or elements in numerics.rods.{stretch.rod} resolve it)"
            )
            raise SceneError(scene.file, f"actuators[{index}].{kind}", actuator.name, expected)
