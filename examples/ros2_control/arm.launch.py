"""The default arm under ros2_control: ``ros2 launch examples/ros2_control/arm.launch.py``.

Starts the simulator, robot_state_publisher, the controller manager, and two controllers:
``torques`` is active, ``trajectory`` is loaded and waits to be switched to.
"""

from pathlib import Path

from launch import LaunchDescription
from launch_ros.actions import Node

HERE = Path(__file__).resolve().parent
CONTROLLERS = str(HERE / "controllers.yaml")


def generate_launch_description() -> LaunchDescription:
    """Describe the arm and what controls it."""
    description = {"robot_description": (HERE / "soft_arm.urdf").read_text()}
    # Finer than the controllers' rate, or they would be late by up to one period.
    arm = {"scene": "soft_arm", "publish_rate": 100.0, "clock_rate": 500.0}
    return LaunchDescription(
        [
            Node(
                package="soft_sim_ros",
                executable="simulate",
                name="soft_arm",
                parameters=[arm],
                output="screen",
            ),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[description, {"use_sim_time": True}],
            ),
            # It takes the description from the topic of robot_state_publisher.
            Node(
                package="controller_manager",
                executable="ros2_control_node",
                parameters=[CONTROLLERS],
                output="screen",
            ),
            Node(
                package="controller_manager",
                executable="spawner",
                arguments=["torques", "--param-file", CONTROLLERS],
            ),
            Node(
                package="controller_manager",
                executable="spawner",
                arguments=["trajectory", "--inactive", "--param-file", CONTROLLERS],
            ),
        ]
    )
