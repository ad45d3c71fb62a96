"""Kinds of scenes on which a companion may be hardly better than the run: physics only.

Boundary layers of thin rods under tension, features of the data that are narrower than any node,
wave fronts without damping, runs that publish seldom, and motion that forgets where it began. Each
is a small scene and a run of it; ``outcome`` is what is right for it, where not a kept tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.drive import Drive
from soft_sim_ros.scene import Free, Scene, parse_scene


@dataclass(frozen=True)
class Kind:
    """A scene without numerics, and a run of it.

    name, kind : of the case, and of what is hard about it
    document : the scene
    duration, step : s
    fine : basis of the reference
    every : steps between two published states; the tip is compared at all steps
    """

    name: str
    kind: str
    document: dict[str, Any] = field(hash=False)
    duration: float
    step: float
    fine: dict[str, Any] = field(hash=False)
    every: int = 1

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
        numerics = {"step": self.step, "integrator": "adaptive", "options": {"error": 1e-10}}
        scene = self._parsed(numerics | {"basis": basis})
        return replace(scene, numerics=replace(scene.numerics, free=Free()))

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


def pull(*force: float, frame: str = "world") -> dict[str, Any]:
    """Return a force at the tip."""
    return {"name": "pull", "body": "rod", "at": "tip", "force": list(force), "frame": frame}


KINDS: dict[str, Kind] = {}


def _add(*args: Any, **options: Any) -> None:
    kind = Kind(*args, **options)
    KINDS[kind.name] = kind


def _layers() -> None:
    """Bending is confined to √(EI/T) at the clamp, a hundredth of the length."""
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
    """Data by formula that vary within 2 mm of 0.3 m; drooping under the own weight."""
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
    """Waves without damping, set off by a load that jumps."""
    axial = [{"point": "pull", "body": "rod", "s": 0.3, "force": [3.0, 0.0, 0.0]}]
    document = rod(0.3, ["stretch"], circle(0.01), loads=axial)
    _add("axial_front", "wave front", document, 0.05, 5e-4, {"order": 4, "elements": 200, "nodes": 6})
    side = [{"point": "push", "body": "rod", "s": 0.3, "force": [0.0, 0.0, 0.02]}]
    document = rod(0.3, ["bend_y", "shear_z"], circle(0.01), loads=side)
    fine = {"order": 5, "elements": 40, "nodes": 10}
    _add("shear_front", "wave front", document, 0.05, 5e-4, fine)


def _seldom() -> None:
    """Kicked, and settled long before the one state that is published."""
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


for _make in (_layers, _features, _fronts, _seldom):
    _make()
