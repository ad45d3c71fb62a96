"""The state at which a simulation begins."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.scene.body import ROUNDING, Body, FlexibleLink, Rod
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats

STATES = ("reference", "equilibrium")


@dataclass(frozen=True, eq=False)
class Initial:
    """The reference shape with offsets, or the static equilibrium found from there.

    positions and velocities by name of a joint or floating-frame link: a number for a joint of one
    coordinate (rad or m), else an array in the order of its ``coordinates``; the velocity of a
    spherical joint is the angular velocity in the frame after it, of a free one the twist
    (angular, linear) in that frame. guesses are positions of joints that an equilibrium does not
    hold: the search begins there. strains by "rod/section", (6,) offsets from ξ₀, constant along
    the section.
    """

    state: str = "reference"
    positions: dict[str, float | Floats] = field(default_factory=dict)
    velocities: dict[str, float | Floats] = field(default_factory=dict)
    strains: dict[str, Floats] = field(default_factory=dict)
    guesses: dict[str, float | Floats] = field(default_factory=dict)


def read_initial(reader: Reader, bodies: tuple[Body, ...]) -> Initial:
    """Read ``initial``."""
    moving = [body for body in bodies if isinstance(body, (Joint, FlexibleLink))]
    moving = [body for body in moving if body.coordinates and not getattr(body, "driven", ())]
    sections = {
        f"{rod.name}/{section.name}": rod.strains
        for rod in bodies
        if isinstance(rod, Rod)
        for section in rod.sections
    }
    reader.only("state", "positions", "velocities", "strains", "guesses")
    state = reader.choice("state", STATES, default="reference")
    if state != "equilibrium":
        reader.no_effect("guesses", "state: reference begins at positions, nothing is searched")
    positions = _read_positions(reader.mapping("positions"), moving)
    guesses = _read_positions(reader.mapping("guesses"), moving)
    for name in positions.keys() & guesses.keys():
        reader.mapping("guesses").refuse("no joint that positions hold", name)
    velocities = _read_joint_values(reader.mapping("velocities"), moving)
    strains: dict[str, Floats] = {}
    by_section = reader.mapping("strains").only(*sections)
    for name, active in sections.items():
        if by_section.has(name):
            strains[name] = _read_offsets(by_section.mapping(name), active)
    return Initial(state, positions, velocities, strains, guesses)


def _read_positions(
    reader: Reader, moving: list[Joint | FlexibleLink]
) -> dict[str, float | Floats]:
    values = _read_joint_values(reader, moving)
    for joint in moving:
        if not isinstance(joint, Joint):
            continue
        turn = np.linalg.norm(np.atleast_1d(values.get(joint.name, 0.0))[:3])
        if joint.kind in ("spherical", "free") and turn > np.pi * (1.0 + ROUNDING):
            expected = f"a rotation vector no longer than half a turn, not {turn:.4g} rad"
            reader.refuse(expected, joint.name)
    return values


def _read_joint_values(
    reader: Reader, moving: list[Joint | FlexibleLink]
) -> dict[str, float | Floats]:
    reader.only(*(body.name for body in moving))
    values: dict[str, float | Floats] = {}
    for body in moving:
        if reader.has(body.name):
            count = len(body.coordinates)
            one = count == 1 and isinstance(body, Joint)
            values[body.name] = reader.number(body.name) if one else reader.vector(body.name, count)
    return values


def _read_offsets(reader: Reader, active: tuple[str, ...]) -> Floats:
    reader.only(*STRAINS)
    for strain in set(STRAINS) - set(active):
        reader.no_effect(strain, "this strain is not among the rod's strains")
    return frozen([
        reader.number(strain, default=0.0) if strain in active else 0.0 for strain in STRAINS
    ])  # fmt: skip
