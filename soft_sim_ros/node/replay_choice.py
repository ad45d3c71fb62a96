"""What of a recording is replayed, and under which names."""

from __future__ import annotations

import argparse
import difflib

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.foreign import printable, shown
from soft_sim_ros.node.clock import FASTEST, SLOWEST
from soft_sim_ros.node.start import Parser
from soft_sim_ros.recording.claims import remapped
from soft_sim_ros.recording.reader import Run
from soft_sim_ros.recording.topics import COMMANDS, EVENTS, resolve

CLOCK = "/clock"
_LONGEST = 3600.0  # s of delay


def parser(name: str) -> Parser:
    """Give the parser of what is not for ROS."""
    result = Parser(
        prog=name,
        description="Republish a recording with its types, quality of service and timing, "
        "and drive /clock.",
    )
    result.add_argument("directory", help="rosbag2 directory, or one MCAP file")
    result.add_argument(
        "--rate",
        type=_rate,
        default=1.0,
        metavar="R",
        help="recorded seconds per second; 0 = as fast as possible (default 1)",
    )
    result.add_argument("--loop", action="store_true", help="begin again at the end")
    result.add_argument("--no-clock", action="store_true", help="leave /clock to another program")
    which = result.add_mutually_exclusive_group()
    which.add_argument(
        "--topics",
        nargs="+",
        metavar="TOPIC",
        help="these only, commands among them: as recorded, or as the node has them (~/backbone)",
    )
    which.add_argument(
        "--commands-only",
        action="store_true",
        help="commands and external wrenches only, to a running arm; without /clock",
    )
    which.add_argument(
        "--with-commands", action="store_true", help="republish commands and external wrenches too"
    )
    result.add_argument(
        "--delay",
        type=_delay,
        default=2.0,
        metavar="S",
        help="seconds left to subscribers for finding the topics (default 2)",
    )
    result.add_argument(
        "--wait-for",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="after the delay, begin only when these, as recorded, have a subscriber; /clock too",
    )
    return result


def chosen(run: Run, options: argparse.Namespace, namespace: str) -> dict[str, str]:
    """Return the recorded topics to be replayed, with the names that they are given.

    They are named as they were heard, remappings included. In another namespace than the root,
    they move from the recorded node's namespace there, with their own names.

    Parameters
    ----------
    run : Run
        The recording.
    options : argparse.Namespace
        Of `parser`.
    namespace : str
        Of the node that replays.

    Raises
    ------
    RecordingError
        If there are no commands, or a topic that is asked for is not there.
    """
    there = list(dict.fromkeys(channel.topic for channel in run.channels))
    if options.topics is not None:
        wanted = [_recorded(run, there, name) for name in options.topics]
    else:
        commands = command_topics(run)
        wanted = [
            topic
            for topic in there
            if options.with_commands or (topic in commands) == options.commands_only
        ]
    if options.commands_only and not wanted:
        raise RecordingError(run.path, "has no commands to be replayed")
    heard = remapped(run.path, run.metadata)
    if namespace == "/":
        return {topic: heard.get(topic, topic) for topic in wanted}
    return {topic: _moved(run, topic, namespace) for topic in wanted}


def waited_for(run: Run, options: argparse.Namespace) -> list[str]:
    """Return the recorded topics, and ``/clock``, without whose subscribers nothing begins.

    Raises
    ------
    RecordingError
        If one of them is not there.
    """
    there = list(dict.fromkeys(channel.topic for channel in run.channels))
    return [CLOCK if t == CLOCK else _recorded(run, there, t) for t in options.wait_for]


def _recorded(run: Run, there: list[str], name: str) -> str:
    """Return the recorded topic that a name of the command line means."""
    node = run.metadata.get("node", "")
    own = resolve(name, node) if node else name
    for topic in (name, own):
        if topic in there:
            return topic
    near = difflib.get_close_matches(own[:200], there, n=1, cutoff=0.0)
    hint = f"; the nearest is {printable(near[0])}" if near else ""
    raise RecordingError(run.path, f"has no topic {shown(name, 200)}{hint}")


def _moved(run: Run, topic: str, namespace: str) -> str:
    """Return a topic's name in another namespace than that of the recorded node."""
    old = run.metadata.get("node", "").rpartition("/")[0]
    inside = topic.startswith(f"{old}/")
    return namespace + (topic.removeprefix(old) if inside else topic)


def command_topics(run: Run) -> set[str]:
    """Names of the recorded topics on which the arm was commanded."""
    node = run.metadata.get("node")
    names = [name for name, _, _ in COMMANDS.values()]
    here = [channel.topic for channel in run.channels]
    if node is None:
        ends = tuple(name.removeprefix("~") for name in names)
        return {t for t in here if t.endswith(ends) or t.rpartition("/")[0].endswith(ends)}
    known = {resolve(name, node) for name in names}
    return known | {t for t in here if t.rpartition("/")[0] in known}


def event_topic(run: Run) -> str | None:
    """Name of the recorded topic with the events of the arm; None where no arm is known."""
    node = run.metadata.get("node")
    return None if node is None else resolve(EVENTS["events"][0], node)


def _rate(text: str) -> float:
    value = _number(text)
    if value == 0.0 or SLOWEST <= value <= FASTEST:
        return value
    raise argparse.ArgumentTypeError(f"{shown(text)}: expected 0, or {SLOWEST:g} to {FASTEST:g}")


def _delay(text: str) -> float:
    value = _number(text)
    if 0.0 <= value <= _LONGEST:
        return value
    raise argparse.ArgumentTypeError(f"{shown(text)}: expected 0 to {_LONGEST:g} s")


def _number(text: str) -> float:
    """Return the number a text means; one that fits nowhere if it means none."""
    try:
        return float(text)
    except ValueError:
        return float("nan")
