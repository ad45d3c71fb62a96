"""The sensors of a simulation: when they measure, what noise adds, and readings under way.

A sensor measures at the times n / rate, n = 0, 1, …, each at the first step that is not before it,
with the inputs that acted in that step. Its noise follows from its seed, its name and the index of
that step alone. So readings are a function of the motion, whoever looks at them and when.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.gauges import GAUGES, Gauge, quaternion
from soft_sim_ros.core.mechanics.instant import Instant
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.sensor import IMU, Sensor

from .reading import Reading

NONE = -1.0  # index of the step of a reading that there is not; others are not negative


class Channel:
    """One sensor: its times, its noise, and its readings that are still wanted, oldest first.

    Parameters
    ----------
    compiled : the arm
    sensor : of its scene
    step_ns : the step in ns
    key : of the sensor in the scene, for errors
    """

    def __init__(self, compiled: Compiled, sensor: Sensor, step_ns: int, key: str) -> None:
        self.sensor, self._step_ns = sensor, step_ns
        self.gauge: Gauge = GAUGES[sensor.kind](compiled, sensor, key)
        steps = Fraction(10**9) / (sensor.exact_rate * step_ns)  # between two readings
        self._over, self._under = steps.numerator, steps.denominator
        if steps < 1:
            fastest = f"{1e9 / step_ns:g} Hz, once per step of {step_ns * 1e-9:g} s"
            raise SceneError(
                compiled.scene.file, f"{key}.rate", f"{sensor.rate:g}", f"at most {fastest}"
            )
        late = Fraction(repr(sensor.latency)) * 10**9 / step_ns
        self.late = ceil(late)  # steps until a reading is there
        self.most = self.late * self._under // self._over + 2  # readings that are kept
        self._noisy = bool(sensor.noise.any())
        self.rows: list[tuple[int, Floats]] = []

    @property
    def next(self) -> int:
        """The step at which it is to measure next; 0 before the first time."""
        return self.next_after(self.rows[-1][0]) if self.rows else 0

    def next_after(self, index: int) -> int:
        """Return the first step after a step at which it measures."""
        turn = index * self._under // self._over + 1
        return -(-turn * self._over // self._under)

    def delivers_after(self, index: int) -> int:
        """Return the first step after a step at which a reading gets out."""
        waiting = [row + self.late for row, _ in self.rows if row + self.late > index]
        if waiting:
            return waiting[0]
        last = self.rows[-1][0] if self.rows else index
        return self.next_after(max(last, index - self.late)) + self.late

    def measure(self, now: Instant, index: int) -> None:
        """Take a reading at a step, and forget those that no one can ask for any more."""
        values = self.gauge.read(now) + 0.0
        sensor = self.sensor
        if self._noisy or sensor.bias.any():
            values = self._disturbed(values, index)
        if sensor.kind == IMU and self.rows and values[:4] @ self.rows[-1][1][:4] < 0.0:
            values[:4] *= -1.0  # the same orientation, without a jump
        values.flags.writeable = False
        out = [i for i, (row, _) in enumerate(self.rows) if row + self.late <= index]
        self.rows = [*self.rows[out[-1] if out else 0 :], (index, values)][-self.most :]

    def reading(self, index: int) -> Reading:
        """Return the newest reading that is out at a step."""
        sensor, step_ns = self.sensor, self._step_ns
        out = [row for row in self.rows if row[0] + self.late <= index]
        if not out:
            nothing = np.full(len(sensor.labels), np.nan)
            return Reading(sensor.name, sensor.kind, None, None, sensor.labels, nothing)
        row, values = out[-1]
        times = row * step_ns, (row + self.late) * step_ns
        return Reading(sensor.name, sensor.kind, *times, sensor.labels, values)

    def _disturbed(self, values: Floats, index: int) -> Floats:
        sensor = self.sensor
        error = sensor.bias.copy()
        if self._noisy:
            key = np.array([sensor.seed, sensor.stream], dtype=np.uint64)
            stream = np.random.Philox(key=key, counter=[0, index, 0, 0])
            error += sensor.noise * np.random.Generator(stream).standard_normal(len(error))
        if sensor.kind != IMU:
            return values + error
        out = values + error
        out[:4] = values[:4]
        if error[:3].any():  # a small turn about its own axes
            turn = se3.pose_matrix(np.zeros(3), values[:4])
            turn = turn @ se3.exp(np.concatenate([error[:3], np.zeros(3)]))
            out[:4] = quaternion(turn[:3, :3])
        return out

    # The readings as numbers of a state: rows of the index of a step and the values.

    @property
    def size(self) -> int:
        """How many numbers that is."""
        return self.most * (1 + len(self.sensor.labels))

    def packed(self) -> Floats:
        """Return them (size,)."""
        out = np.zeros((self.most, 1 + len(self.sensor.labels)))
        out[:, 0] = NONE
        for kept, (index, values) in zip(out, self.rows, strict=False):
            kept[0], kept[1:] = index, values
        return out.ravel()

    def unpack(self, numbers: Floats) -> None:
        """Put them back."""
        rows = numbers.reshape(self.most, -1)
        self.rows = [(int(row[0]), row[1:].copy()) for row in rows if row[0] >= 0.0]
        for _, values in self.rows:
            values.flags.writeable = False


class Sensing:
    """All sensors of a scene.

    Parameters
    ----------
    compiled : the arm
    step_ns : the step in ns
    """

    def __init__(self, compiled: Compiled, step_ns: int) -> None:
        self.channels = {
            sensor.name: Channel(compiled, sensor, step_ns, f"sensors[{i}]")
            for i, sensor in enumerate(compiled.scene.sensors)
        }
        self.gauges = [channel.gauge for channel in self.channels.values()]
        self.ported = any(gauge.ported for gauge in self.gauges)
        self.next = 0  # the step at which the next reading is to be taken

    def measure(self, now: Instant, index: int) -> None:
        """Let the sensors that are due at a step measure."""
        for channel in self.channels.values():
            if channel.next <= index:
                channel.measure(now, index)
        self._look()

    def _look(self) -> None:
        self.next = min(channel.next for channel in self.channels.values())

    def delivers_after(self, index: int) -> int:
        """Return the first step after a step at which a reading gets out of a sensor."""
        return min(channel.delivers_after(index) for channel in self.channels.values())

    def readings(self, index: int) -> dict[str, Reading]:
        """Return the newest reading of every sensor that is out at a step."""
        return {name: channel.reading(index) for name, channel in self.channels.items()}

    def clear(self) -> None:
        """Forget all readings."""
        for channel in self.channels.values():
            channel.rows = []
        self._look()

    @property
    def size(self) -> int:
        """How many numbers the readings are in a state."""
        return sum(channel.size for channel in self.channels.values())

    def packed(self) -> Floats:
        """Return the readings as numbers (size,)."""
        return np.concatenate([channel.packed() for channel in self.channels.values()])

    def unpack(self, numbers: Floats) -> None:
        """Put readings back."""
        begin = 0
        for channel in self.channels.values():
            channel.unpack(numbers[begin : begin + channel.size])
            begin += channel.size
        self._look()
