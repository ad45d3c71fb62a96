"""The simulator node, from its parameters to its last message."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node

from soft_sim_ros.core.accuracy.watch import inputs_of
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.foreign import one_line, shown
from soft_sim_ros.node.arguments import check_assignments, parser
from soft_sim_ros.node.clock import Grid, Pacer
from soft_sim_ros.node.commands import Gate
from soft_sim_ros.node.diagnostics import Diagnostics
from soft_sim_ros.node.executor import make_executor
from soft_sim_ros.node.follower import Follower
from soft_sim_ros.node.grid import asked_grid
from soft_sim_ros.node.joint_commands import Senders
from soft_sim_ros.node.parameters import OWN, RESAMPLED, ParameterError, Settings, on_change
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.prepare import simulation_of, warm_up
from soft_sim_ros.node.publishers import Publishers, message_class
from soft_sim_ros.node.quality import OVERRIDABLE, qos_profile
from soft_sim_ros.node.reading import named, read_settings, run_metadata
from soft_sim_ros.node.rivals import Rivals
from soft_sim_ros.node.services import Services
from soft_sim_ros.node.signals import Signals, Stopped
from soft_sim_ros.node.standard import standard_services
from soft_sim_ros.node.start import StartError, asking_ros, start
from soft_sim_ros.node.summary import summarise, write_summary
from soft_sim_ros.node.ticks import OtherClocks, Ticks
from soft_sim_ros.node.views import views_of
from soft_sim_ros.recording.cdr import encode_string
from soft_sim_ros.recording.sensors import SensorMessages, sensor_topics
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import EVENTS, Topic, input_keys, output_topics, topic
from soft_sim_ros.scene import Scene, load_scene
from soft_sim_ros.scene.limbs import limbs_of

if TYPE_CHECKING:
    from soft_sim_ros.recording.writer import BagWriter

NAME = "soft_arm"
ENDED, FAILED, MISUSED, DIVERGED = 0, 1, 2, 3  # exit codes


def main(args: list[str] | None = None) -> int:
    """Run the node until a signal or an error ends it; the result is the exit code.

    ``args`` are the words after the name of the program, those of the process if None.
    """
    args = list(sys.argv[1:] if args is None else args)
    with Signals() as signals:
        try:
            check_assignments(args)
            start(parser(), args)
            return _run(signals, args)
        except StartError as error:
            print(f"{NAME}: {one_line(error)}", file=sys.stderr)
            return MISUSED
        except Stopped as signal:
            print(f"{NAME}: stopped by {signal} before it was ready", file=sys.stderr)
            return ENDED
        finally:
            rclpy.try_shutdown()


def _run(signals: Signals, args: list[str]) -> int:
    with asking_ros("cannot start the node"):
        node = Node(NAME)
    told_as = node.get_fully_qualified_name()
    log = node.get_logger()
    try:
        with asking_ros("cannot start the node"):
            node = named(node, args)
        log = node.get_logger()
        settings = read_settings(node, args, told_as)
        scene = load_scene(settings.scene)
        arm = Arm(node, scene, settings, signals.hold)
    except SoftSimError as error:
        for line in error.lines if isinstance(error, ParameterError) else (error,):
            log.fatal(one_line(line))
        node.destroy_node()
        return MISUSED
    signals.when_stopped(arm.physics.stop)
    try:
        arm.spin()
    finally:
        code = arm.close(signals.received or "an error")
        node.destroy_node()
    return code


class Arm:
    """One simulated arm behind one node.

    Parameters
    ----------
    node : rclpy.node.Node
        A node whose parameters are declared.
    scene : Scene
        The arm.
    settings : Settings
        Values of the parameters.
    hold_signals : callable
        Called when a signal must no longer end the program where it stands.
    """

    def __init__(
        self, node: Node, scene: Scene, settings: Settings, hold_signals: Callable[[], None]
    ):
        self.node, self.settings = node, settings
        prefix = node.get_fully_qualified_name()
        limbs = limbs_of(scene)
        inputs = tuple(topic(key, prefix) for key in input_keys(limbs))
        # The graph comes first: others find it meanwhile, and what is wrong is said at once.
        with asking_ros("cannot publish or subscribe"):
            self.publishers = Publishers(
                node,
                (
                    *output_topics(prefix, limbs),
                    *(topic(key, prefix) for key in EVENTS),
                    *sensor_topics(prefix, scene.sensors),
                ),
                settings.publish_clock,
            )
            self._senders = Senders(lambda: self.physics.release())
            self._subscriptions = [self._subscribe(one) for one in inputs]
            views = views_of(
                node, scene, settings, lambda: self.physics.paused, self.publishers.matched
            )
            self.publishers.after_tick += [view.send for view in views]
        log = node.get_logger()
        log.info(f"starting {shown(scene.name)} of {one_line(scene.file)}")
        doubt = warm_up(scene, settings, node.get_logger().info)
        if doubt:
            log.warning(doubt)
        hold_signals()  # from here on there is a recording to be closed
        self.simulation = simulation_of(scene, node.get_logger().info)
        self.inputs = inputs_of(
            self.simulation,
            settings.command_timeout,
            settings.command_ramp,
            self._warn,
            Bounds.of_arm(
                self.simulation.scene,
                self.simulation.length,
                settings.moment_limit,
                settings.force_limit,
            ),
        )
        self.telemetry = Telemetry(
            self.simulation, settings.poses, settings.frame_id, prefix, limbs=limbs
        )
        for view in views:
            view.show(self.simulation)
        self.gate = Gate(
            self.inputs,
            settings.frame_id,
            lambda *order: self.physics.submit(*order),
            self._warn,
            settings.joint_command_hold,
        )
        self.diagnostics: Diagnostics | None = None
        grid = asked_grid(settings, self.simulation.step_ns, node.get_logger().info)
        self.log = self._open_log((*self.publishers.topics, *inputs), prefix)
        self.physics = Physics(
            self.inputs,
            self.telemetry,
            self.publishers,
            self.log,
            grid,
            self._pacer(grid),
            paused=settings.start_paused,
            exit_on_error=settings.exit_on_error,
            complain=self._complain,
            sensors=SensorMessages(
                self.simulation,
                self.simulation.scene.sensors,
                prefix,
                lambda: self.telemetry.offset_ns,
            ),
        )
        with asking_ros("cannot offer services"):
            self.services = Services(node, self.physics, settings.step_count, settings.reset_time)
            self._standard = standard_services(node, self.physics, settings.frame_id)
        rivals = Rivals(
            node,
            self.publishers.topic_name(self.telemetry.topics[0].key),
            settings.publish_clock,
            self._warn,
            settings.time != OWN,
        )
        clocks = OtherClocks(node, self.telemetry, settings, self._warn)
        self.diagnostics = Diagnostics(node, self.physics, self.gate, rivals, clocks, scene.name)
        on_change(node, self._change)

    # rclpy wants one severity from one place: whoever is handed one of these may have both.

    def _warn(self, text: str) -> None:
        self.node.get_logger().warning(text)

    def _inform(self, text: str) -> None:
        self.node.get_logger().info(text)

    def _complain(self, text: str) -> None:
        self.node.get_logger().error(text)

    def spin(self) -> None:
        """Run until the physics thread ends, which it does when asked to stop or when it fails."""
        executor = make_executor()
        executor.add_node(self.node)
        sys.setswitchinterval(0.0005)  # the physics thread must not wait long for callbacks
        gc.freeze()  # what exists now stays: collections in the run are short
        gc.enable()
        self.physics.start()
        self._say_ready()
        while self.physics.alive:
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()

    def close(self, ended_by: str) -> int:
        """Close the recording, say what happened, and give the exit code."""
        physics, log = self.physics, self.node.get_logger()
        physics.stop()
        physics.join()
        if self.diagnostics is not None:
            self.diagnostics.publish()
        if self.log is not None:
            self.log.close()
        if physics.failure:
            ended_by = physics.failure
        elif physics.diverged:
            ended_by = f"{ended_by} after the solver gave up {physics.diverged}"
        summary = summarise(self.settings, physics, self.publishers, self.gate, ended_by)
        words = [f"ended by {ended_by} at t = {self.simulation.time:.9g} s"]
        if summary["real_time_factor"] is not None:
            words.append(f"real-time factor {summary['real_time_factor']:.3g}")
        if self.log is not None:
            try:
                write_summary(self.settings.record, summary)
            except OSError as error:
                log.error(f"no summary: {one_line(error)}")
            lost = f", {self.log.dropped} dropped" if self.log.dropped else ""
            words.append(f"{self.log.written} messages recorded in {self.settings.record}{lost}")
            if self.log.error:
                words.append(f"recording error: {self.log.error}")
        lossy = self.log is not None and (self.log.dropped > 0 or self.log.error is not None)
        if self.log is not None and not self.log.complete and self.log.written:
            words.append("`recover` makes a clean recording of what is there")
        bad = physics.failure or physics.diverged or lossy
        (log.error if bad else log.info)(one_line("; ".join(words)))
        if physics.diverged and not physics.failure:
            return DIVERGED
        return FAILED if bad else ENDED

    def _open_log(self, topics: tuple[Topic, ...], prefix: str) -> BagWriter | None:
        if not self.settings.record:
            return None
        from soft_sim_ros.recording.writer import BagWriter  # a start without need not load it

        scene = self.simulation.scene
        return BagWriter(
            self.settings.record,
            topics,
            metadata=run_metadata(
                self.settings,
                prefix,
                {one.name: self.node.resolve_topic_name(one.name) for one in topics},
            )
            | self.inputs.bounds.facts(),
            attachments={"scene.yaml": scene.source.encode()},
            on_loss=self._lost,
        )

    def _lost(self, what: str) -> None:
        """Say at once, in every way there is, that files of the recording are gone."""
        self.node.get_logger().error(f"recording: {one_line(what)}")
        self.publishers.send("events", encode_string(f"recording_lost: {one_line(what)}"))
        if self.diagnostics is not None:
            self.diagnostics.publish()

    def _subscribe(self, one: Topic):
        joints = one.key == "joint_command"
        return self.node.create_subscription(
            message_class(one.type),
            one.name,
            self._receive_joints if joints else partial(self._receive, one.key),
            qos_profile(one.qos),
            event_callbacks=SubscriptionEventCallbacks(
                matched=self._senders.changed if joints else None
            ),
            qos_overriding_options=OVERRIDABLE,
            raw=True,
        )

    def _receive(self, key: str, data: bytes) -> None:
        self.gate.receive(key, data)

    def _receive_joints(self, data: bytes) -> None:
        self.gate.receive("joint_command", data)
        self._senders.after_order()

    def _pacer(self, grid: Grid) -> Pacer | Follower:
        settings = self.settings
        if settings.time == OWN:
            return Pacer(settings.real_time_factor)
        follower = Follower(
            grid.publish * self.simulation.step_ns,
            settings.time == RESAMPLED,
            lambda offset_ns: self.physics.set_offset(offset_ns),
            self._inform,
            self._warn,
        )
        with asking_ros("cannot subscribe"):
            self._ticks = Ticks(self.node, follower.hear, self._inform, settings.time)
        return follower

    def _change(self, name: str, value) -> None:
        pacer = self.physics.pacer
        if name == "real_time_factor" and isinstance(pacer, Pacer):
            pacer.factor = value
        elif name == "step_count":
            self.services.step_count = value
        elif name == "reset_time":
            self.services.reset_time = value

    def _say_ready(self) -> None:
        s, simulation = self.settings, self.simulation
        pace = f"{s.real_time_factor:g} x real time" if s.real_time_factor else "as fast as it can"
        pace = pace if s.time == OWN else f"following /clock in {s.time}"
        self.node.get_logger().info(
            f"ready: scene {shown(simulation.scene.name)}, {simulation.n_coordinates} coordinates, "
            f"actuators {', '.join(simulation.actuator_names) or 'none'}; "
            f"step {simulation.step_ns * 1e-9:g} s, {pace}, "
            f"{'paused' if s.start_paused else 'running'}; "
            f"recording {'to ' + one_line(s.record) if s.record else 'off'}"
        )
