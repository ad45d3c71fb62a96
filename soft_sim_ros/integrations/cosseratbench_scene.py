"""Scenes of the rods of cosseratbench's scenarios."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from cosseratbench.scenario import End, EndCondition, Rod, Scenario

if TYPE_CHECKING:
    from soft_sim_ros.core.floats import Floats

    from ..scene import Scene

ORDER = 3  # of the strains in an element
PER_ELEMENT = 10  # pieces that the benchmark asks for in one element of ours
CLAMPED = 3.516  # ω √(ρA/EI) L² of a cantilever's slowest mode


def elements(n_elements: int) -> int:
    """Return how many elements stand for the pieces that the benchmark asks for."""
    return max(2, n_elements // PER_ELEMENT)


def scene_of(scenario: Scenario, rod: Rod, n_elements: int, interval: float, error: float) -> Scene:
    """Return the scene of one rod: straight at rest, held at the start, loaded at its end."""
    import yaml
    from scipy.spatial.transform import Rotation

    from ..scene import parse_scene

    begin = rod.nodes(max(n_elements, 50))
    turn = Rotation.from_matrix(frame(begin[:3], rod.directors(max(n_elements, 50))[0]))
    material: dict[str, Any] = {
        "young_modulus": rod.material.youngs_modulus, "shear_modulus": rod.material.shear_modulus,
        "density": rod.material.density,
    }  # fmt: skip
    section = {
        "name": "whole", "length": rod.length, "material": "given",
        "cross_section": {"shape": "circle", "radius": rod.radius},
    }  # fmt: skip
    bodies: list[dict[str, Any]] = [{"rod": "rod", "sections": [section]}]
    if rod.start is EndCondition.PINNED:
        axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        bodies.insert(0, {"joint": "pin", "kind": "universal", "axes": axes})
    document: dict[str, Any] = {
        "gravity": list(scenario.gravity),
        "base": {"position": begin[0].tolist(), "quaternion": turn.as_quat().tolist()},
        "materials": {"given": material},
        "bodies": bodies,
        "loads": [
            {"point": f"load{k}", "body": "rod", "force": list(load.force),
             "s": rod.length if load.at is End.END else 0.0}
            for k, load in enumerate(rod.loads)
        ],
        "numerics": {
            "step": round(interval * 1e9) / 1e9, "integrator": "adaptive",
            "options": {"error": error},
            "basis": {"order": ORDER, "elements": elements(n_elements)},
        },
    }  # fmt: skip
    if rod.end is EndCondition.CLAMPED:
        document |= held_end(rod, turn)
        bodies.append(document.pop("driver"))
        if scenario.quasi_static:
            material["rayleigh"] = {"mass": mass_damping(scenario, rod)}
    return parse_scene(yaml.safe_dump(document), "scenario.yaml")


def frame(nodes: Floats, across: Floats) -> Floats:
    """Return the axes (3, 3) of a centre line at the first of three nodes (3, 3), in columns.

    A piece has the direction of its middle: half a piece further out it is 3/2 of the first less
    1/2 of the second.
    """
    first, second = np.diff(nodes, axis=0)
    along = 1.5 * first - 0.5 * second
    along /= np.linalg.norm(along)
    upright = across - (across @ along) * along
    upright /= np.linalg.norm(upright)
    return np.array([along, upright, np.cross(along, upright)]).T


def mass_damping(scenario: Scenario, rod: Rod) -> float:
    """Return the damping by mass in 1/s that is critical for the slowest mode of a cantilever."""
    if not scenario.quasi_static:
        return 0.0
    stiff = rod.material.youngs_modulus * rod.second_moment_of_area
    per_length = rod.material.density * rod.area
    return float(2.0 * CLAMPED * np.sqrt(stiff / per_length) / rod.length**2)


def held_end(rod: Rod, base: Any) -> dict[str, Any]:
    """Return a ``driver`` that moves as the end is told, and the constraint that holds it there.

    base : the Rotation of the rod's start
    """
    from scipy.spatial.transform import Rotation

    pieces = max(50, len(rod.centerline) - 1)
    nodes = rod.nodes(pieces)
    backwards = frame(nodes[:-4:-1], rod.directors(pieces)[-1])
    end = Rotation.from_matrix(backwards * [-1.0, 1.0, -1.0])
    joint: dict[str, Any] = {
        "joint": "driver", "kind": "fixed", "parent": "base",
        "offset": {
            "position": base.inv().apply(nodes[-1] - nodes[0]).tolist(),
            "quaternion": (base.inv() * end).as_quat().tolist(),
        },
    }  # fmt: skip
    motion, constraint = rod.end_motion, dict[str, Any](name="far_end", kind="weld")
    if motion is not None and (np.any(motion.displacement) or np.any(motion.rotation)):
        moved = [end.inv().apply(row) for row in (motion.displacement, motion.rotation)]
        joint |= {"kind": "free", "driven": {}}
        for label, column in zip(
            ("x", "y", "z", "rx", "ry", "rz"), np.hstack(moved).T, strict=True
        ):
            if column.any():
                rows = np.column_stack([motion.times, column])
                joint["driven"][label] = {"table": rows.tolist()}
    if motion is not None and motion.slides_along is not None:
        constraint |= {"kind": "slider", "axis": end.inv().apply(motion.axis).tolist()}
    constraint["frames"] = [{"body": "rod"}, {"body": "driver"}]
    return {"driver": joint, "constraints": [constraint]}
