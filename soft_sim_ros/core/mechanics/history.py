"""Refuses scenes with forces that are not functions of q, q̇ and efforts only."""

from __future__ import annotations

from collections.abc import Iterator

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Joint, Material, Rod, Scene, TendonActuator
from soft_sim_ros.scene.custom_load import CustomLoad


def materials(scene: Scene) -> Iterator[Material]:
    """Give the material of every section of every rod."""
    for body in scene.bodies:
        if isinstance(body, Rod):
            yield from (section.material for section in body.sections)


def refuse_branches(scene: Scene, form: str) -> None:
    """Refuse materials with a Maxwell branch: its dashpots have a state of their own."""
    for material in materials(scene):
        if material.maxwell is not None:
            key = f"materials.{material.name}.maxwell"
            value = f"{{ratio: {material.maxwell.ratio:g}, time: {material.maxwell.time:g}}}"
            raise SceneError(scene.file, key, value, f"no such key in {form}")


def refuse_driven(scene: Scene, form: str) -> None:
    """Refuse driven joints: they move by the clock."""
    for body in scene.bodies:
        if isinstance(body, Joint) and body.driven:
            key, expected = f"bodies.{body.name}.driven", f"no such key in {form}"
            raise SceneError(scene.file, key, "(a motion)", expected)


def refuse_custom(scene: Scene, form: str) -> None:
    """Refuse loads by laws of the user's."""
    for i, load in enumerate(scene.loads):
        if isinstance(load, CustomLoad):
            raise SceneError(scene.file, f"loads[{i}].custom", load.name, f"no such key in {form}")


def refuse_fluid(scene: Scene, form: str) -> None:
    """Refuse a surrounding fluid."""
    if scene.fluid is not None:
        raise SceneError(scene.file, "fluid.density", scene.fluid.density, f"no fluid in {form}")


def refuse_constraints(scene: Scene, form: str) -> None:
    """Refuse constraints between frames: they are equations besides those of the motion."""
    if scene.constraints:
        names, expected = ", ".join(one.name for one in scene.constraints), f"none in {form}"
        raise SceneError(scene.file, "constraints", names, expected)


def refuse_tendons(scene: Scene, form: str) -> None:
    """Refuse tendons whose tension is not their effort: commanded lengths, friction."""
    for i, actuator in enumerate(scene.actuators):
        if not isinstance(actuator, TendonActuator):
            continue
        if actuator.control == "length":
            raise SceneError(scene.file, f"actuators[{i}].control", "length", f"tension in {form}")
        if actuator.friction:
            key, value = f"actuators[{i}].friction", actuator.friction
            raise SceneError(scene.file, key, value, f"0 in {form}")


def refuse_environment(scene: Scene, form: str) -> None:
    """Refuse shapes that bodies can touch."""
    if scene.environment:
        shape = scene.environment[0]
        key = f"environment[0].{shape.kind}"
        raise SceneError(scene.file, key, shape.name, f"no environment in {form}")
    if scene.pairs:
        pair = scene.pairs[0]
        expected = f"no bodies that touch one another in {form}"
        raise SceneError(scene.file, pair.key, " and ".join(pair.bodies), expected)
