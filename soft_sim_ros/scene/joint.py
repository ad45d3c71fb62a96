"""Joints: the relative motions that they allow between the parts before and after them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.driven import Course, read_courses
from soft_sim_ros.scene.interval import NONNEGATIVE
from soft_sim_ros.scene.pose import IDENTITY, Pose, read_pose
from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.taper import Floats

JOINT_KINDS = ("fixed", "revolute", "prismatic", "universal", "spherical", "free")
# Kinds whose coordinates are amounts along axes: they can have springs, dampers and motors.
AXES = {"revolute": 1, "prismatic": 1, "universal": 2}
TURN, SHIFT = ("rx", "ry", "rz"), ("x", "y", "z")
LABELS = {"fixed": (), "universal": ("first", "second"), "spherical": TURN, "free": TURN + SHIFT}
PARALLEL = 1e-6  # sine of the angle below which two axes are one


@dataclass(frozen=True, eq=False)
class Joint:
    """Moves what is beyond by the pose ``offset``, then by its own coordinates in the new frame.

    kind : revolute (angle about the axis, rad), prismatic (path along it, m), universal (angle
        about the first axis, then about the second, which turns with the first), spherical
        (rotation vector, rad), free (rotation vector, and position in m along the axes before it
        turns), fixed (nothing).
    axes : (k, 3) unit vectors, k = 1, 2 for the kinds in AXES, else 0.
    stiffness in N·m/rad or N/m per axis (rest at 0); damping in N·m·s/rad or N·s/m per axis.
    driven : what its coordinates are told to do, in their order; empty: they move freely
    """

    name: str
    kind: str
    axes: Floats
    offset: Pose = IDENTITY
    stiffness: float = 0.0
    damping: float = 0.0
    driven: tuple[Course, ...] = ()

    @property
    def axis(self) -> Floats:
        """The first axis (3,)."""
        axis: Floats = self.axes[0]
        return axis

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        if self.kind in ("revolute", "prismatic"):
            return (self.name,)
        return tuple(f"{self.name}/{label}" for label in LABELS[self.kind])

    def unit_of(self, coordinate: str) -> str:
        """Return the unit of a coordinate: rad or m."""
        shifts = self.kind == "prismatic" or coordinate.rpartition("/")[2] in SHIFT
        return "m" if shifts and self.kind in ("prismatic", "free") else "rad"


def read_joint(reader: Reader, name: str) -> Joint:
    """Read a joint."""
    reader.only(
        "joint", "parent", "kind", "axis", "axes", "offset", "stiffness", "damping", "driven"
    )
    kind = reader.choice("kind", JOINT_KINDS)
    if kind == "fixed":
        reader.no_effect("driven", "a fixed joint has no coordinates")
    driven = read_courses(reader, LABELS.get(kind, ("",))) if reader.has("driven") else ()
    offset = read_pose(reader.mapping("offset"))
    article = f"a {kind} joint"
    if kind not in AXES:
        for key in ("axis", "axes"):
            reader.no_effect(key, f"it has no effect on {article}")
        for key in ("stiffness", "damping"):
            reader.no_effect(
                key,
                f"it has no effect on {article}"
                if kind == "fixed"
                else f"{article} has no axes; springs and dampers act about those of a "
                "revolute, prismatic or universal joint",
            )
        return Joint(name, kind, frozen(np.zeros((0, 3))), offset, driven=driven)
    if AXES[kind] == 1:
        reader.no_effect("axes", f"{article} has one axis")
        axes = [_direction(reader, "axis", reader.vector("axis", 3))]
    else:
        reader.no_effect("axis", f"{article} has two axes, axes: [[x, y, z], [x, y, z]]")
        axes = [_direction(reader, "axes", axis) for axis in reader.matrix("axes", AXES[kind], 3)]
        if not float(np.linalg.norm(np.cross(axes[0], axes[1]))) > PARALLEL:
            reader.refuse("two axes that are not parallel", "axes")
    return Joint(
        name,
        kind,
        frozen(axes),
        offset,
        stiffness=reader.number("stiffness", NONNEGATIVE, default=0.0),
        damping=reader.number("damping", NONNEGATIVE, default=0.0),
        driven=driven,
    )


def _direction(reader: Reader, key: str, axis: Floats) -> Floats:
    """Return a unit vector (3,)."""
    norm = float(np.linalg.norm(axis))
    if not 1e-100 < norm < 1e100:
        reader.refuse(f"a direction, not a vector of length {norm:g}", key)
    unit: Floats = axis / norm
    return unit
