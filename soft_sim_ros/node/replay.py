"""A recording on the wire again: original bytes, types, quality of service, order and timing."""

from __future__ import annotations

import sys
import threading
import time
from collections import Counter
from collections.abc import Container, Iterable, Mapping
from itertools import groupby

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle, InvalidTopicNameException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from soft_sim_ros.errors import RecordingError, SoftSimError
from soft_sim_ros.foreign import one_line, printable
from soft_sim_ros.node.clock import Pacer
from soft_sim_ros.node.message_types import installed_type
from soft_sim_ros.node.quality import qos_profile
from soft_sim_ros.node.replay_choice import CLOCK, chosen, event_topic, parser, waited_for
from soft_sim_ros.node.signals import Signals, Stopped
from soft_sim_ros.node.start import asking_ros, start
from soft_sim_ros.recording.cdr import ClockBuffer
from soft_sim_ros.recording.decode import KNOWN, DecodeError, decode
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.offset import offset_of
from soft_sim_ros.recording.reader import LoggedMessage, Run, read_run
from soft_sim_ros.recording.topics import STRING, Qos

NAME = "replay"
_BREATH = 0.001  # s between instants at rate 0: queues are short and subscribers need the time
_LAST_SECOND = 2**31 - 1
_PATIENCE = 2.0  # s, at the end, with reliable subscribers that have not yet answered
_MATCH = 0.3  # s: a subscriber knows its publisher a little later than the other way round


def main(args: list[str] | None = None) -> int:
    """Replay a recording until its end or a signal; the result is the exit code."""
    args = list(sys.argv[1:] if args is None else args)
    with Signals() as signals:
        try:
            options = start(parser(NAME), args)
            run = read_run(options.directory)
            with asking_ros("cannot start the node"):
                node = Node(NAME)
                player = Player(
                    node,
                    run,
                    chosen(run, options, node.get_namespace()),
                    options.rate,
                    clock=not (options.no_clock or options.commands_only),
                )
            signals.when_stopped(player.stop)
            player.wait_for(waited_for(run, options))
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
    names : dict
        Recorded topics that are replayed, with the names that they are given.
    rate : float
        Recorded seconds per second; 0 = as fast as possible.
    clock : bool
        Whether to drive ``/clock``.
    """

    def __init__(
        self, node: Node, run: Run, names: Mapping[str, str], rate: float, clock: bool = True
    ):
        self._node, self._run = node, run
        self._pacer = Pacer(rate)
        self._stop = threading.Event()
        self.sent: Counter[str] = Counter()
        self._publishers: dict[str, Publisher] = {}
        for channel in run.channels:
            if channel.topic in names and channel.topic not in self._publishers:
                self._offer(channel, names[channel.topic])
        check(run, self._publishers)
        self._events = event_topic(run)
        self._offset_ns = 0  # from the time of the log to the stamps, and to the clock
        for message in run.messages():
            self._is_due(message)  # what is wrong is said before anything is sent
        self._awaited: list[Publisher] = []
        self._clock = node.create_publisher(Clock, CLOCK, qos_profile(Qos())) if clock else None
        self._clock_bytes = ClockBuffer()

    def _offer(self, channel: Channel, topic: str) -> None:
        """Make the publisher of a topic, unless nothing here knows its type."""
        kind, name = installed_type(channel.type), printable(channel.topic)
        if kind is None or channel.encoding != "cdr":
            self._node.get_logger().warning(
                f"left out: {name} has messages of type {printable(channel.type)!r} in "
                f"{printable(channel.encoding)!r}: expected CDR of an installed type"
            )
            return
        try:
            publisher = self._node.create_publisher(kind, topic, qos_profile(channel.qos))
        except (ValueError, RuntimeError, InvalidHandle, InvalidTopicNameException) as error:
            reason = f"has a topic that cannot be published, {printable(topic)!r}: {error}"
            raise RecordingError(self._run.path, reason) from error
        self._publishers[channel.topic] = publisher

    def stop(self) -> None:
        """End as soon as possible; safe in a signal handler."""
        self._stop.set()

    def wait_for(self, topics: Iterable[str]) -> None:
        """Let `play` begin only when each of these topics has a subscriber.

        Raises
        ------
        RecordingError
            If one of them is not replayed.
        """
        for topic in topics:
            publisher = self._clock if topic == CLOCK else self._publishers.get(topic)
            if publisher is None:
                reason = f"would wait for ever for {printable(topic)}: it is not replayed"
                raise RecordingError(self._run.path, reason)
            self._awaited.append(publisher)

    def _wait_for_subscribers(self) -> None:
        """Wait until somebody hears what is waited for; discovery takes as long as it takes."""
        log = self._node.get_logger()
        for publisher in self._awaited:
            if publisher.get_subscription_count() == 0:
                log.info(f"waiting for a subscriber of {one_line(publisher.topic_name)}")
            while publisher.get_subscription_count() == 0 and not self._stop.wait(0.02):
                pass
        if self._awaited:
            self._stop.wait(_MATCH)

    def play(self, delay: float, loop: bool) -> int:
        """Replay once, or until stopped; prints what was sent."""
        log = self._node.get_logger()
        run = self._run
        log.info(f"{one_line(run.path)}: {run.duration:.3f} s from t = {run.start:.3f} s")
        self._stop.wait(delay)  # for subscribers to find the publishers
        self._wait_for_subscribers()
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
        for topic, publisher in self._publishers.items():
            name = publisher.topic_name
            now = "" if name == topic else f", as {one_line(name)}"
            heard = "" if publisher.get_subscription_count() else " (no subscriber)"
            log.info(f"{self.sent[topic]:8d}  {one_line(topic)}{now}{heard}")
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
        self._offset_ns = 0
        for time_ns, messages in groupby(self._run.messages(), key=lambda one: one.time_ns):
            due: list[LoggedMessage] = []
            for message in messages:
                before = self._offset_ns
                wanted = self._is_due(message)
                if self._offset_ns != before:  # what came before it has the time of before
                    self._send(due, time_ns, before)
                    due = []
                if wanted:
                    due.append(message)
            self._send(due, time_ns, self._offset_ns)
            if self._stop.is_set():
                return

    def _send(self, due: list[LoggedMessage], time_ns: int, offset_ns: int) -> None:
        """Publish the messages of one instant when it has come, and its time."""
        if not due:
            return
        self._pacer.wait(time_ns, self._stop.is_set)
        if self._stop.is_set():
            return
        for message in due:
            self._publishers[message.topic].publish(message.data)
            self.sent[message.topic] += 1
        if self._clock is not None:
            self._clock.publish(self._clock_bytes.fill(time_ns + offset_ns))
        if self._pacer.factor == 0.0:
            time.sleep(_BREATH)

    def _is_due(self, message: LoggedMessage) -> bool:
        """Whether a message is replayed; one that tells of the time is heeded in any case."""
        if message.topic == self._events and message.type == STRING:
            try:
                self._heed(message)
            except (DecodeError, ValueError) as error:
                raise _unfit(self._run, message, error) from error
        return message.topic in self._publishers

    def _heed(self, message: LoggedMessage) -> None:
        text = decode(message.type, message.data)
        offset = offset_of(text) if isinstance(text, str) else None
        if offset is None:
            return
        first = (message.time_ns + offset) * 1e-9
        if not 0.0 <= first <= _LAST_SECOND - self._run.duration:
            raise ValueError(f"stamps from {first:.9g} s on are expected within ROS's time")
        self._offset_ns = offset


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
                raise _unfit(run, message, error) from error


def _unfit(run: Run, message: LoggedMessage, error: Exception) -> RecordingError:
    place = f"{printable(message.topic)} at t = {message.time_ns / 1e9:.9g} s"
    return RecordingError(run.path, f"cannot be replayed, {place}: {error}")
