"""External inputs of the arm: commanded efforts, wrenches, and goals of driven joints.

``Inputs`` stands between messages and ``Simulation``. What acts in every step is a pure function
of the simulation time and of the orders taken up so far, so the node and a later re-simulation of
its recording, which take up the same orders at the same times, apply the same bits, however the
steps were grouped into calls.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.core.arguments import number, whole

from .bounds import Bounds
from .order_book import OrderBook
from .orders import EXTERNAL_WRENCH, TIP, WORLD, Goal, Order, PoseGoal
from .orders import wrench_frame as wrench_frame  # for those who look for it here

if TYPE_CHECKING:
    from .simulation import Simulation

_NEVER = int(np.iinfo(np.int64).max)
MOST_STEPS = _NEVER  # in one call
_EVER = 4e9  # s: beyond all times that 64 bits of nanoseconds are used for, without overflow


class Inputs(OrderBook):
    """Commanded efforts, wrenches and goals of one simulation, with limits and a timeout.

    Parameters
    ----------
    simulation : Simulation
        The arm that is driven; ``scene.actuators`` give limits and safe efforts.
    command_timeout : float
        s of simulation time for which the last order of an actuator (or of the wrench) is held;
        0 = for ever.
    ramp : float
        s over which a stale effort then goes linearly to its safe value (a wrench to zero).
        A driven coordinate whose last command leaves it moving is then brought to rest.
    bounds : Bounds or None
        To what a wrench, and efforts without limits, are cut; None = to nothing.

    Notes
    -----
    The timeout runs for every actuator by itself: commanding one joint does not keep a stale effort
    of another alive. Orders change nothing before the next `update`; `advance` calls it wherever
    the efforts change.
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        bounds: Bounds | None = None,
    ) -> None:
        timeout, ramp = (
            min(
                number(name, value, 0.0, "time in s: expected a finite number, zero or more"), _EVER
            )
            for name, value in (("command_timeout", command_timeout), ("ramp", ramp))
        )
        # A timeout below a nanosecond must not be rounded to 0, which means none.
        self._timeout_ns = round(timeout * 1e9) or int(timeout > 0.0)
        self._ramp_ns = round(ramp * 1e9)
        self.simulation = simulation
        super().__init__(simulation.scene, bounds)
        safe = [actuator.safe for actuator in simulation.scene.actuators]
        others = 6 * len(self.wrenches) + len(self.commanded)
        self._safe = np.array(safe + others * [0.0], dtype=float)
        wrenches = [EXTERNAL_WRENCH, *(f"{EXTERNAL_WRENCH}/{of}" for of in self.wrenches[1:])]
        pushes = [name for name in wrenches for _ in range(6)]
        self._labels = (*self.names, *pushes, *self.commanded)  # of all channels
        self._events: list[tuple[int, str]] = []
        self.last_order_ns: int | None = None
        self._clear()
        self.update()

    # Taking up.

    def take(self, order: Order) -> None:
        """Hold the values of ``order`` from the next `update` on; its timeout starts now."""
        now = self.simulation.time_ns
        # set the flags for the next `update` first, because an interrupt may come at any time
        if order.frame is None:
            self._changed = True
        else:
            self._pushed[order.which] = True
        for goal in order.goals:
            self._going[goal.name] = goal
        if order.pose is not None:
            for name in self._poses[order.pose.joint]:
                self._going.pop(name, None)
            self._posing[order.pose.joint] = order.pose
        self._active |= {self._labels[i] for i in order.channels if i >= self._first_drive}
        self._held[order.channels] = order.values
        self._since[order.channels] = _NEVER if order.lasting else now
        self._lasting[order.channels] = order.lasting
        self._late[order.channels] = False
        self._oldest = int(self._since.min())
        if order.frame is not None:
            self._frames[order.which] = order.frame
        self.last_order_ns = now

    def command(self, efforts: Sequence[float] | np.ndarray) -> Order:
        """Check and take up efforts for all actuators."""
        order = self.effort_order(efforts)
        self.take(order)
        return order

    def joint_command(self, names: Sequence[str], efforts: Sequence[float]) -> Order:
        """Check and take up efforts for the actuators in ``names``."""
        order = self.joint_order(names, efforts)
        self.take(order)
        return order

    def wrench(self, wrench: Sequence[float], frame: str | None = WORLD, of: str = TIP) -> Order:
        """Check and take up a wrench (6,), moment then force, at the tip or an input load."""
        order = self.wrench_order(wrench, frame, of)
        self.take(order)
        return order

    def drive(
        self,
        names: Sequence[str],
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
    ) -> Order:
        """Check and take up goals of driven coordinates."""
        order = self.drive_order(names, positions, velocities)
        self.take(order)
        return order

    def drive_pose(
        self, joint: str, pose: Sequence[float], twist: Sequence[float] | None = None
    ) -> Order:
        """Check and take up the pose of a free joint at the base."""
        order = self.pose_order(joint, pose, twist)
        self.take(order)
        return order

    def carry(self, name: str, attached: bool) -> None:
        """Attach or drop a payload now; attached, it moves with the arm already."""
        (self.simulation.attach if attached else self.simulation.drop)(name)

    def latch(self, name: str, hold: bool) -> None:
        """Let a constraint act from now on, or release it.

        One whose second frame is ``here`` in the scene holds where its frames are now; of others
        the frames must meet.

        Raises
        ------
        NotMet
            if its frames are apart
        NoSuchPlace
            if there is none of that name
        """
        if not hold:
            self.simulation.release(name)
            return
        k = self.simulation.dynamics.constraints.index(name)
        self.simulation.hold(name, here=bool(self.simulation.model.closures.catches[k]))

    def released(self) -> Order | None:
        """Return the order that gives a timeout to what lasts without one; None: nothing does."""
        channels = np.flatnonzero(self._lasting)
        return Order(channels, self._held[channels]) if len(channels) else None

    # Time.

    def update(self) -> int:
        """Set the simulation's efforts and wrench for its present time.

        Returns
        -------
        int
            For how many steps they stay right, at least 1 (a huge number when nothing is due).
        """
        now, n = self.simulation.time_ns, len(self.names)
        values, steps = self._held, _NEVER
        if self._timeout_ns and self._oldest != _NEVER:
            left = self._oldest + self._timeout_ns - now
            if left < 0:
                values = self._held.copy()
                self._ramp(values, now)
                steps = 1 if self._oldest != _NEVER else _NEVER
            else:
                steps = left // self.simulation.step_ns + 1
        if self._changed:
            self.simulation.set_efforts(values[:n])
        self._changed = False
        for i in np.flatnonzero(self._pushed).tolist():
            wrench = values[n + 6 * i : n + 6 * (i + 1)]
            if i == 0:
                self.simulation.set_tip_wrench(wrench, self._frames[i])
            else:
                self.simulation.set_wrench(self.wrenches[i], wrench, self._frames[i])
            self._pushed[i] = False
        self._set_out()
        return steps

    def _set_out(self) -> None:
        """Send driven coordinates on their ways."""
        for joint, pose in list(self._posing.items()):
            self.simulation.set_driven_pose(joint, pose.pose, pose.twist)
            del self._posing[joint]
        for name, goal in list(self._going.items()):
            self.simulation.set_driven(name, goal.position, goal.velocity)
            del self._going[name]

    def advance(self, steps: int) -> None:
        """Advance the simulation by ``steps``, with the right efforts in every step."""
        steps = whole("steps", steps, 0, MOST_STEPS)
        while steps > 0:
            chunk = min(steps, self.update())
            self.simulation.advance(chunk)
            steps -= chunk

    def reset(self) -> None:
        """Go back to the initial state, safe efforts and no wrench; time goes on."""
        self.simulation.reset()
        self._clear()
        self.update()

    def withdraw(self) -> list[str]:
        """Drop what is in force and keeps the arm from going on, and say what was dropped.

        The wrench goes first; if there is none, all efforts become the safe ones. Nothing that
        was tried with it leaves a trace in what follows. An empty list: nothing was in force.
        """
        first, drives = len(self.names), self._first_drive
        dropped = self._named(slice(first, drives), self._held[first:drives] != 0.0)
        part = slice(first, drives)
        if not dropped:
            part = slice(0, first)
            dropped = self._named(part, self._held[part] != self._safe[part])
        if not dropped and self._active:
            part = slice(drives, None)
            dropped = [name for name in self.commanded if name in self._active]
            for name in dropped:
                self._going[name] = Goal(name, None, 0.0)
            self._active.clear()
        if dropped:
            self._held[part] = self._safe[part]
            self._since[part] = _NEVER
            self._late[part] = self._lasting[part] = False
            self._oldest = int(self._since.min())
            self._changed = True
            self._pushed[:] = True
            self.simulation.forget_attempts()
            self.update()
        return dropped

    def _named(self, part: slice, which: np.ndarray) -> list[str]:
        """Return the names of what channels of ``part`` belong to, of ``which`` of them."""
        return list(dict.fromkeys(self._labels[i + part.start] for i in np.flatnonzero(which)))

    def take_events(self) -> list[tuple[int, str]]:
        """Return what happened by itself since the last call, as (time in ns, text)."""
        events, self._events = self._events, []
        return events

    def _clear(self) -> None:
        self._held = self._safe.copy()
        self._since = np.full(self._safe.shape, _NEVER, dtype=np.int64)
        self._oldest = _NEVER  # the earliest of ``_since``
        self._late: np.ndarray = np.zeros(self._safe.shape, dtype=bool)
        self._lasting: np.ndarray = np.zeros(self._safe.shape, dtype=bool)
        self._frames = [WORLD] * len(self.wrenches)
        self._changed = True  # efforts
        self._pushed: np.ndarray = np.ones(len(self.wrenches), dtype=bool)
        # goals that were taken up and not yet acted on; coordinates that were ever commanded
        self._going: dict[str, Goal] = {}
        self._posing: dict[str, PoseGoal] = {}
        self._active: set[str] = set()

    def _ramp(self, values: np.ndarray, now: int) -> None:
        """Move what is past its timeout at ``now`` towards its safe value, and say so once."""
        due = self._since != _NEVER
        late = np.where(due, now - np.where(due, self._since, 0) - self._timeout_ns, -_NEVER)
        ramping = late > 0
        fresh = ramping & ~self._late & (self._held != self._safe)
        if fresh.any():
            who = self._named(slice(0, None), fresh)
            self._events.append((self.simulation.time_ns, "command_timeout: " + ", ".join(who)))
        self._late = ramping
        drives = self._first_drive
        for i in np.flatnonzero(fresh[drives:]).tolist():  # brought to rest by a way of its own
            self._going[self.commanded[i]] = Goal(self.commanded[i], None, 0.0)
        over = ramping & (late >= self._ramp_ns)
        over[drives:] |= fresh[drives:]
        part = ramping & ~over
        self._changed = True
        self._pushed[:] = True
        values[part] += (late[part] / max(self._ramp_ns, 1)) * (self._safe - self._held)[part]
        values[over] = self._safe[over]
        self._held[over] = self._safe[over]
        self._since[over] = _NEVER
        self._oldest = int(self._since.min())

    def __copy__(self) -> Inputs:
        """Return inputs of the same simulation that hold the same; later orders do not mix."""
        new = object.__new__(type(self))
        for name, value in vars(self).items():
            own = isinstance(value, np.ndarray | list | dict | set)
            setattr(new, name, copy(value) if own else value)
        return new
