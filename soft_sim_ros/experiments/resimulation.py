"""Simulate the recorded commands of the recorded scene again, and compare bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import NoSuchPlace, NotMet, RecordingError
from soft_sim_ros.foreign import printable
from soft_sim_ros.recording.claims import facts, machine
from soft_sim_ros.recording.decode import KNOWN, stack
from soft_sim_ros.recording.machine import machine_facts
from soft_sim_ros.recording.offset import OFFSET, offset_of
from soft_sim_ros.recording.orders import (
    ATTACHED,
    DROPPED,
    HELD,
    RELEASED,
    SENDER_LEFT,
    read_order,
)
from soft_sim_ros.recording.reader import LoggedMessage, Run
from soft_sim_ros.recording.sensors import SensorMessages
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import COMMANDS, OUTPUTS, recorded_topics, resolve
from soft_sim_ros.scene import Scene, parse_scene
from soft_sim_ros.scene.limbs import limbs_of

# Facts of the machine on which the last bits of a result may depend.
DECISIVE = (
    "soft_sim_ros", "processor", "architecture", "python", "numpy", "scipy", "numba", "llvmlite",
)  # fmt: skip

LONGEST_GAP = 86_400  # s without a message: more is no recording of a run

# What a re-simulation needs to know beside the scene.
FACTS = ("node", "poses", "frame_id", "command_timeout", "command_ramp")


@dataclass
class Comparison:
    """How far a second simulation is from a recording.

    Parameters
    ----------
    messages : number of messages compared
    different : number of them with any bit different
    first : time in s and topic of the first different one
    largest : largest absolute difference of two numbers, by topic, in the units of the topic
    facts : decisive facts that differ, as (name, recorded, here)
    """

    messages: int = 0
    different: int = 0
    first: tuple[float, str] | None = None
    largest: dict[str, float] = field(default_factory=dict)
    facts: list[tuple[str, str, str]] = field(default_factory=list)

    @property
    def identical(self) -> bool:
        """Whether there is something to compare, and not a bit of it differs."""
        return self.messages > 0 and self.different == 0

    @property
    def difference(self) -> float:
        """Largest difference of all topics."""
        return max(self.largest.values(), default=0.0)


def rerun(
    run: Run,
    scene: Scene | None = None,
    *,
    progress: Callable[[float], None] = lambda time: None,
) -> Comparison:
    """Simulate the recorded commands again and compare every recorded state.

    Parameters
    ----------
    run : the recording, as ``read_run`` returns it
    scene : another scene to drive with the same inputs; the recorded one by default
    progress : called with the simulated time in s after every state

    Raises
    ------
    RecordingError
        if the recording lacks its scene or settings, or is damaged
    """
    return Rerun(run, scene).compare(progress)


class Rerun:
    """The recorded scene, driven by what the recording says came in.

    Parameters
    ----------
    run : the recording
    scene : another scene to drive with the same inputs; the recorded one by default

    Attributes
    ----------
    simulation : the arm that is driven
    topics : name of a topic → its key, such as ``backbone``
    """

    def __init__(self, run: Run, scene: Scene | None = None) -> None:
        self._run = run
        recorded = recorded_scene(run) if scene is None else scene
        known = facts(run.path, run.metadata)
        self.simulation = Simulation(recorded)
        self._inputs = Inputs(
            self.simulation,
            known.command_timeout,
            known.command_ramp,
            recorded_bounds(run, recorded),
        )
        self._frame_id, node = known.frame_id, known.node
        self._lasting = known.joint_command_hold
        limbs = limbs_of(recorded)
        self._telemetry = telemetry = Telemetry(
            self.simulation, known.poses, self._frame_id, node, has_one_label(run), limbs=limbs
        )
        sensors = SensorMessages(
            self.simulation, recorded.sensors, node, lambda: telemetry.offset_ns
        )
        builders = {**telemetry.builders, **sensors.builders}
        self._builders = {t.name: builders[t.key] for t in (*telemetry.topics, *sensors.topics)}
        self.topics = {t.name: t.key for t in recorded_topics(node, limbs)}

    def compare(self, progress: Callable[[float], None] = lambda t: None) -> Comparison:
        """Go through the recording in its order and compare every state in it."""
        result = Comparison(facts=different_facts(self._run))
        result.largest = dict.fromkeys(self._builders, 0.0)
        for message in self.states():
            self._compare(message, result)
            progress(self.simulation.time)
        return result

    def states(self) -> Iterator[LoggedMessage]:
        """Yield every recorded state when the simulation has come to its time, driven alike."""
        for message in self._run.messages():
            self._advance_to(message)
            key = self.topics.get(message.topic)
            if message.topic in self._builders:
                yield message
            elif key is not None and key.partition("/")[0] in COMMANDS:
                data = message.data
                self._inputs.take(
                    read_order(self._inputs, key, data, self._frame_id, self._lasting)
                )
            elif key == "events":
                text = _text(message)
                if text == "reset":
                    self._inputs.reset()
                elif text.startswith((ATTACHED, DROPPED)):
                    self._carry(message, text)
                elif text.startswith((HELD, RELEASED)):
                    self._latch(message, text)
                elif text == SENDER_LEFT:
                    if order := self._inputs.released():
                        self._inputs.take(order)
                elif text.startswith(OFFSET):
                    self._telemetry.offset_ns = self._offset(message, text)
                elif text.startswith("diverged"):
                    self._inputs.update()  # the step that failed had the inputs of its start
                elif text.startswith("withdrawn"):
                    self._inputs.update()
                    self._inputs.withdraw()

    def _carry(self, message: LoggedMessage, text: str) -> None:
        start = ATTACHED if text.startswith(ATTACHED) else DROPPED
        name = text.removeprefix(start)
        if name not in self.simulation.payloads:
            place = f"{message.topic} at t = {message.time_ns / 1e9:.9g} s"
            reason = f"says {printable(text[:60])!r} on {place}: the scene has no such payload"
            raise RecordingError(self._run.path, reason)
        self._inputs.carry(name, start == ATTACHED)

    def _latch(self, message: LoggedMessage, text: str) -> None:
        start = HELD if text.startswith(HELD) else RELEASED
        try:
            self._inputs.latch(text.removeprefix(start), start == HELD)
        except (NoSuchPlace, NotMet) as error:
            place = f"{message.topic} at t = {message.time_ns / 1e9:.9g} s"
            reason = f"says {printable(text[:60])!r} on {place}: {printable(str(error)[:200])}"
            raise RecordingError(self._run.path, reason) from error

    def _offset(self, message: LoggedMessage, text: str) -> int:
        try:
            return offset_of(text) or 0
        except ValueError as error:
            place = f"{message.topic} at t = {message.time_ns / 1e9:.9g} s"
            reason = f"says {printable(text[:60])!r} on {place}: {error}"
            raise RecordingError(self._run.path, reason) from error

    def _advance_to(self, message: LoggedMessage) -> None:
        steps, rest = divmod(message.time_ns - self.simulation.time_ns, self.simulation.step_ns)
        if rest or steps < 0:
            raise RecordingError(
                self._run.path,
                f"{message.topic} has a message at t = {message.time_ns / 1e9:.9f} s, where no "
                f"step of {self.simulation.step_ns / 1e9:g} s begins after "
                f"t = {self.simulation.time:.9f} s",
            )
        if steps * self.simulation.step_ns > LONGEST_GAP * 1_000_000_000:
            gap = f"t = {self.simulation.time:.9g} s and t = {message.time_ns / 1e9:.9g} s"
            reason = f"holds nothing between {gap}: expected at most {LONGEST_GAP} s"
            raise RecordingError(self._run.path, reason)
        self._inputs.advance(steps)

    def _compare(self, message: LoggedMessage, result: Comparison) -> None:
        result.messages += 1
        built = self._builders[message.topic]()
        if built == message.data:
            return
        result.different += 1
        result.first = result.first or (message.time_ns / 1e9, message.topic)
        largest = max(result.largest[message.topic], _distance(message, built))
        result.largest[message.topic] = largest


def recorded_scene(run: Run) -> Scene:
    """Return the scene of a recording that has all that a re-simulation needs.

    Raises
    ------
    RecordingError
        if it lacks something
    """
    source = run.scene_text
    missing = [key for key in FACTS if key not in run.metadata]
    if source is None or missing:
        lacks = ", ".join((["its scene"] if source is None else []) + missing)
        raise RecordingError(run.path, f"cannot be simulated again: it lacks {lacks}")
    return parse_scene(source, f"{run.path}/scene.yaml")


def has_one_label(run: Run) -> bool:
    """Whether the names of the energies are in one label, as they once were."""
    energy = resolve(OUTPUTS["energy"][0], run.metadata.get("node", ""))
    for message in run.messages():
        if message.topic == energy and message.type in KNOWN:
            return len(stack(message.type, [message.data]).texts) == 1
    return False


def recorded_bounds(run: Run, scene: Scene) -> Bounds:
    """Return the bounds of commands that a recording was made with.

    Raises
    ------
    RecordingError
        if they are damaged
    """
    try:
        return Bounds.recorded(scene, run.metadata)
    except ValueError as error:
        raise RecordingError(run.path, f"bounds of commands: {error}") from error


def different_facts(run: Run) -> list[tuple[str, str, str]]:
    """Decisive facts in which the recording's machine and this one differ."""
    recorded = machine(run.path, run.attachments)
    here = machine_facts()
    return [
        (name, recorded.get(name, "unknown"), here.get(name, "unknown"))
        for name in DECISIVE
        if recorded.get(name) != here.get(name)
    ]


def _text(message: LoggedMessage) -> str:
    return stack(message.type, [message.data]).texts[0]


def _distance(message: LoggedMessage, built: bytes) -> float:
    """Largest difference of the numbers of two messages; infinite if they differ in kind."""
    one, other = stack(message.type, [message.data]), stack(message.type, [built])
    alike = one.texts == other.texts and one.frame_id == other.frame_id
    stamps = [[] if s.stamps_ns is None else s.stamps_ns.tolist() for s in (one, other)]
    alike = alike and stamps[0] == stamps[1]
    if not alike or any(a.shape != b.shape for a, b in zip(one.blocks, other.blocks, strict=True)):
        return float("inf")
    with np.errstate(invalid="ignore", over="ignore"):  # infinite numbers
        gaps = [
            float(np.nan_to_num(np.abs(a - b), nan=np.inf).max(initial=0.0))
            for a, b in zip(one.blocks, other.blocks, strict=True)
        ]
    return max(gaps, default=0.0)
