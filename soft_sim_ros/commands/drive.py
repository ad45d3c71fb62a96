"""The second process of the demo: knows the arm only by its topics, and drives it through them.

``python -m soft_sim_ros.commands.drive SCENE DURATION``; what it did comes as one line of JSON.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
import rclpy
from geometry_msgs.msg import PoseArray, WrenchStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool

from soft_sim_ros.recording.topics import output_topics
from soft_sim_ros.scene import Scene, load_scene
from soft_sim_ros.scene.limbs import limbs_of

ARM = "/soft_arm"
PATIENCE = 30.0  # s of real time without news from the arm
ASK_AGAIN = 1.0  # s of real time without an answer
SMOOTH = 0.6  # part of the programme that is smooth; the rest is steps
PUSH = (0.80, 0.83, (0.0, 0.5, 0.5))  # from and to, as parts of the programme; N


def efforts(time: float, duration: float, limits: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the efforts (A,) at a time in s: a circling wave that travels to the tip, then steps.

    ``limits`` (A, 2) are those of the actuators; about half of them is used. Infinite limits, of
    actuators with none, count as 1.
    """
    high = np.where(np.isfinite(limits[:, 1]), limits[:, 1], 1.0)
    low = np.where(np.isfinite(limits[:, 0]), limits[:, 0], -1.0)
    middle, swing = np.clip(0.0, low, high), 0.5 * (high - low) / 2.0
    index = np.arange(len(limits))
    part = time / duration
    if part < SMOOTH:
        envelope = math.sin(math.pi * part / SMOOTH) ** 2
        phase = 2.0 * math.pi * 0.5 * time - 0.5 * math.pi * (index % 2) + 0.9 * (index // 2)
        wave = envelope * np.sin(phase)
    else:
        step = int((part - SMOOTH) / (1.0 - SMOOTH) * 5)
        wave = np.where((index + step) % 3 == 0, 1.0, np.where((index + step) % 3 == 1, -1.0, 0.0))
        wave = wave if step < 4 else 0.0 * wave
    return np.clip(middle + swing * wave, low, high)


class Driver(Node):
    """Sends a command for every second state that arrives, until the programme is over."""

    def __init__(self, scene: Scene, duration: float, say: Callable[[str], None]) -> None:
        super().__init__("driver")
        self._shape = output_topics(ARM, limbs_of(scene))[0].name
        self._limits = np.array([a.limits for a in scene.actuators], float).reshape(-1, 2)
        self._duration, self._say = duration, say
        self._push = "before"
        self.names: list[str] = []
        self.time = 0.0
        self.states = self.shapes = self.commands = self.wrenches = 0
        self._calls: list[Future] = []
        self._due = 0.0
        self._last_news = time.monotonic()
        one = QoSProfile(depth=1)
        self._command = self.create_publisher(Float64MultiArray, f"{ARM}/command", one)
        self._wrench = self.create_publisher(WrenchStamped, f"{ARM}/external_wrench", one)
        self._pause = self.create_client(SetBool, f"{ARM}/pause")
        self.create_subscription(JointState, "/joint_states", self._on_state, 100)
        # Only counted, so not even decoded.
        self.create_subscription(PoseArray, self._shape, self._on_shape, 100, raw=True)

    def drive(self) -> None:
        """Wait for the arm, let it go, and send the programme."""
        self._wait("the arm", self._connected)
        if (count := self.count_publishers(self._shape)) != 1:
            raise RuntimeError(
                f"{count} arms publish {self._shape} here: set another ROS_DOMAIN_ID"
            )
        self._wait("the arm to go", self._going)
        self._wait("the end of the programme", lambda: self.time >= self._duration)

    def _going(self) -> bool:
        """Ask the arm to go, again and again until it answers: asking twice changes nothing.

        A service is found in several steps, and on a busy machine an answer is lost between them.
        """
        if self.time > 0.0 or any(call.done() for call in self._calls):
            return True
        now = time.monotonic()
        if now >= self._due:
            self._due = now + ASK_AGAIN
            self._calls.append(self._pause.call_async(SetBool.Request(data=False)))
        return False

    def _connected(self) -> bool:
        return bool(
            self._pause.service_is_ready()
            and self._command.get_subscription_count()
            and self._wrench.get_subscription_count()
            and self.count_publishers(self._shape)
            and self.count_publishers("/joint_states")
        )

    def _wait(self, what: str, done: Callable[[], bool]) -> None:
        self._last_news = time.monotonic()
        while not done():
            rclpy.spin_once(self, timeout_sec=0.1)
            if time.monotonic() - self._last_news > PATIENCE:
                raise RuntimeError(f"no news for {PATIENCE:g} s while waiting for {what}")

    def _on_shape(self, _: bytes) -> None:
        self.shapes += 1

    def _on_state(self, state: JointState) -> None:
        self.time = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
        self.names = list(state.name)
        self.states += 1
        self._last_news = time.monotonic()
        if self.time >= self._duration:
            return
        if self.states % 2:
            values = efforts(self.time, self._duration, self._limits)
            self._command.publish(Float64MultiArray(data=values.tolist()))
            self.commands += 1
        self._touch(self.time / self._duration)
        if self.states % 20 == 0:
            self._say(f"driving: t = {self.time:.1f} of {self._duration:g} s")

    def _touch(self, part: float) -> None:
        """Push the tip for a moment, and let go of it."""
        begin, end, force = PUSH
        wanted = "before" if part < begin else "during" if part < end else "after"
        if wanted == self._push:
            return
        self._push = wanted
        message = WrenchStamped()
        if wanted == "during":
            vector = message.wrench.force
            vector.x, vector.y, vector.z = force
        self._wrench.publish(message)
        self.wrenches += 1


def main(argv: Sequence[str] | None = None) -> int:
    """Drive; progress goes to standard error, the result to standard output."""
    scene_name, duration = sys.argv[1:] if argv is None else argv
    rclpy.init(args=[])
    driver = Driver(load_scene(scene_name), float(duration), lambda text: print(text, flush=True))
    try:
        driver.drive()
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        return 130
    except RuntimeError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        driver.destroy_node()
        rclpy.try_shutdown()
    counts = {
        "commands_sent": driver.commands,
        "wrenches_sent": driver.wrenches,
        "joint_states_heard": driver.states,
        "backbones_heard": driver.shapes,
    }
    print(json.dumps(counts), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
