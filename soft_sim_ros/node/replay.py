"""A recording on the wire again: original bytes, types, quality of service, order and timing."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections import Counter
from collections.abc import Container, Iterator
from itertools import groupby

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle, InvalidTopicNameException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from soft_sim_ros.errors import RecordingError, SoftSimError
from soft_sim_ros.foreign import one_line, printable, shown
from soft_sim_ros.node.clock import FASTEST, SLOWEST, Pacer
from soft_sim_ros.node.message_types import installed_type
from soft_sim_ros.node.quality import qos_profile
from soft_sim_ros.node.signals import Signals, Stopped
from soft_sim_ros.node.start import Parser, asking_ros, start
from soft_sim_ros.recording.cdr import ClockBuffer
from soft_sim_ros.recording.decode import KNOWN, DecodeError, decode
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.reader import LoggedMessage, Run, read_run
from soft_sim_ros.recording.topics import INPUTS, Qos, resolve

NAME = "replay"
_BREATH = 0.001  # s between instants at rate 0: queues are short and subscribers need the time
_LONGEST = 3600.0  # s of delay
_LAST_SECOND = 2**31 - 1
_PATIENCE = 2.0  # s, at the end, with reliable subscribers that have not yet answered


def main(args: list[str] | None = None) -> int:
    """Replay a recording until its end or a signal; the result is the exit code."""
    args = list(sys.argv[1:] if args is None else args)
    with Signals() as signals:
        try:
            options = start(_parser(), args)
            run = read_run(options.directory)
            with asking_ros("cannot start the node"):
                node = Node(NAME)
                player = Player(node, run, options.rate, options.with_commands)
            signals.when_stopped(player.stop)
            return player.play(options.delay, options.loop)
        except SoftSimError as error:
            print(f"{NAME}: {one_line(error)}", file=sys.stderr)
            return 2
        except Stopped:
            print(f"{NAME}: stopped: before the first message", file=sys.stderr)
            return 0
        finally:
            rclpy.try_shutdown()


class Player:
    """Republishes the messages of a recording and drives ``/clock``.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the publishers.
    run : Run
        What is replayed.
    rate : float
        Recorded seconds per second; 0 = as fast as possible.
    with_commands : bool
        Whether to republish what had been sent to the arm, too: to an arm, not to a viewer.
    """

    def __init__(self, node: Node, run: Run, rate: float, with_commands: bool):
        self._node, self._run = node, run
        self._pacer = Pacer(rate)
        self._stop = threading.Event()
        self.sent: Counter[str] = Counter()
        skipped = set() if with_commands else command_topics(run)
        self._publishers: dict[str, Publisher] = {}
        for channel in run.channels:
            if channel.topic not in skipped and channel.topic not in self._publishers:
                self._offer(channel)
        check(run, self._publishers)
        self._clock = node.create_publisher(Clock, "/clock", qos_profile(Qos()))
        self._clock_bytes = ClockBuffer()

    def _offer(self, channel: Channel) -> None:
        """Make the publisher of a topic, unless nothing here knows its type."""
        kind, name = installed_type(channel.type), printable(channel.topic)
        if kind is None or channel.encoding != "cdr":
            self._node.get_logger().warning(
                f"left out: {name} has messages of type {printable(channel.type)!r} in "
                f"{printable(channel.encoding)!r}: expected CDR of an installed type"
            )
            return
        try:
            publisher = self._node.create_publisher(kind, channel.topic, qos_profile(channel.qos))
        except (ValueError, RuntimeError, InvalidHandle, InvalidTopicNameException) as error:
            reason = f"has a topic that cannot be published, {name!r}: {error}"
            raise RecordingError(self._run.path, reason) from error
        self._publishers[channel.topic] = publisher

    def stop(self) -> None:
        """End as soon as possible; safe in a signal handler."""
        self._stop.set()

    def play(self, delay: float, loop: bool) -> int:
        """Replay once, or until stopped; prints what was sent."""
        log = self._node.get_logger()
        run = self._run
        log.info(f"{one_line(run.path)}: {run.duration:.3f} s from t = {run.start:.3f} s")
        self._stop.wait(delay)  # for subscribers to find the publishers
        begin = time.monotonic()
        passes = 0
        while not self._stop.is_set():
            self._pacer.begin()
            self._once()
            passes += 1
            if not loop:
                break
        elapsed = time.monotonic() - begin
        self._let_them_arrive()
        for topic in self._publishers:
            log.info(f"{self.sent[topic]:8d}  {one_line(topic)}")
        stopped = "stopped" if self._stop.is_set() else "done"
        total = sum(self.sent.values())
        log.info(f"{stopped}: {total} messages, {passes} passes, {elapsed:.3f} s")
        self._node.destroy_node()
        return 0

    def _let_them_arrive(self) -> None:
        """Stay until reliable subscribers have everything, but not for ever."""
        deadline = time.monotonic() + _PATIENCE
        for publisher in self._publishers.values():
            left = deadline - time.monotonic()
            if left > 0.0 and not self._stop.is_set():
                publisher.wait_for_all_acked(Duration(seconds=left))

    def _once(self) -> None:
        for time_ns, messages in self._instants():
            self._pacer.wait(time_ns, self._stop.is_set)
            if self._stop.is_set():
                return
            for message in messages:
                self._publishers[message.topic].publish(message.data)
                self.sent[message.topic] += 1
            self._clock.publish(self._clock_bytes.fill(time_ns))
            if self._pacer.factor == 0.0:
                time.sleep(_BREATH)

    def _instants(self) -> Iterator[tuple[int, Iterator[LoggedMessage]]]:
        wanted = (m for m in self._run.messages() if m.topic in self._publishers)
        return groupby(wanted, key=lambda message: message.time_ns)


def check(run: Run, wanted: Container[str]) -> None:
    """Refuse a recording with messages that no clock can show, or that are not what they say.

    Raises
    ------
    RecordingError
        with the first of them
    """
    if run.end > _LAST_SECOND:
        reason = f"ends at t = {run.end:.6g} s: expected at most {_LAST_SECOND} s, as ROS has it"
        raise RecordingError(run.path, reason)
    for message in run.messages():
        if message.topic in wanted and message.type in KNOWN:
            try:
                decode(message.type, message.data)
            except DecodeError as error:
                place = f"{printable(message.topic)} at t = {message.time_ns / 1e9:.9g} s"
                raise RecordingError(run.path, f"cannot be replayed, {place}: {error}") from error


def command_topics(run: Run) -> set[str]:
    """Names of the recorded topics on which the arm was commanded."""
    node = run.metadata.get("node")
    ends = [name.removeprefix("~") for name, _, _ in INPUTS.values()]
    if node is None:
        return {c.topic for c in run.channels if any(c.topic.endswith(end) for end in ends)}
    return {resolve(name, node) for name, _, _ in INPUTS.values()}


def _parser() -> Parser:
    parser = Parser(
        prog=NAME,
        description="Republish a recording with its types, quality of service and timing, "
        "and drive /clock.",
    )
    parser.add_argument("directory", help="rosbag2 directory, or one MCAP file")
    parser.add_argument(
        "--rate",
        type=_rate,
        default=1.0,
        metavar="R",
        help="recorded seconds per second; 0 = as fast as possible (default 1)",
    )
    parser.add_argument("--loop", action="store_true", help="begin again at the end")
    parser.add_argument(
        "--with-commands", action="store_true", help="republish commands and external wrenches too"
    )
    parser.add_argument(
        "--delay",
        type=_delay,
        default=2.0,
        metavar="S",
        help="seconds left to subscribers for finding the topics (default 2)",
    )
    return parser


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
