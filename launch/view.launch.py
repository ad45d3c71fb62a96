"""See an arm in RViz: ``ros2 launch soft_sim_ros view.launch.py scene:=tendon_arm``.

Starts the simulator and RViz with the package's configuration. ``foxglove:=true`` starts
foxglove_bridge as well (``rviz:=false`` leaves RViz out); its layout is in the viewers folder.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# share/<package>/launch and share/<package>/viewers lie side by side, as they do in the sources
VIEWERS = Path(__file__).resolve().parents[1] / "viewers"
# argument: (default, type of the parameter, name of the parameter, description)
ARGUMENTS = {
    "scene": ("soft_arm", str, "scene", "scene file, or the name of one in the config folder"),
    "rate": ("1.0", float, "real_time_factor", "simulated seconds per second; 0 = no limit"),
    "marker_rate": ("30.0", float, "marker_rate", "how often the arm is drawn, Hz"),
    "frame": ("world", str, "frame_id", "frame of the arm; RViz's fixed frame is world"),
    "tf": ("true", bool, "publish_tf", "publish the frames of base and tip"),
    "tf_frames": ("all", str, "tf_frames", "joints and bodies on /tf, too; 'all' for all"),
    "tf_backbone": ("false", bool, "tf_backbone", "frames along the backbone on /tf, too"),
}
SEEN = ("markers", "fixed_markers", "backbone", "tip_pose")


def generate_launch_description() -> LaunchDescription:
    """Describe a simulator node and its viewers."""
    namespace = LaunchConfiguration("namespace")
    declared = [
        DeclareLaunchArgument("namespace", default_value="", description="such as /arm1"),
        DeclareLaunchArgument("rviz", default_value="true", description="start RViz"),
        DeclareLaunchArgument("foxglove", default_value="false", description="start its bridge"),
        *(
            DeclareLaunchArgument(name, default_value=default, description=what)
            for name, (default, _, _, what) in ARGUMENTS.items()
        ),
    ]
    simulator = Node(
        package="soft_sim_ros",
        executable="simulate",
        name="soft_arm",
        namespace=namespace,
        parameters=[
            {
                parameter: ParameterValue(LaunchConfiguration(name), value_type=kind)
                for name, (_, kind, parameter, _) in ARGUMENTS.items()
            }
        ],
        output="screen",
        emulate_tty=True,
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        name="rviz",
        arguments=["-d", str(VIEWERS / "view.rviz")],
        parameters=[{"use_sim_time": True}],
        remappings=[(f"/soft_arm/{key}", [namespace, f"/soft_arm/{key}"]) for key in SEEN],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    bridge = Node(
        package="foxglove_bridge",
        executable="foxglove_bridge",
        name="foxglove_bridge",
        parameters=[{"use_sim_time": True}],
        condition=IfCondition(LaunchConfiguration("foxglove")),
    )
    return LaunchDescription([*declared, simulator, rviz, bridge])
