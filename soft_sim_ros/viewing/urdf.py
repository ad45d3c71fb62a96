"""An arm as URDF, for robot_state_publisher, MoveIt and ros2_control.

Joints are exact. URDF has no soft links: a rod is a chain of rigid links in its reference shape,
for display. Actuators that drive no joint (moments, tendons, chambers) are joints of links without
size, so that ros2_control knows them; what moves the arm is the node.
"""

from __future__ import annotations

from xml.etree import ElementTree as Xml

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.scene import FlexibleLink, Joint, RigidBody, Rod
from soft_sim_ros.scene.actuator import Actuator, JointActuator, TendonActuator
from soft_sim_ros.scene.cross_section import Rectangle
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing.frames import BASE, Frames, Spot
from soft_sim_ros.viewing.outline import outline
from soft_sim_ros.viewing.tube import rotations

PIECES = 12  # links of one rod
FAST, FAR = 1e3, 1e3  # rad/s or m/s, m: scenes set no such limits, and URDF asks for some
PLUGIN = "joint_state_topic_hardware_interface/JointStateTopicSystem"


class Urdf:
    """A robot description under construction.

    Parameters
    ----------
    compiled : the arm
    frame_id : name of the root link: the node's frame of poses
    node : full name of the node, such as ``/soft_arm``
    """

    def __init__(self, compiled: Compiled, frame_id: str = "world", node: str = "/soft_arm"):
        self._compiled, self._scene = compiled, compiled.scene
        self._node = node
        self.robot = Xml.Element("robot", name=self._scene.name)
        self.robot.append(Xml.Comment(_NOTE))
        limits = Bounds.of_arm(self._scene, compiled.length).efforts
        self._most = np.abs(limits).max(axis=1)
        self._driven: dict[tuple[str, int], Actuator] = {}
        for actuator in self._scene.actuators:
            if isinstance(actuator, JointActuator):
                self._driven.setdefault((actuator.joint, actuator.axis), actuator)
        self._taken = {actuator.name for actuator in self._scene.actuators}
        self._spots: list[Spot] = []
        self._link(frame_id)
        self._root = self._last = frame_id
        self._pose = np.eye(4)
        self._links = {frame_id: self._pose}
        self._ends: dict[str | None, str] = {None: "base_link"}

    def build(self) -> str:
        """Return the XML."""
        self._fixed("base_link", self._at(BASE))
        for body in self._scene.bodies:
            self._go_on_from(self._holder(body.name))
            if isinstance(body, Joint):
                self._joint(body)
            elif isinstance(body, RigidBody):
                self._rigid_body(body)
            else:
                self._rod(body.rod if isinstance(body, FlexibleLink) else body)
            self._ends[body.name] = self._last
        self._fixed("tip_link", self._at("tip"))
        for actuator in self._scene.actuators:
            if actuator not in self._driven.values():
                self._port(actuator)
        self._control()
        Xml.indent(self.robot)
        return '<?xml version="1.0"?>\n' + Xml.tostring(self.robot, "unicode") + "\n"

    def _holder(self, name: str) -> str:
        """Return the link that a body hangs on: the end of its parent, or a piece of that rod."""
        attachment = self._scene.attachments.get(name)
        if attachment is None or attachment.parent is None or attachment.s is None:
            return self._ends[self._scene.forest.parent(name)]
        rod = self._compiled.chain.rods[attachment.parent].rod
        return f"{rod.name}_{min(int(attachment.s / rod.length * PIECES), PIECES - 1)}"

    def _go_on_from(self, link: str) -> None:
        self._last, self._pose = link, self._links[link]

    def _at(self, name: str, s: float = 0.0) -> Floats:
        """Return a pose (4, 4) of the arm in the world, all coordinates zero."""
        q = np.zeros(len(self._compiled.coordinate_names))
        pose = Frames(self._compiled, q, [(name, s)]).poses()
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = rotations(pose[:, 3:])[0], pose[0, :3]
        return out

    def _link(self, name: str) -> Xml.Element:
        return Xml.SubElement(self.robot, "link", name=name)

    def _connect(self, name: str, kind: str, link: str, pose: Floats) -> Xml.Element:
        """Add a joint of ``kind`` from the last link to a new one that is at ``pose``."""
        joint = Xml.SubElement(self.robot, "joint", name=name, type=kind)
        Xml.SubElement(joint, "parent", link=self._last)
        Xml.SubElement(joint, "child", link=link)
        joint.append(_origin(se3.inverse(self._pose) @ pose))
        self._links[link] = pose
        self._go_on_from(link)
        return joint

    def _fixed(self, link: str, pose: Floats) -> Xml.Element:
        self._connect(f"{link}_fixed", "fixed", link, pose)
        return self._link(link)

    def _joint(self, joint: Joint) -> None:
        pose = self._at(joint.name)
        if joint.driven:
            self.robot.append(Xml.Comment(f" {joint.name} is driven by the scene: no effort "))
        if joint.kind in ("fixed", "spherical"):
            if joint.kind == "spherical":
                self.robot.append(Xml.Comment(f" {joint.name} is spherical: fixed here "))
            self._fixed(joint.name, pose)
        elif joint.kind == "free":
            self._connect(self._unused(joint.name), "floating", joint.name, pose)
            self._link(joint.name)
        else:
            kind = "prismatic" if joint.kind == "prismatic" else "continuous"
            for axis, (name, vector) in enumerate(zip(joint.coordinates, joint.axes, strict=True)):
                actuator = self._driven.get((joint.name, axis))
                own = self._unused(name) if actuator is None else actuator.name
                link = joint.name if axis == len(joint.axes) - 1 else f"{name}_link"
                element = self._connect(own, kind, link, pose)
                Xml.SubElement(element, "axis", xyz=_text(vector))
                effort = 0.0 if actuator is None else self._effort(actuator)
                _limit(element, kind, effort)
                Xml.SubElement(element, "dynamics", damping=f"{joint.damping:g}", friction="0")
                self._link(link)

    def _rigid_body(self, body: RigidBody) -> None:
        link = self._fixed(body.name, self._at(body.name))
        com = se3.pose_matrix(body.com.position, body.com.quaternion)
        inertial = Xml.SubElement(link, "inertial")
        inertial.append(_origin(com))
        Xml.SubElement(inertial, "mass", value=f"{body.mass:.9g}")
        moments = {f"i{a}{a}": f"{i:.9g}" for a, i in zip("xyz", body.inertia, strict=True)}
        Xml.SubElement(inertial, "inertia", moments, ixy="0", ixz="0", iyz="0")
        # the box with the same mass and moments
        square = 6.0 / body.mass * (body.inertia.sum() - 2.0 * body.inertia)
        size = np.sqrt(np.maximum(square, 0.0))
        size = np.maximum(size, 0.05 * size.max() if size.any() else 0.02 * self._compiled.length)
        _visual(link, "box", com, size=_text(size))

    def _rod(self, rod: Rod) -> None:
        """Add a rod as rigid pieces, each seen as a cylinder or a box."""
        ends = np.array(rod.boundaries)
        for number, s in enumerate((np.arange(PIECES) + 0.5) * rod.length / PIECES):
            index = min(int(np.searchsorted(ends, s, side="right")) - 1, len(rod.sections) - 1)
            section = rod.sections[index]
            x = (s - ends[index]) / (ends[index + 1] - ends[index])
            link = self._fixed(f"{rod.name}_{number}", self._at(rod.name, float(s)))
            length = rod.length / PIECES
            edge = outline(section.cross_section, float(x))
            if isinstance(section.cross_section, Rectangle):
                size = np.array([length, *np.ptp(edge, axis=0)])
                _visual(link, "box", np.eye(4), size=_text(size))
            else:
                along = se3.pose_matrix(np.zeros(3), np.array([0.0, np.sqrt(0.5), 0, np.sqrt(0.5)]))
                radius = float(np.linalg.norm(edge, axis=1).mean())
                _visual(link, "cylinder", along, radius=f"{radius:.9g}", length=f"{length:.9g}")
        self._fixed(f"{rod.name}_end", self._at(rod.name, rod.length))

    def _port(self, actuator: Actuator) -> None:
        """Add a joint of a link without size, at the root: its position is that of the port."""
        self._go_on_from(self._root)
        kind = "continuous" if actuator.units.position == "rad" else "prismatic"
        element = self._connect(actuator.name, kind, f"{actuator.name}_port", np.eye(4))
        Xml.SubElement(element, "axis", xyz="1 0 0")
        _limit(element, kind, self._effort(actuator))
        self._link(f"{actuator.name}_port")

    def _effort(self, actuator: Actuator) -> float:
        return float(self._most[self._scene.actuators.index(actuator)])

    def _unused(self, name: str) -> str:
        return f"{name}_joint" if name in self._taken else name

    def _control(self) -> None:
        if not self._scene.actuators:
            return
        control = Xml.SubElement(self.robot, "ros2_control", name=self._scene.name, type="system")
        hardware = Xml.SubElement(control, "hardware")
        Xml.SubElement(hardware, "plugin").text = PLUGIN
        namespace = self._node.rpartition("/")[0]
        for name, value in (
            ("joint_commands_topic", f"{self._node}/joint_command"),
            ("joint_states_topic", f"{namespace}/joint_states"),
            ("trigger_joint_command_threshold", "1e-5"),
        ):
            Xml.SubElement(hardware, "param", name=name).text = value
        for actuator in self._scene.actuators:
            joint = Xml.SubElement(control, "joint", name=actuator.name)
            wound = isinstance(actuator, TendonActuator) and actuator.control == "length"
            Xml.SubElement(joint, "command_interface", name="position" if wound else "effort")
            for name in ("position", "velocity", "effort"):
                Xml.SubElement(joint, "state_interface", name=name)


_NOTE = """ Made by soft_sim_ros. Joints are exact. Rods are soft: their links are fixed to each
  other in the reference shape, for display (~/markers shows the moving arm). Joints that end in
  links called ..._port are actuators that drive no joint. """


def _limit(joint: Xml.Element, kind: str, effort: float) -> None:
    limit = Xml.SubElement(joint, "limit", effort=f"{effort:.9g}", velocity=f"{FAST:g}")
    if kind == "prismatic":
        limit.attrib |= {"lower": f"{-FAR:g}", "upper": f"{FAR:g}"}


def _visual(link: Xml.Element, kind: str, pose: Floats, **size: str) -> None:
    for tag in ("visual", "collision"):
        element = Xml.SubElement(link, tag)
        element.append(_origin(pose))
        Xml.SubElement(Xml.SubElement(element, "geometry"), kind, size)


def _origin(pose: Floats) -> Xml.Element:
    """Return the origin of a pose (4, 4): position, and roll, pitch and yaw of Rz·Ry·Rx."""
    r = pose[:3, :3]
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    if np.hypot(r[0, 0], r[1, 0]) > 1e-9:
        roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    else:  # straight up or down: only one of them counts
        roll, yaw = np.arctan2(-r[1, 2], r[1, 1]), 0.0
    return Xml.Element("origin", xyz=_text(pose[:3, 3]), rpy=_text(np.array([roll, pitch, yaw])))


def _text(vector: Floats) -> str:
    rounded = np.where(np.abs(vector) < 1e-15, 0.0, vector)
    return " ".join(f"{value:.9g}" for value in rounded)
