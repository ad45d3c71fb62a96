"""The state at which a simulation begins."""

from __future__ import annotations

from dataclasses import dataclass, field

from soft_sim_ros.scene.body import Body, Joint, Rod
from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats

STATES = ("reference", "equilibrium")


@dataclass(frozen=True, eq=False)
class Initial:
    """The reference shape with offsets, or the static equilibrium found from there.

    positions in rad and velocities in rad/s by joint name; strains by "rod/section", (6,)
    offsets from ξ₀, constant along the section.
    """

    state: str = "reference"
    positions: dict[str, float] = field(default_factory=dict)
    velocities: dict[str, float] = field(default_factory=dict)
    strains: dict[str, Floats] = field(default_factory=dict)


def read_initial(reader: Reader, bodies: tuple[Body, ...]) -> Initial:
    """Read ``initial``."""
    joints = [body.name for body in bodies if isinstance(body, Joint) and body.kind == "revolute"]
    sections = {
        f"{rod.name}/{section.name}": rod.strains
        for rod in bodies
        if isinstance(rod, Rod)
        for section in rod.sections
    }
    reader.only("state", "positions", "velocities", "strains")
    state = reader.choice("state", STATES, default="reference")
    positions = _read_joint_values(reader.mapping("positions"), joints)
    velocities = _read_joint_values(reader.mapping("velocities"), joints)
    strains: dict[str, Floats] = {}
    by_section = reader.mapping("strains").only(*sections)
    for name, active in sections.items():
        if by_section.has(name):
            strains[name] = _read_offsets(by_section.mapping(name), active)
    return Initial(state, positions, velocities, strains)


def _read_joint_values(reader: Reader, joints: list[str]) -> dict[str, float]:
    reader.only(*joints)
    return {joint: reader.number(joint) for joint in joints if reader.has(joint)}


def _read_offsets(reader: Reader, active: tuple[str, ...]) -> Floats:
    reader.only(*STRAINS)
    for strain in set(STRAINS) - set(active):
        reader.no_effect(strain, "this strain is not among the rod's strains")
    return frozen([
        reader.number(strain, default=0.0) if strain in active else 0.0 for strain in STRAINS
    ])  # fmt: skip
