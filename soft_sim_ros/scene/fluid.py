"""The fluid around the bodies of a scene: what it is, and how bodies meet it.

All coefficients are those of the literature: drag per ½ρu² and the area that the flow sees, added
mass per mass of the fluid in a circle as wide as the section. What is given for a section counts
before what is given for its rod, and that before the default of the scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy import special

from soft_sim_ros.scene.cross_section import Annulus, Circle, CrossSection, Ellipse, Rectangle
from soft_sim_ros.scene.driven import Course
from soft_sim_ros.scene.pose import Pose
from soft_sim_ros.scene.taper import Floats

Numbers = tuple[float, ...]
LAWS = ("split", "whole")
ENDS = ("start", "end")
# Of rods; the drag of a bare cylinder between Reynolds numbers of 10³ and 10⁵.
DEFAULTS: dict[str, Numbers] = {
    "drag_normal": (1.1, 1.1),
    "drag_tangential": (0.01, 0.01),
    "lift": (0.0, 0.0, 0.0),
    "added_mass": (1.0, 1.0),
    "viscous_normal": (0.0, 0.0),
    "viscous_tangential": (0.0, 0.0),
    "flooded": (0.0,),  # 1: the fluid fills tubes
}


@dataclass(frozen=True, eq=False)
class RodFluid:
    """What is written about the fluid for a rod or a section of it.

    given : coefficient → values along the section's y and z axes (of ``lift``: x, y and z); what is
        missing is inherited
    dry : whether the fluid does not reach it at all
    dry_ends : ends of a rod on which the fluid does not press (``start``, ``end``)
    """

    given: Mapping[str, Numbers] = field(default_factory=dict)
    dry: bool = False
    dry_ends: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class BodyFluid:
    """How a rigid body meets the fluid, along the axes of the frame ``center``.

    Parameters
    ----------
    center : that frame in the body's; its origin is the centre of the displaced volume
    volume : m³
    added_mass : (3,) kg, None: that of the shape
    added_inertia : (3,) kg·m², None: that of the shape
    added_volume, added_moment : (3,) m³ and m⁵ of the shape: added mass and inertia per density
    area : (3,) m² seen from the front along each axis
    drag : (3,) coefficients; viscous : (3,) N·s/m
    rotary_drag : (3,) N·m·s²; rotary_viscous : (3,) N·m·s
    lift : (3,) coefficients per mean of the areas seen along y and z
    """

    center: Pose
    volume: float
    added_mass: Floats | None
    added_inertia: Floats | None
    added_volume: Floats
    added_moment: Floats
    area: Floats
    drag: Floats
    viscous: Floats
    rotary_drag: Floats
    rotary_viscous: Floats
    lift: Floats


@dataclass(frozen=True, eq=False)
class Fluid:
    """The fluid that surrounds all bodies; there is no surface that they could leave it by.

    Parameters
    ----------
    density : kg/m³
    current : its velocity along world x, y, z in m/s as a function of time; empty: it is still
    given : coefficients of rods that do not say otherwise
    law : ``split``: friction of a rod goes with the whole speed, the rest with that across; or
        all goes with the ``whole`` speed
    surface : m above the world's origin, against gravity, where the pressure is zero
    """

    density: float
    current: tuple[Course, ...]
    given: Mapping[str, Numbers]
    law: str = "split"
    surface: float = 0.0

    def coefficients(self, rod: RodFluid, section: RodFluid) -> dict[str, Numbers]:
        """Return what counts for a section of a rod."""
        return DEFAULTS | dict(self.given) | dict(rod.given) | dict(section.given)

    def displaced(self, rod: RodFluid, section: RodFluid, shape: Outline) -> Floats:
        """Return the displaced volume per length (N,) in m² of places along a section of a rod."""
        flooded = self.coefficients(rod, section)["flooded"][0]
        return shape.area - flooded * shape.bore


@dataclass(frozen=True, eq=False)
class Outline:
    """What the fluid sees of cross-sections (N,).

    across : (N, 2) widths in m that a flow along y, and one along z, meets
    perimeter : m; area : m², that which a tube encloses included; bore : m², that of it alone
    """

    across: Floats
    perimeter: Floats
    area: Floats
    bore: Floats


def outline(shape: CrossSection, x: Floats) -> Outline:
    """Return the outline of a cross-section at normalised arc lengths x (N,)."""
    if isinstance(shape, Circle | Annulus):
        radius = shape.radius(x) if isinstance(shape, Circle) else shape.outer(x)
        across = np.stack([2.0 * radius, 2.0 * radius], axis=1)
        inner = shape.inner(x) if isinstance(shape, Annulus) else 0.0 * radius
        return Outline(across, 2.0 * np.pi * radius, np.pi * radius**2, np.pi * inner**2)
    if isinstance(shape, Rectangle):
        y, z = shape.width_y(x), shape.width_z(x)
        return Outline(np.stack([z, y], axis=1), 2.0 * (y + z), y * z, 0.0 * y)
    assert isinstance(shape, Ellipse)
    y, z = shape.semi_axis_y(x), shape.semi_axis_z(x)
    long, short = np.maximum(y, z), np.minimum(y, z)
    perimeter = 4.0 * long * special.ellipe(1.0 - (short / long) ** 2)
    return Outline(2.0 * np.stack([z, y], axis=1), perimeter, np.pi * y * z, 0.0 * y)


def ellipsoid(axes: Floats) -> tuple[float, Floats, Floats, Floats]:
    """Return what the fluid sees of an ellipsoid of semi-axes (3,) in m.

    Volume, areas from the front, and added mass and inertia per density of the fluid by Lamb,
    Hydrodynamics (1932), articles 114 and 115: α_i = abc ∫ dλ/((a_i² + λ) Δ), by Carlson's R_D.
    """
    a, b, c = (float(axis) for axis in axes)
    volume = 4.0 / 3.0 * np.pi * a * b * c
    squares = np.array([a * a, b * b, c * c])
    alpha = np.array(
        [
            2.0 / 3.0 * a * b * c * special.elliprd(*np.delete(squares, i), squares[i])
            for i in range(3)
        ]
    )
    added = volume * alpha / (2.0 - alpha)
    turned = np.zeros(3)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        apart, twin = squares[j] - squares[k], alpha[k] - alpha[j]
        below = 2.0 * apart + (squares[j] + squares[k]) * (alpha[j] - alpha[k])
        if abs(apart) > 1e-12 * squares.max():  # a body of revolution drags nothing about its axis
            turned[i] = volume / 5.0 * apart**2 * twin / below
    area = np.pi * np.array([b * c, a * c, a * b])
    return volume, area, added, turned
