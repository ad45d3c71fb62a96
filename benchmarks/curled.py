"""Curled, coiled and loaded arms, at rest and moving: a coarse basis does not show them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

LENGTH, RADIUS, YOUNG = 0.4, 0.01, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4.0
TURNS = ["torsion", "bend_y", "bend_z"]
LIGHT = [0.0, 0.0, -9.81 * 0.3]


@dataclass(frozen=True)
class Curled:
    """A scene without numerics, and what happens to it.

    Parameters
    ----------
    name : of the scene
    document : of the scene
    efforts : (A,) held throughout
    tip : (6,) wrench held at the tip, which nobody knows when the scene is compiled
    follows : whether it follows the tip
    duration : of a motion from the reference shape in s; 0: a state of rest
    """

    name: str
    document: dict[str, Any]
    efforts: list[float] = field(default_factory=list)
    tip: list[float] | None = None
    follows: bool = False
    duration: float = 0.0


def rod(
    curvature: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    gravity: list[float] = LIGHT,
    viscosity: float = 0.0,
    sections: int = 1,
    actuated: bool = False,
    strains: list[str] | None = None,
    **rest: Any,
) -> dict[str, Any]:
    """Return the document of a soft rod with a reference curvature in 1/m."""
    material = {"young_modulus": YOUNG, "poisson_ratio": 0.5, "density": 1000.0}
    material["viscosity"] = viscosity
    own = {"length": LENGTH / sections, "material": "m"}
    own |= {"cross_section": {"shape": "circle", "radius": RADIUS}}
    if any(curvature):
        own["reference"] = {"curvature": list(curvature)}
    document = {
        "name": "curled", "gravity": gravity, "materials": {"m": material},
        "bodies": [{"rod": "r", "sections": [own | {"name": f"s{i}"} for i in range(sections)]}],
    }  # fmt: skip
    if strains:
        document["bodies"][0]["strains"] = strains
    if actuated:
        document["actuators"] = [
            {"moment": f"m{i}{axis}", "rod": "r", "section": f"s{i}", "strain": axis}
            for i in range(sections)
            for axis in ("bend_y", "bend_z")
        ]
    return document | rest


def turned(degrees: float) -> float:
    """Return the curvature in 1/m that turns the rod by an angle in degrees."""
    return float(np.deg2rad(degrees) / LENGTH)


def at_rest() -> Iterator[Curled]:
    """Give scenes of statics."""
    for angle in (45, 90, 180, 270, 360, 540):
        yield Curled(f"arc {angle}°", rod((0.0, 0.0, turned(angle))))
    for angle in (90, 180, 360, 540):
        moment = EI * turned(angle)
        yield Curled(f"bent by {angle}°", rod(actuated=True), [0.0, moment])
    for size in (2.0, 5.0, 10.0, 20.0):
        push = [0.0, 0.0, 0.0, 0.0, size * EI / LENGTH**2, 0.0]
        yield Curled(f"follower force {size:g}", rod(gravity=[0, 0, 0]), [], push, True)
    for turns in (0.25, 0.5, 1.0, 1.5):
        push = [0.0, 0.0, 2.0 * np.pi * turns * EI / LENGTH, 0.0, 0.0, 0.0]
        yield Curled(f"moment, {turns:g} turns", rod(), [], push, True)
    for turns, twist in ((1, 3.0), (2, 3.0), (3, 4.0)):
        shape = rod((twist, 0.0, turned(360.0 * turns)))
        yield Curled(f"coil of {turns} turns, weight", shape)
        pull = [0.0, 0.0, 0.0, 0.1, 0.05, -0.1]
        yield Curled(f"coil of {turns} turns, pulled", shape, [], pull)
    draw = np.random.default_rng(11)
    for k in range(5):
        wrench = np.concatenate([draw.normal(size=3) * EI / LENGTH * 1.5,
                                 draw.normal(size=3) * EI / LENGTH**2 * 3.0])  # fmt: skip
        yield Curled(f"wrench {k}", rod(), [], wrench.tolist())
    jet = {"distributed": "jet", "body": "r", "force": [0.0, 0.4, 0.2], "frame": "body"}
    yield Curled("jets along it", rod(loads=[jet]))
    yield Curled("three sections, coiled", rod(sections=3, actuated=True),
                 [v * EI / LENGTH for v in (2.0, 3.0, -2.0, 4.0, 3.0, 2.0)])  # fmt: skip


def moving() -> Iterator[Curled]:
    """Give scenes of motion, from the reference shape."""
    helix = (3.0, 0.0, turned(360.0))
    for viscosity in (0.0, 3e3, 3e4):
        shape = rod(helix, gravity=[0.0, 0.0, -9.81], strains=TURNS, viscosity=viscosity)
        yield Curled(f"falling helix, {viscosity:g} Pa·s", shape, duration=1.0)
    for angle in (90, 180, 270, 540):
        shape = rod((0.0, 0.0, turned(angle)), strains=TURNS, viscosity=5e3)
        yield Curled(f"falling arc {angle}°", shape, duration=0.4)
    for angle in (90, 180, 360):
        efforts = [0.0, EI * turned(angle)]
        shape = rod(actuated=True, strains=TURNS, viscosity=5e3)
        yield Curled(f"bending by {angle}°", shape, efforts, duration=0.4)
    jet = {"point": "jet", "body": "r", "force": [0.0, 5.0 * EI / LENGTH**2, 0.0], "frame": "body"}
    for viscosity in (1e3, 1e4):
        shape = rod(loads=[jet], strains=TURNS, viscosity=viscosity)
        yield Curled(f"jet at the tip, {viscosity:g} Pa·s", shape, duration=0.4)
    efforts = [v * EI / LENGTH for v in (2.0, 3.0, -2.0, 4.0, 3.0, 2.0)]
    shape = rod(sections=3, actuated=True, strains=TURNS, viscosity=5e3)
    yield Curled("three sections, coiling", shape, efforts, duration=0.4)
    coil = rod((4.0, 0.0, turned(1080)), strains=TURNS, viscosity=5e3)
    yield Curled("coil of 3 turns, falling", coil, duration=0.4)  # fmt: skip
