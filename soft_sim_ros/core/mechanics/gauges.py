"""What sensors would read without noise: one class a kind, in a table.

The numbers of a reading are in the order of ``Sensor.labels``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.samples import Place, at_node, locate_in
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.compile.shape import shape_matrix, strain
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.sensor import CURVATURE, ENCODER, IMU, STRAIN, TENDON, WRENCH, Sensor

from .cut import Cut
from .instant import Instant, MountedFrame, cross

LEAST = 1e-6  # length of a fibre along the rod per arc length


class Gauge(Protocol):
    """Reads the motion.

    Attributes
    ----------
    moving : whether it asks for the recursion with accelerations
    ported : whether it asks for the ports of the actuators
    place : where the frame is that it is in (compile/samples.py); None: it is in none
    row : which of ``Instant.motions`` is that of this frame
    """

    moving: bool
    ported: bool
    place: Place | None
    row: int

    def read(self, now: Instant) -> Floats:
        """Return the numbers (W,) of a reading."""


class Still:
    """What a gauge has that reads coordinates only."""

    moving = ported = False
    place: Place | None = None
    row = 0


class StrainGauge(Still):
    """The strain of a fibre of a rod, ΔL/L, positive where it is longer than without any load.

    Cross-sections stay plane and keep their shape, so a fibre that points along a (in the section's
    axes, without load) and lies at d is stretched by what moves along the rod alone: with Γ + K × d
    for Γ₀ + K₀ × d. Poisson's contraction across the rod is not in it.
    """

    def __init__(self, compiled: Compiled, sensor: Sensor, key: str) -> None:
        s, zero = np.array(sensor.s), np.zeros(len(compiled.coordinate_names))
        self._phi = shape_matrix(compiled, sensor.of, s)[0]
        self._xi0 = strain(compiled, sensor.of, zero, s)[0]
        self._at = sensor.place.position
        along = self._fibre(self._xi0)
        if not along[0] > LEAST:
            offset = str(self._at[1:].tolist())
            expected = "a place on the near side of the centre of curvature of the rod"
            raise SceneError(compiled.scene.file, f"{key}.offset", offset, expected)
        self._share = float(sensor.direction[0] / along[0])
        self._across = sensor.direction - self._share * along

    def read(self, now: Instant) -> Floats:
        """Return the strain (1,)."""
        fibre = self._share * self._fibre(self._xi0 + self._phi @ now.q) + self._across
        return np.array([np.linalg.norm(fibre) - 1.0])

    def _fibre(self, xi: Floats) -> Floats:
        """Return what a fibre along the rod becomes per arc length (3,)."""
        return xi[3:] + cross(xi[:3], self._at)


class CurvatureGauge(Still):
    """Torsion and curvature K of a rod in rad/m, as Bragg gratings in a fibre give them.

    They are those of the shape, with those of the reference shape, per reference arc length.
    """

    def __init__(self, compiled: Compiled, sensor: Sensor, _key: str) -> None:
        s, zero = np.array(sensor.s), np.zeros(len(compiled.coordinate_names))
        self._phi = shape_matrix(compiled, sensor.of, s)[:, :3].reshape(3 * len(s), -1)
        self._xi0 = strain(compiled, sensor.of, zero, s)[:, :3].ravel()

    def read(self, now: Instant) -> Floats:
        """Return K (3 P,) at all places."""
        return self._xi0 + self._phi @ now.q


class InertialUnit(Still):
    """Orientation in the world, angular velocity, and specific force: acceleration minus gravity.

    The last two along its own axes: at rest it reads +9.81 m/s² upwards, in free fall nothing.
    """

    moving = True

    def __init__(self, compiled: Compiled, sensor: Sensor, _key: str) -> None:
        offset = se3.pose_matrix(sensor.place.position, sensor.place.quaternion)
        self.place, self._frame = _place(compiled, sensor), MountedFrame(offset)

    def read(self, now: Instant) -> Floats:
        """Return quaternion x y z w, angular velocity and specific force (10,)."""
        motion = self._frame.motion(now.motions[self.row], now.base)
        return np.concatenate([quaternion(motion.rotation), motion.omega, motion.force])


class WrenchGauge(Still):
    """What the body with all beyond it does to what carries it; see ``Cut``."""

    moving = True

    def __init__(self, compiled: Compiled, sensor: Sensor, key: str) -> None:
        self._cut = Cut(compiled, sensor, key)

    def read(self, now: Instant) -> Floats:
        """Return moment and force (6,) along the axes of the body's frame, about its origin."""
        return self._cut.wrench(now)


class TendonGauge(Still):
    """Length of a tendon along its path in the rods, its rate, and its tension at the entry."""

    ported = True

    def __init__(self, compiled: Compiled, sensor: Sensor, _key: str) -> None:
        names = [actuator.name for actuator in compiled.scene.actuators]
        self._port = names.index(sensor.of)
        self._rest = float(compiled.model.tendon_rest[self._port])

    def read(self, now: Instant) -> Floats:
        """Return length, rate and tension (3,)."""
        assert now.ports is not None
        position, rate, effort = (part[self._port] for part in now.ports)
        return np.array([self._rest - position, -rate, effort])


class Encoder(Still):
    """Coordinates of a joint and their rates."""

    def __init__(self, compiled: Compiled, sensor: Sensor, _key: str) -> None:
        self._columns = list(compiled.chain.joints[sensor.of])

    def read(self, now: Instant) -> Floats:
        """Return positions, then velocities."""
        return np.concatenate([now.q[self._columns], now.v[self._columns]])


GAUGES: dict[str, Callable[[Compiled, Sensor, str], Gauge]] = {
    STRAIN: StrainGauge,
    CURVATURE: CurvatureGauge,
    IMU: InertialUnit,
    WRENCH: WrenchGauge,
    TENDON: TendonGauge,
    ENCODER: Encoder,
}


def _place(compiled: Compiled, sensor: Sensor) -> Place:
    """Return where on the arm a frame is."""
    chain = compiled.chain
    span = chain.rods.get(sensor.of) or chain.links.get(sensor.of)
    if span is None:
        return at_node(chain.frames[sensor.of])
    return locate_in(chain, span, sensor.s[0])


def quaternion(turn: Floats) -> Floats:
    """Return x y z w (4,) of a rotation matrix, w not negative."""
    trace = float(np.trace(turn))
    if trace > 0.0:
        w = 0.5 * np.sqrt(1.0 + trace)
        axis = np.array([
            turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1],
        ])  # fmt: skip
        return np.array([*(axis / (4.0 * w)), w])
    i = int(np.argmax(np.diag(turn)))
    j, k = (i + 1) % 3, (i + 2) % 3
    out = np.zeros(4)
    out[i] = 0.5 * np.sqrt(max(0.0, 1.0 + turn[i, i] - turn[j, j] - turn[k, k]))
    out[j], out[k] = (
        (turn[i, j] + turn[j, i]) / (4.0 * out[i]),
        (turn[i, k] + turn[k, i]) / (4.0 * out[i]),
    )
    out[3] = (turn[k, j] - turn[j, k]) / (4.0 * out[i])
    return out if out[3] >= 0.0 else -out
