"""From a YAML file to a validated scene."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from soft_sim_ros.errors import SceneError, UnfitFile
from soft_sim_ros.files import read_bytes
from soft_sim_ros.paths import config_directory
from soft_sim_ros.scene.actuator import Actuator, read_actuators
from soft_sim_ros.scene.attachment import Attachment, Forest
from soft_sim_ros.scene.body import Body, RigidBody, read_bodies
from soft_sim_ros.scene.constraint import Constraint, read_constraints
from soft_sim_ros.scene.contact import ContactLaw, read_contact
from soft_sim_ros.scene.document import MOST_TEXT, Document
from soft_sim_ros.scene.driven import Commanded
from soft_sim_ros.scene.edit import with_numbers
from soft_sim_ros.scene.environment import Shape, read_environment
from soft_sim_ros.scene.fluid import Fluid
from soft_sim_ros.scene.initial import Initial, read_initial
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.load import DistributedLoad, InputLoad, Load, PointLoad, read_loads
from soft_sim_ros.scene.material import Material, read_material
from soft_sim_ros.scene.numerics import Numerics, read_numerics
from soft_sim_ros.scene.pairs import Pair, read_pairs
from soft_sim_ros.scene.pose import Pose, read_pose
from soft_sim_ros.scene.read_fluid import check_fluid, read_fluid
from soft_sim_ros.scene.read_forest import read_forest
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.sensor import Sensor, read_sensors
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.scene.words import NAME

GRAVITY = (0.0, 0.0, -9.81)


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything a person writes down to have an arm simulated; SI units.

    gravity (3,) in m/s², world frame; base: pose of the base frame in the world frame; bodies: the
    forest, depth first from the base (attachment.py); attachments: by name of a body, where it is
    attached if that is not the end of the body before it; source: the YAML text, tables from other
    files put in; file: where it came from; fluid: what surrounds all bodies, if anything does;
    environment: shapes that bodies can touch; contact: what all contacts have in common;
    constraints: what holds frames at frames; sensors: what is measured; pairs: bodies that touch
    one another.
    """

    name: str
    gravity: Floats
    base: Pose
    bodies: tuple[Body, ...]
    attachments: Mapping[str, Attachment]
    actuators: tuple[Actuator, ...]
    loads: tuple[Load, ...]
    initial: Initial
    numerics: Numerics
    source: str
    file: str
    fluid: Fluid | None = None
    environment: tuple[Shape, ...] = ()
    contact: ContactLaw = ContactLaw()  # noqa: RUF009 - it is immutable
    constraints: tuple[Constraint, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    pairs: tuple[Pair, ...] = ()

    @property
    def touches(self) -> bool:
        """Whether anything can touch: a shape of the environment, or another body."""
        return bool(self.environment or self.pairs)

    @property
    def scheduled_loads(self) -> tuple[PointLoad | DistributedLoad, ...]:
        """The loads with a wrench and a schedule."""
        kinds = PointLoad, DistributedLoad
        return tuple(load for load in self.loads if isinstance(load, kinds))

    @property
    def input_loads(self) -> tuple[InputLoad, ...]:
        """The wrenches that are commanded while the arm moves, in their order."""
        return tuple(load for load in self.loads if isinstance(load, InputLoad))

    @property
    def payloads(self) -> tuple[RigidBody, ...]:
        """The rigid bodies that can be attached and dropped while the arm moves, in their order."""
        bodies = (body for body in self.bodies if isinstance(body, RigidBody))
        return tuple(body for body in bodies if body.attached is not None)

    @property
    def commanded(self) -> dict[str, Commanded]:
        """The driven coordinates that follow commands, by their names, in their order."""
        return {
            name: course
            for body in self.bodies
            if isinstance(body, Joint)
            for name, course in zip(body.coordinates, body.driven, strict=False)
            if isinstance(course, Commanded)
        }

    @property
    def posed(self) -> tuple[str, ...]:
        """The free joints at the base that follow poses: all their coordinates follow commands."""
        commanded, forest = self.commanded, self.forest
        return tuple(
            body.name
            for body in self.bodies
            if isinstance(body, Joint)
            and body.kind == "free"
            and forest.parent(body.name) is None
            and all(name in commanded for name in body.coordinates)
        )

    @property
    def commanded_units(self) -> tuple[str, ...]:
        """Units of those coordinates: rad or m."""
        joints = {
            n: body for body in self.bodies if isinstance(body, Joint) for n in body.coordinates
        }
        return tuple(joints[name].unit_of(name) for name in self.commanded)

    @property
    def forest(self) -> Forest:
        """The bodies and where they are attached."""
        return Forest(self.bodies, self.attachments)

    def with_numbers(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with other numbers at key paths such as ``materials.rubber.density``.

        They are written into its source, which is read again: what was changed in the scene itself
        is not in it.

        Raises
        ------
        SceneError
            if no number is written at a path, or the scene makes no sense with one
        """
        return parse_scene(with_numbers(self.source, self.file, values), self.file)


def load_scene(path_or_name: str | Path) -> Scene:
    """Load a scene from a file, or by name from the scenes that come with the package.

    Parameters
    ----------
    path_or_name : a file, or the name of a packaged scene

    Raises
    ------
    SceneError
        for anything wrong with the file, its syntax or its content
    """
    path = find_scene(path_or_name)
    return parse_scene(read_scene(path), str(path))


def read_scene(path: Path) -> str:
    """Return the text of a scene file, or of one like it; it need not make sense yet."""
    try:
        content = read_bytes(path, 4 * MOST_TEXT)
        return content.decode()
    except UnicodeDecodeError as error:
        expected = f"UTF-8 text (byte {error.start} is not)"
        raise SceneError(str(path), "", "(not text)", expected) from error
    except UnfitFile as error:
        raise SceneError(str(path), "", f"({error.found})", error.expected) from error
    except OSError as error:
        raise SceneError(str(path), "", f"({error.strerror})", "a readable file") from error


def parse_scene(text: str, file: str = "<text>") -> Scene:
    """Make a scene from YAML text; ``file`` is what errors call it."""
    document = Document.parse(text, file)
    reader = Reader(document, document.root)
    reader.only(
        "name",
        "gravity",
        "base",
        "materials",
        "bodies",
        "actuators",
        "constraints",
        "loads",
        "initial",
        "numerics",
        "fluid",
        "environment",
        "contact",
        "sensors",
        "pairs",
    )
    name = reader.name("name", default=_name_of(file))
    gravity = reader.vector("gravity", 3, default=GRAVITY)
    base = read_pose(reader.mapping("base"))
    materials = _read_materials(reader.mapping("materials"))
    entries = reader.entries("bodies", required=True)
    forest = read_forest(entries, read_bodies(entries, materials))
    bodies = forest.bodies
    fluid = read_fluid(reader)
    check_fluid(fluid, entries)
    actuators = read_actuators(reader.entries("actuators"), forest)
    return Scene(
        name=name,
        gravity=gravity,
        base=base,
        bodies=bodies,
        attachments=forest.attachments,
        actuators=actuators,
        loads=read_loads(reader.entries("loads"), bodies),
        initial=read_initial(reader.mapping("initial"), bodies),
        numerics=read_numerics(reader.mapping("numerics"), bodies),
        source=document.source,
        file=file,
        fluid=fluid,
        environment=read_environment(
            reader.entries("environment"), materials, tuple(body.name for body in bodies)
        ),
        contact=read_contact(reader.mapping("contact"), materials),
        constraints=read_constraints(reader.entries("constraints"), bodies),
        sensors=read_sensors(reader.entries("sensors"), bodies, actuators),
        pairs=read_pairs(reader, materials, forest),
    )


def _name_of(file: str) -> str:
    """Make a valid name out of a file name."""
    stem = re.sub(r"[^A-Za-z0-9_]", "_", Path(file).stem)
    return stem if NAME.fullmatch(stem) else f"scene_{stem}"


def _read_materials(reader: Reader) -> dict[str, Material]:
    return {name: read_material(reader.mapping(name), name) for name in reader.keys()}


def find_scene(path_or_name: str | Path) -> Path:
    """Return the file of a scene: the path itself if it exists, else the config folder's file."""
    path = Path(path_or_name)
    if path.is_file():
        return path
    scenes = packaged_scenes()
    if path.name == str(path_or_name) and path.stem in scenes and path.suffix in ("", ".yaml"):
        return scenes[path.stem]
    if path.exists() and not path.is_dir():
        return path  # what it is will be said by who reads it
    close = difflib.get_close_matches(path.stem, scenes, 1)
    hint = f" (did you mean {close[0]}?)" if close else ""
    packaged = f"one of the scenes {', '.join(scenes)}{hint}" if scenes else "(none is installed)"
    expected = f"an existing file or {packaged}"
    found = "(a directory)" if path.is_dir() else "(no such file)"
    raise SceneError(str(path_or_name), "", found, expected)


def packaged_scenes() -> dict[str, Path]:
    """Return the scenes that come with the package, name → file.

    There are none if the package was installed without its data files.
    """
    try:
        folder = config_directory()
    except FileNotFoundError:
        return {}
    return {file.stem: file for file in sorted(folder.glob("*.yaml"))}
