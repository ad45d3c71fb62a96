"""Kinds of scenes on which a companion may be hardly better than the run: physics only.

Boundary layers of thin rods under tension, features of the data that are narrower than any node,
wave fronts without damping, runs that publish seldom, and motion that forgets where it began. Each
is a small scene and a run of it; ``outcome`` is what is right for it, where not a kept tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.accuracy.drive import Drive
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import Free, Scene, parse_scene


@dataclass(frozen=True, eq=False)
class Kind:
    """A scene without numerics, and a run of it.

    name, kind : of the case, and of what is hard about it
    document : the scene
    duration, step : s
    fine : basis of the reference
    error : of a step of the reference
    exact : the tip (T, 3) in m at times (T,) in s, where there is a closed form
    tolerances : asked for
    every : steps between two published states; the tip is compared at all steps
    """

    name: str
    kind: str
    document: dict[str, Any]
    duration: float
    step: float
    fine: dict[str, Any]
    every: int = 1
    tolerances: tuple[float, ...] = (1e-2, 1e-3)
    error: float = 1e-10
    exact: Callable[[Floats], Floats] | None = None

    def drive(self) -> Drive:
        """Return the run: nothing is commanded."""
        actuators = len(self.document.get("actuators", []))
        last = round(self.duration / self.step)
        return Drive(np.zeros(0, dtype=np.int64), np.zeros((0, actuators)), last, self.every)

    def scene(self, tolerance: float) -> Scene:
        """Return the scene that asks for a tolerance."""
        return self._parsed({"step": self.step, "tolerance": tolerance})

    def fine_scene(self, **other: Any) -> Scene:
        """Return the scene with numerics far finer than any choice."""
        basis = self.fine | other
        numerics = {"step": self.step, "integrator": "adaptive", "options": {"error": self.error}}
        scene = self._parsed(numerics | {"basis": basis})
        return replace(scene, numerics=replace(scene.numerics, free=Free()))

    def reference(self) -> tuple[Floats, float]:
        """Return the tip (steps + 1, 3) in m, and how far two references are apart, in m."""
        drive = replace(self.drive(), every=1)
        if self.exact is not None:
            return self.exact(self.step * np.arange(drive.last + 1)), 0.0
        one = drive.tip(Simulation(self.fine_scene()))
        orders = {"kind": "chebyshev", "order": self.fine["order"] - 1}
        two = drive.tip(Simulation(self.fine_scene(**orders)))
        return one, float(np.linalg.norm(one - two, axis=1).max())

    def _parsed(self, numerics: dict[str, Any]) -> Scene:
        return parse_scene(yaml.safe_dump(self.document | {"numerics": numerics}), self.name)


def rod(
    length: float,
    strains: list[str],
    section: dict[str, Any],
    viscosity: float = 0.0,
    gravity: tuple[float, ...] = (0.0, 0.0, 0.0),
    **rest: Any,
) -> dict[str, Any]:
    """Return the document of one clamped rod of soft rubber along x."""
    material = {"young_modulus": 1e6, "shear_modulus": 3.5e5, "density": 1000.0}
    return {
        "name": "rod",
        "gravity": list(gravity),
        "materials": {"rubber": material | {"viscosity": viscosity}},
        "bodies": [
            {
                "rod": "rod",
                "strains": strains,
                "sections": [{"name": "s", "length": length, "material": "rubber"} | section],
            }
        ],
    } | rest


def circle(radius: Any) -> dict[str, Any]:
    """Return a cross-section."""
    return {"cross_section": {"shape": "circle", "radius": radius}}


KINDS: dict[str, Kind] = {}


def _add(*args: Any, **options: Any) -> None:
    kind = Kind(*args, **options)
    KINDS[kind.name] = kind


def _layers() -> None:
    """Add rods that bend within √(EI/T) of the clamp only, a few hundredths of the length."""
    light = {"schedule": {"end": 1e9, "ramp": 0.1}}
    for name, radius, tension in (("thread", 1e-3, 0.02), ("wire", 2e-3, 0.05)):
        side = [0.0, 0.0, 0.3 * tension]
        loads = [
            {"point": "pull", "body": "rod", "s": 0.4, "force": [tension, 0.0, 0.0]},
            {"point": "push", "body": "rod", "s": 0.4, "force": side} | light,
        ]
        document = rod(0.4, ["bend_y"], circle(radius), viscosity=2e4, loads=loads)
        fine = {"order": 7, "elements": 24, "nodes": 13}
        _add(name, "boundary layer", document, 0.2, 0.004, fine)


def _features() -> None:
    """Add arms whose data vary within 2 mm of 0.3 m; they droop under their own weight."""
    soft = {"expression": "7.85e-3*(1 - 0.98*exp(-((s - 0.1234)/0.001)**2))"}
    fold = {"expression": "600*exp(-((s - 0.0871)/0.001)**2)"}
    neck = {"expression": "0.01 - 0.006*exp(-((s - 0.1717)/0.0008)**2)"}
    stiff = circle(0.01) | {"stiffness": {"bend_y": soft}}
    folded = circle(0.01) | {"reference": {"curvature": [0.0, fold, 0.0]}}
    fine = {"order": 7, "elements": 8, "nodes": 16}
    for name, section in (("soft_spot", stiff), ("fold", folded), ("neck", circle(neck))):
        document = rod(0.3, ["bend_y"], section, viscosity=2e4, gravity=(0.0, 0.0, -4.0))
        _add(name, "narrow feature", document, 0.3, 0.01, fine)


def _fronts() -> None:
    """Add waves without damping, set off by a load that jumps."""
    axial = [{"point": "pull", "body": "rod", "s": 0.3, "force": [3.0, 0.0, 0.0]}]
    document = rod(0.3, ["stretch"], circle(0.01), loads=axial)
    _add("axial_front", "wave front", document, 0.05, 5e-4, {}, exact=_triangle)
    side = [{"point": "push", "body": "rod", "s": 0.3, "force": [0.0, 0.0, 5.0]}]
    document = rod(0.3, ["bend_y", "shear_z"], circle(0.02), loads=side)
    fine = {"order": 6, "elements": 12, "nodes": 11}
    _add("shear_front", "wave front", document, 0.05, 5e-4, fine)


def _triangle(time: Floats) -> Floats:
    """Return the tip (T, 3) of a bar pulled suddenly: d'Alembert's wave runs to and fro."""
    stiffness, speed = 1e6 * np.pi * 0.01**2, np.sqrt(1e6 / 1000.0)
    phase = np.mod(time * speed / 0.3, 4.0)
    out = np.zeros((len(time), 3))
    out[:, 0] = 0.3 + 3.0 * 0.3 / stiffness * np.minimum(phase, 4.0 - phase)
    return out


def _seldom() -> None:
    """Add an arm that is kicked, and settles long before the one state that is published."""
    kick = [
        {
            "point": "kick",
            "body": "rod",
            "s": 0.3,
            "force": [0.0, 0.0, 0.15],
            "schedule": {"end": 0.05},
        }
    ]
    document = rod(0.3, ["bend_y"], circle(0.008), viscosity=5e3, loads=kick)
    fine = {"order": 7, "elements": 4, "nodes": 20}
    _add("kicked", "published seldom", document, 0.6, 0.005, fine, every=120)


def _long() -> None:
    """Add motion that after a while depends on everything before it."""
    half = {"strains": ["bend_y"]}
    section = {"name": "s", "length": 0.2, "material": "rubber"} | circle(0.01)
    document = rod(0.2, ["bend_y"], circle(0.01), gravity=(0.0, 0.0, -9.81)) | {
        "bodies": [
            {"joint": "shoulder", "kind": "revolute", "axis": [0, 1, 0]},
            {"rod": "rod", "sections": [section]} | half,
            {"joint": "elbow", "kind": "revolute", "axis": [0, 1, 0]},
            {"rod": "fore", "sections": [section]} | half,
        ],
        "initial": {"positions": {"shoulder": -1.5, "elbow": -0.5}},
    }
    fine = {"order": 5, "elements": 1, "nodes": 24}
    precise = {"error": 1e-9, "tolerances": (1e-3,)}
    _add("double_pendulum", "long memory", document, 10.0, 0.01, fine, **precise)
    curl = {"reference": {"curvature": [6.0, 12.0, 0.0]}}
    strains = ["torsion", "bend_y", "bend_z"]
    document = rod(0.6, strains, circle(0.01) | curl, gravity=(0.0, 0.0, -9.81))
    fine = {"order": 6, "elements": 3, "nodes": 24}
    _add("helix", "long memory", document, 1.0, 0.005, fine, error=1e-8)


for _make in (_layers, _features, _fronts, _seldom, _long):
    _make()
