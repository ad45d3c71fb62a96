"""A recording made by a node that was driven, pushed, paused, stepped and reset."""

from __future__ import annotations

import time
from pathlib import Path

from geometry_msgs.msg import WrenchStamped
from peer import Peer, simulator, wait_for
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray


def record_eventful_run(folder: Path, peer: Peer) -> Path:
    """Record about two seconds in which everything happens that changes the motion."""
    record = folder / "run"
    program = simulator(
        folder,
        scene=Path(__file__).with_name("arm.yaml"),
        record=record,
        poses=7,
        frame_id="plate",
        command_timeout=0.2,
        command_ramp=0.1,
        control_rate=200,
        joint_command_hold="false",
    )
    states = peer.listen(JointState, "joint_states", 1000)
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    joint_command = peer.talk(JointState, "soft_arm/joint_command")
    wrench = peer.talk(WrenchStamped, "soft_arm/external_wrench")
    wait_for(lambda: states, "the arm to run")

    def push(frame_id: str, y: float) -> None:
        message = WrenchStamped()
        message.header.frame_id = frame_id
        message.wrench.force.y = y
        wrench.publish(message)

    for k in range(30):
        command.publish(Float64MultiArray(data=[0.01 * k, 0.2 - 0.013 * k]))
        time.sleep(0.01)
    joint_command.publish(JointState(name=["yaw"], effort=[0.9]))  # beyond the limit: cut
    push("plate", 0.2)
    command.publish(Float64MultiArray(data=[float("nan"), 0.0]))  # refused, so not recorded
    time.sleep(0.45)  # everything times out and ramps down
    peer.pause(True)
    joint_command.publish(JointState(name=["pitch"], effort=[0.3]))
    push("tip", -0.3)
    time.sleep(0.1)
    peer.trigger("soft_arm/step")
    peer.trigger("soft_arm/step")
    peer.pause(False)
    time.sleep(0.15)
    peer.trigger("soft_arm/reset")
    command.publish(Float64MultiArray(data=[-0.1, 0.1]))
    time.sleep(0.4)
    assert program.end() == 0, program.text
    return record
