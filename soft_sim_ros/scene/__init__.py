"""Scenes: what a person writes (YAML, SI units) as validated, frozen dataclasses."""

from soft_sim_ros.scene.actuator import (
    Actuator,
    ChamberActuator,
    JointActuator,
    MomentActuator,
    TendonActuator,
)
from soft_sim_ros.scene.attachment import BASE, Attachment, Forest
from soft_sim_ros.scene.body import Body, FlexibleLink, RigidBody, Rod
from soft_sim_ros.scene.constraint import Constraint
from soft_sim_ros.scene.contact import BodyContact, ContactLaw, Friction
from soft_sim_ros.scene.environment import Shape, Solid
from soft_sim_ros.scene.initial import Initial
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.law import Curve, Rivlin, register_law
from soft_sim_ros.scene.load import DistributedLoad, InputLoad, Load, PointLoad, Schedule
from soft_sim_ros.scene.load_scene import Scene, load_scene, packaged_scenes, parse_scene
from soft_sim_ros.scene.material import Material, Maxwell
from soft_sim_ros.scene.numerics import BASES, INTEGRATORS, Basis, Free, Numerics
from soft_sim_ros.scene.pairs import Pair
from soft_sim_ros.scene.pose import Pose
from soft_sim_ros.scene.profile import register_profile
from soft_sim_ros.scene.reference import Reference
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.sensor import Sensor
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.summary import SectionSummary, summary, total_mass

__all__ = [
    "BASE", "BASES", "INTEGRATORS", "STRAINS", "Actuator", "Attachment", "Basis", "Body",
    "BodyContact", "ChamberActuator", "Constraint", "ContactLaw", "Curve", "DistributedLoad",
    "FlexibleLink", "Forest", "Free", "Friction", "Initial", "InputLoad", "Joint",
    "JointActuator", "Load", "Material", "Maxwell", "MomentActuator", "Numerics", "Pair",
    "PointLoad",
    "Pose", "Reference", "RigidBody", "Rivlin", "Rod", "Scene", "Schedule", "Section",
    "SectionSummary", "Sensor", "Shape", "Solid", "TendonActuator", "load_scene",
    "packaged_scenes", "parse_scene", "register_law", "register_profile", "summary", "total_mass",
]  # fmt: skip
