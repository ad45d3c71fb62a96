"""Start the simulator node: ``ros2 launch soft_sim_ros simulate.launch.py scene:=tendon_arm``.

Every parameter of the node is an argument of the same name. What is given on the command line
counts more than what is in ``params_file``, and that more than the node's defaults. Several arms
live side by side in namespaces of their own. Only one program of a graph may own time: start the
others with ``use_sim_time:=true``, so that they follow it, or with ``publish_clock:=false``.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# parameter: (type, description)
PARAMETERS = {
    "scene": (str, "scene file, or the name of one in the package's config folder"),
    "name_from": (
        str,
        "what topics and services are called after: node = the node's name, scene = the scene's",
    ),
    "record": (str, "directory of the recording, new or empty; empty = no recording"),
    "real_time_factor": (float, "simulated seconds per second; 0 = as fast as possible"),
    "publish_rate": (float, "state messages per simulated second, Hz"),
    "control_rate": (
        float,
        "how often commands are taken up, per simulated second, Hz; 0 = every step",
    ),
    "command_timeout": (float, "simulated seconds for which a command is held; 0 = for ever"),
    "command_ramp": (
        float,
        "simulated seconds in which a stale effort then goes to the scene's safe value",
    ),
    "joint_command_hold": (
        bool,
        "hold a ~/joint_command while its sender is there; false = command_timeout runs at once",
    ),
    "force_limit": (
        float,
        "N to which the force of an external wrench is cut; 0 = what follows from the arm",
    ),
    "moment_limit": (float, "N·m to which its moment is cut; 0 = what follows from the arm"),
    "frame_id": (str, "frame of poses, and of external wrenches that do not say 'tip'"),
    "poses": (int, "number of backbone poses, base to tip"),
    "publish_clock": (
        bool,
        "publish /clock: exactly one node of a graph may own time; false with use_sim_time",
    ),
    "clock_rate": (float, "messages on /clock per simulated second, Hz; 0 = one with every state"),
    "follow_clock": (
        str,
        "with use_sim_time, how /clock is followed: lock_step = as soon as it has come, "
        "resampled = evenly, one tick behind",
    ),
    "publish_tf": (bool, "publish the frames base and tip on /tf (needs tf2_msgs)"),
    "tf_frames": (str, "joints and rigid bodies also on /tf, with commas; 'all' for all"),
    "tf_backbone": (bool, "publish the backbone's poses as frames on /tf, too"),
    "marker_rate": (
        float,
        "how often the arm is drawn on ~/markers, per real second, Hz; 0 = never",
    ),
    "start_paused": (bool, "wait for ~/pause or ~/step before the first step"),
    "step_count": (int, "steps of one ~/step; 0 = one publish period"),
    "reset_time": (bool, "~/reset also sets the time of stamps back to 0"),
    "exit_on_error": (bool, "end when the solver gives up, instead of holding the last state"),
    "use_sim_time": (bool, "follow the /clock of another program"),
}


def simulator(context) -> list:
    """Return the node with the parameters that are given, and with no others."""
    told = {name: LaunchConfiguration(name).perform(context) for name in PARAMETERS}
    given = {
        name: ParameterValue(text, value_type=PARAMETERS[name][0])
        for name, text in told.items()
        if text
    }
    file = LaunchConfiguration("params_file").perform(context)
    node = Node(
        package="soft_sim_ros",
        executable="simulate",
        name="soft_arm",
        namespace=LaunchConfiguration("namespace"),
        parameters=[*([file] if file else []), *([given] if given else [])],
        output="screen",
        emulate_tty=True,
        # A long recording needs a moment to be closed.
        sigterm_timeout="30",
        sigkill_timeout="10",
    )
    return [node]


def generate_launch_description() -> LaunchDescription:
    """Describe one simulator node."""
    arguments = {
        "namespace": "namespace of the arm",
        "params_file": "file of parameters; empty = none",
        **{name: what for name, (_, what) in PARAMETERS.items()},
    }
    declared = [
        DeclareLaunchArgument(name, default_value="", description=what)
        for name, what in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=simulator)])
