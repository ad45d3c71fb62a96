"""Default bounds of commands without limits: the wrench at the tip, and efforts.

A finite number need not be a reasonable one, for example a force of 1e308 N. So commands are
limited to bounds far beyond any useful command. They follow from the arm only:

- force: what stretches its stiffest section by a tenth, but not less than ten times its weight nor
  more than a thousand times;
- moment: what bends its stiffest section by 10 rad (a turn and a half) over its length, but not
  more than a thousand times its weight times its length; ten times that where nothing bends;
- position and rate of a driven joint: a thousand rad, or lengths of the arm, and that per second;
- length: that of the arm; pressure: ten times that force in a chamber.

Scenes and parameters can say something else.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.foreign import bare
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.actuator import ChamberActuator
from soft_sim_ros.scene.summary import summary, total_mass

G = 9.81  # m/s², also where the scene has no gravity
LIGHT, HEAVY = 10.0, 1000.0  # times the weight
STRETCH, TURN = 0.1, 10.0  # strain, rad
FAR = 1000.0  # rad, or lengths of the arm


@dataclass(frozen=True)
class Bounds:
    """Bounds of what comes in from outside.

    Parameters
    ----------
    efforts : (A, 2) lowest and highest command of every actuator, in its unit
    moment : largest moment of the wrench at the tip, N·m; infinite = not bounded
    force : largest force of it, N
    drives : (C,) largest position in rad or m, and rate, of driven coordinates that follow commands
    """

    efforts: NDArray[np.float64]
    moment: float
    force: float
    drives: NDArray[np.float64]

    @classmethod
    def none(cls, scene: Scene) -> Bounds:
        """Bounds of a scene that are its limits and nothing more."""
        return cls(_limits(scene), math.inf, math.inf, np.full(len(scene.commanded), math.inf))

    @classmethod
    def of_arm(cls, scene: Scene, length: float, moment: float = 0.0, force: float = 0.0) -> Bounds:
        """Bounds that follow from an arm of this length in m, for wrench and efforts.

        A ``moment`` in N·m or a ``force`` in N above zero is taken for the wrench instead.
        """
        rows = summary(scene)
        weight = total_mass(scene) * G
        axial = max((max(row.EA) for row in rows), default=0.0)
        bending = max((max(*row.EI_y, *row.EI_z) for row in rows), default=0.0)
        most = {
            "N": min(max(LIGHT * weight, STRETCH * axial), HEAVY * weight),
            "N·m": min(TURN * bending / length or LIGHT * weight * length, HEAVY * weight * length),
            "m": length,
        }
        efforts = _limits(scene)
        for row, actuator in zip(efforts, scene.actuators, strict=True):
            if isinstance(actuator, ChamberActuator):
                high = 10.0 * most["N"] / actuator.area
            else:
                high = most[actuator.unit]
            # limits that are set, and the safe effort, always lie within
            set_by_scene = [abs(x) for x in (*actuator.limits, actuator.safe) if math.isfinite(x)]
            high = max(high, *set_by_scene)
            row[:] = np.clip(row, -high, high)
        drives = [FAR * (1.0 if unit == "rad" else length) for unit in scene.commanded_units]
        return cls(efforts, moment or most["N·m"], force or most["N"], np.array(drives))

    @classmethod
    def recorded(cls, scene: Scene, facts: dict[str, str]) -> Bounds:
        """Bounds that a recording says were in force; none where it says nothing."""
        plain = cls.none(scene)
        text = facts.get("effort_limits", "null")
        try:
            efforts = np.array(json.loads(text) or plain.efforts, float)
        except (ValueError, TypeError):  # not JSON, or not of numbers
            efforts = np.empty(0)
        if efforts.shape != plain.efforts.shape or np.isnan(efforts).any():
            shape = f"{len(plain.efforts)} pairs of numbers"
            raise ValueError(f"effort_limits = {bare(text)}: expected {shape}")
        moment, force = (_limit(facts, f"{key}_limit") for key in ("moment", "force"))
        text = facts.get("drive_limits", "null")
        try:
            drives = np.array(json.loads(text) or plain.drives, float)
        except (ValueError, TypeError):
            drives = np.empty(0)
        if drives.shape != plain.drives.shape or not (drives >= 0.0).all():
            numbers = f"{len(plain.drives)} numbers"
            raise ValueError(f"drive_limits = {bare(text)}: expected {numbers}")
        return cls(efforts, moment, force, drives)

    def within(self, moment: float, force: float) -> Bounds:
        """Return bounds whose moment in N·m and force in N are no larger than these."""
        return replace(self, moment=min(self.moment, moment), force=min(self.force, force))

    def facts(self) -> dict[str, str]:
        """Give the bounds as text, for `recorded`."""
        return {
            "moment_limit": repr(self.moment),
            "force_limit": repr(self.force),
            "effort_limits": json.dumps(self.efforts.tolist()),
            **({"drive_limits": json.dumps(self.drives.tolist())} if len(self.drives) else {}),
        }

    def cut(self, wrench: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[str, ...]]:
        """Return a finite wrench (6,) inside the bounds, and in words what was cut.

        Moment and force keep their directions.
        """
        cut, said = wrench.copy(), []
        for part, most, name, unit in (
            (slice(0, 3), self.moment, "torque", "N·m"),
            (slice(3, 6), self.force, "force", "N"),
        ):
            largest = float(np.abs(wrench[part]).max())
            if largest == 0.0 or most == math.inf:
                continue
            direction = wrench[part] / largest  # squares of huge numbers are infinite
            size = float(np.linalg.norm(direction))
            if largest * size > most or not math.isfinite(largest * size):
                cut[part] = direction * (most / size)
                said.append(f"{name} of {largest * size:.3g} {unit} cut to {most:.3g} {unit}")
        return cut, tuple(said)


def _limits(scene: Scene) -> NDArray[np.float64]:
    limits = np.array([a.limits for a in scene.actuators], dtype=float)
    return limits.reshape(len(scene.actuators), 2)


def _limit(facts: dict[str, str], name: str) -> float:
    """Return a recorded limit; infinite where there is none."""
    text = facts.get(name, "inf")
    try:
        limit = float(text)
    except ValueError:
        limit = math.nan
    if not limit >= 0.0:
        raise ValueError(f"{name} = {bare(text)}: expected a number, 0 or more")
    return limit
