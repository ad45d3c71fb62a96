"""Lock-step co-simulation: an arm and the motors that drive it, each in a program of its own.

This program owns time. It simulates motors with a first-order lag under a PD controller, and
publishes `/clock`. The arm runs as a node with `use_sim_time: true` and goes exactly as far as the
clock says. In every round

1. the tick of time t goes out,
2. the arm answers with its joint states stamped t,
3. the motors make one step to t + dt with what they have heard, and send their torques.

What comes out does not depend on how fast either program is. Start it with

    python examples/co_simulation.py --seconds 2

which starts the arm as well; `--arm /left/soft_arm` uses one that is there already:

    ros2 run soft_sim_ros simulate --ros-args -p use_sim_time:=true
"""

from __future__ import annotations

import argparse
import math
import signal
import subprocess
import sys
import time

import numpy as np
import rclpy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

PATIENCE = 120.0  # s for a state: an arm that starts for the first time compiles its kernels
PERIOD_NS = 10_000_000  # one round; the arm's publish_rate has to be 100 Hz, as it is
LAG = 0.05  # s, of the motors
STIFFNESS, DAMPING = 0.5, 0.02  # of the controller, N·m/rad and N·m·s/rad
SECOND = 1_000_000_000
LONGEST_START = 300.0  # s; the very first start compiles


class Motors:
    """Motors with a lag, whose controller swings the first joint to and fro."""

    def __init__(self, count: int):
        self.torque = np.zeros(count)

    def step(self, time_s: float, position, velocity) -> None:
        """Advance the torques by one period, from what the joints do at its beginning."""
        wanted = np.zeros(len(self.torque))
        wanted[0] = 0.3 * math.sin(2.0 * math.pi * 0.5 * time_s)
        asked = STIFFNESS * (wanted - position) - DAMPING * np.asarray(velocity)
        share = 1.0 - math.exp(-PERIOD_NS / SECOND / LAG)  # exact for a torque asked for so long
        self.torque += share * (asked - self.torque)


class World:
    """Owns time, and waits for the arm in every round."""

    def __init__(self, arm: str):
        self.node = rclpy.create_node("world")
        namespace = arm.rpartition("/")[0]
        self.clock = self.node.create_publisher(Clock, "/clock", 10)
        self.command = self.node.create_publisher(Float64MultiArray, f"{arm}/command", 1)
        topic = f"{namespace}/joint_states"
        self.node.create_subscription(JointState, topic, self._hear, 10)
        self.state: JointState | None = None
        self.time_ns = -1

    def _hear(self, state: JointState) -> None:
        self.state = state
        self.time_ns = state.header.stamp.sec * SECOND + state.header.stamp.nanosec

    def find_arm(self, patience: float) -> None:
        """Wait until the arm listens to everything."""
        end = time.monotonic() + patience
        while not (self.clock.get_subscription_count() and self.command.get_subscription_count()):
            if time.monotonic() > end:
                raise SystemExit(f"no arm that follows /clock within {patience:g} s")
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def round(self, time_ns: int) -> JointState:
        """Move the clock, and wait for the state of that time."""
        tick = Clock()
        tick.clock.sec, tick.clock.nanosec = divmod(time_ns, SECOND)
        again, end = 0.0, time.monotonic() + PATIENCE
        while self.time_ns < time_ns:
            now = time.monotonic()
            if now > end:
                raise SystemExit(f"no state of t = {time_ns / SECOND:g} s within {PATIENCE:g} s")
            if now > again:  # DDS may lose the first tick; the same once more moves nobody
                self.clock.publish(tick)
                again = now + 0.5
            rclpy.spin_once(self.node, timeout_sec=0.1)
        assert self.state is not None
        return self.state


def co_simulate(world: World, seconds: float) -> list[tuple[float, list[float], list[float]]]:
    """Return (time in s, joint positions, torques the arm has felt) of every round."""
    history = []
    motors = None
    for time_ns in range(0, round(seconds * SECOND) + 1, PERIOD_NS):
        state = world.round(time_ns)
        motors = motors or Motors(len(state.name))
        history.append((time_ns / SECOND, list(state.position), list(state.effort)))
        motors.step(time_ns / SECOND, state.position, state.velocity)
        world.command.publish(Float64MultiArray(data=motors.torque.tolist()))
    return history


def main() -> None:
    """Run the motors, and the arm if there is none."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="how long (default 2)")
    parser.add_argument("--scene", default="soft_arm", help="arm to start (default soft_arm)")
    parser.add_argument("--arm", help="full name of an arm that is there, such as /soft_arm")
    options = parser.parse_args()
    child = None
    if options.arm is None:
        words = ["-p", "use_sim_time:=true", "-p", f"scene:={options.scene}"]
        command = [sys.executable, "-m", "soft_sim_ros", "simulate", "--ros-args", *words]
        child = subprocess.Popen(command)
    rclpy.init()
    try:
        world = World(options.arm or "/soft_arm")
        world.find_arm(LONGEST_START)
        begin = time.monotonic()
        history = co_simulate(world, options.seconds)
        taken = time.monotonic() - begin
        swing = max(abs(position[0]) for _, position, _ in history)
        print(f"{len(history)} rounds in {taken:.2f} s; largest angle of joint 0: {swing:.4f} rad")
    finally:
        rclpy.try_shutdown()
        if child is not None:
            child.send_signal(signal.SIGINT)
            child.wait()


if __name__ == "__main__":
    main()
