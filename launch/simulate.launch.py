"""Start the simulator node: ``ros2 launch soft_sim_ros simulate.launch.py namespace:=arm1``.

Several arms live side by side in namespaces of their own. Only one node of a graph may own time:
start the others with ``clock:=false``.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# argument: (default, type of the parameter, name of the parameter, description)
ARGUMENTS = {
    "scene": ("soft_arm", str, "scene", "scene file, or the name of one in the config folder"),
    "rate": ("1.0", float, "real_time_factor", "simulated seconds per second; 0 = no limit"),
    "record": ("", str, "record", "directory of the recording; empty = none"),
    "clock": ("true", bool, "publish_clock", "publish /clock"),
}


def generate_launch_description() -> LaunchDescription:
    """Describe one simulator node."""
    declared = [
        DeclareLaunchArgument("namespace", default_value="", description="namespace of the arm"),
        *(
            DeclareLaunchArgument(name, default_value=default, description=what)
            for name, (default, _, _, what) in ARGUMENTS.items()
        ),
    ]
    parameters = {
        parameter: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (_, kind, parameter, _) in ARGUMENTS.items()
    }
    node = Node(
        package="soft_sim_ros",
        executable="simulate",
        name="soft_arm",
        namespace=LaunchConfiguration("namespace"),
        parameters=[parameters],
        output="screen",
        emulate_tty=True,
        # A long recording needs a moment to be closed.
        sigterm_timeout="30",
        sigkill_timeout="10",
    )
    return LaunchDescription([*declared, node])
