"""What is published and recorded: names, types and qualities of service."""

from __future__ import annotations

from dataclasses import dataclass, field

from soft_sim_ros.scene.limbs import CHAIN, Limbs

CLOUD = "sensor_msgs/msg/PointCloud2"
FLOATS = "std_msgs/msg/Float64MultiArray"
IMU = "sensor_msgs/msg/Imu"
JOINTS = "sensor_msgs/msg/JointState"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
POSES = "geometry_msgs/msg/PoseArray"
STRING = "std_msgs/msg/String"
WRENCH = "geometry_msgs/msg/WrenchStamped"


@dataclass(frozen=True)
class Qos:
    """Quality of service of a topic; the words are those of rosbag2 and of the ROS command line."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    history: str = "keep_last"


@dataclass(frozen=True)
class Topic:
    """One topic.

    Parameters
    ----------
    key : short name within this package, such as ``backbone``, or ``backbone/left`` where there are
        several
    name : full topic name, such as ``/arm1/soft_arm/backbone``
    type : full message type, such as ``geometry_msgs/msg/PoseArray``
    qos : quality of service offered (or, for inputs, asked for)
    """

    key: str
    name: str
    type: str
    qos: Qos = field(default_factory=Qos)


# key: (name as a node would write it, message type, depth of the queue)
OUTPUTS = {
    "backbone": ("~/backbone", POSES, 10),
    "joint_states": ("joint_states", JOINTS, 10),
    "strain_state": ("~/strain_state", JOINTS, 10),
    "energy": ("~/energy", FLOATS, 10),
    "tip_pose": ("~/tip_pose", POSE, 10),
}
INPUTS = {
    "command": ("~/command", FLOATS, 1),
    "joint_command": ("~/joint_command", JOINTS, 1),
    "external_wrench": ("~/external_wrench", WRENCH, 1),
}
# each with the name of a joint below that of the topic
DRIVES = {
    "drive": ("~/drive", POSE, 1),
    "drive_odometry": ("~/drive_odometry", ODOMETRY, 1),
}
COMMANDS = {**INPUTS, **DRIVES}
# of scenes with contact, and each with the name of a constraint below that of the topic
FELT = {
    "contacts": ("~/contacts", CLOUD, 10),
    "reaction": ("~/reaction", WRENCH, 10),
}
EVENTS = {"events": ("~/events", STRING, 100)}
ALL = {**OUTPUTS, **FELT, **COMMANDS, **EVENTS}
BACKBONE, TIP_POSE, REACTION, CONTACTS = "backbone", "tip_pose", "reaction", "contacts"
# these have names below that of the topic, and nothing else
NAMED = (REACTION, *DRIVES)
# there may be several of each, with names below that of the topic
LIMBS = (BACKBONE, TIP_POSE, "external_wrench", *NAMED)
SENSORS = "sensors"  # ~/sensors/NAME, of several types: sensors.py
# for viewers only, not recorded: they follow from the scene and the recorded topics
MARKERS, FIXED_MARKERS = "markers", "fixed_markers"
VIEWS = {
    MARKERS: ("~/markers", "visualization_msgs/msg/MarkerArray", Qos(1)),
    FIXED_MARKERS: (
        "~/fixed_markers",
        "visualization_msgs/msg/MarkerArray",
        Qos(1, durability="transient_local"),
    ),
}


def resolve(name: str, prefix: str) -> str:
    """Give the full topic name of ``name`` for the node called ``prefix``.

    ``~/x`` lies below the node, ``x`` below its namespace, ``/x`` is absolute.
    """
    if name.startswith("/"):
        return name
    if name.startswith("~/"):
        return f"{prefix}{name[1:]}"
    return f"{prefix.rpartition('/')[0]}/{name}"


def written(key: str) -> str:
    """Give the name of the topic with this key as a node would write it: ``~/command``."""
    kind, slash, limb = key.partition("/")
    return ALL[kind][0] + slash + limb


def topic(key: str, prefix: str, qos: Qos | None = None) -> Topic:
    """Give the topic with this key of the node called ``prefix`` (such as ``/arm1/soft_arm``)."""
    if key in VIEWS:
        name, kind, own = VIEWS[key]
        return Topic(key, resolve(name, prefix), kind, qos or own)
    kind_of, slash, limb = key.partition("/")
    name, kind, depth = ALL[kind_of]
    return Topic(key, resolve(name, prefix) + slash + limb, kind, qos or Qos(depth))


def output_keys(limbs: Limbs = CHAIN) -> list[str]:
    """Give the keys of what a simulation publishes.

    Of several backbones, each has a topic of its own. Of several tips, each has one besides the
    topic of the last one, which is the tip. Contacts and reactions are there where the scene has
    any.
    """
    keys = []
    for key in OUTPUTS:
        if key != BACKBONE or not limbs.several_backbones:
            keys.append(key)
        more = {BACKBONE: limbs.several_backbones, TIP_POSE: limbs.several_tips}.get(key, ())
        keys += [f"{key}/{name}" for name in more]
    keys += [CONTACTS] if limbs.touches else []
    return keys + [f"{REACTION}/{name}" for name in limbs.held]


def output_topics(prefix: str, limbs: Limbs = CHAIN) -> tuple[Topic, ...]:
    """Give the topics a simulation publishes."""
    return tuple(topic(key, prefix) for key in output_keys(limbs))


def input_keys(limbs: Limbs = CHAIN) -> list[str]:
    """Give the keys of what a simulation is commanded by."""
    keys = [*INPUTS, *(f"external_wrench/{name}" for name in limbs.wrenches)]
    return keys + [f"{key}/{name}" for name in limbs.posed for key in DRIVES]


def recorded_topics(prefix: str, limbs: Limbs = CHAIN) -> tuple[Topic, ...]:
    """Give every topic of a recording: outputs, inputs and events."""
    keys = (*input_keys(limbs), *EVENTS)
    return output_topics(prefix, limbs) + tuple(topic(key, prefix) for key in keys)
