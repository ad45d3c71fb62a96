"""Once a second: how the node is doing, for people and for monitors."""

from __future__ import annotations

import math
import threading

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType

from soft_sim_ros.core.accuracy.space_watch import LookedInputs, SpaceInputs
from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.foreign import one_line
from soft_sim_ros.node.commands import Gate
from soft_sim_ros.node.follower import Follower
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.rivals import Rivals
from soft_sim_ros.node.ticks import OtherClocks

_BEHIND = 0.95  # of the real-time factor asked for


class Diagnostics:
    """Publishes ``/diagnostics`` at 1 Hz of real time, also while the arm is paused.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of publisher and timer.
    physics : Physics
        What is watched.
    gate : Gate
        Counts the commands.
    rivals : Rivals
        Looks for others of the same name.
    clocks : OtherClocks
        Compares the arm's time with that of others.
    hardware_id : str
        Name of the scene.
    """

    def __init__(
        self,
        node,
        physics: Physics,
        gate: Gate,
        rivals: Rivals,
        clocks: OtherClocks,
        hardware_id: str,
    ):
        self._physics, self._gate, self._rivals, self._clocks = physics, gate, rivals, clocks
        self._name = f"{node.get_fully_qualified_name().lstrip('/')}: physics"
        self._hardware_id = hardware_id
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._seen = (0, 0, 0, 0)
        self._lock = threading.Lock()
        # A clock of its own: the node's may be the simulated one, which stands still when paused.
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(1.0, self.publish, clock=self._clock)

    def publish(self) -> None:
        """Publish the state of things now; from any thread."""
        with self._lock:
            self._publish()

    def _publish(self) -> None:
        physics = self._physics
        values, level, message = self._look()
        status = DiagnosticStatus(
            level=level,
            name=self._name,
            message=one_line(message),
            hardware_id=one_line(self._hardware_id),
            values=[KeyValue(key=key, value=_text(value)) for key, value in values.items()],
        )
        array = DiagnosticArray(status=[status])
        seconds, nanoseconds = divmod(physics.simulation.time_ns, 1_000_000_000)
        array.header.stamp = Time(sec=seconds, nanosec=nanoseconds)
        self._publisher.publish(array)

    def _look(self) -> tuple[dict[str, object], bytes, str]:
        physics, pacer = self._physics, self._physics.pacer
        window = physics.costs.look()
        now = (
            physics.ran_ns,
            physics.running_ns,
            pacer.overruns,
            physics.recovery.count,
        )
        simulated, running, overruns, withdrawn = (
            n - b for n, b in zip(now, self._seen, strict=True)
        )
        self._seen = now
        factor = simulated / running if running > 0 else 0.0
        log = physics.log
        values: dict[str, object] = {
            "simulation time (s)": physics.simulation.time,
            "paused": physics.paused,
            "real-time factor": factor,
            "real-time factor asked for": pacer.factor,
            "step cost p50 (us)": window.p50 * 1e-3,
            "step cost p99 (us)": window.p99 * 1e-3,
            "step cost worst (us)": window.worst * 1e-3,
            "steps": physics.simulation.step_index,
            "overruns": pacer.overruns,
            "time given up (s)": pacer.lost_ns * 1e-9,
            "command age (s)": physics.command_age,
            "commands accepted": self._gate.accepted,
            "commands refused": self._gate.refused,
            "commands clamped": self._gate.clamped,
            "commands withdrawn": physics.recovery.count,
            "energy residual (J)": physics.residual,
            "recording": log is not None and log.recording,
            "recorded messages": log.written if log else 0,
            "dropped log messages": log.dropped if log else 0,
            "recording error": (log.error or "none") if log else "none",
            "last error": physics.last_error or "none",
        }
        inputs = physics.inputs
        if isinstance(inputs, WatchedInputs):
            values["error estimate (of the length)"] = inputs.error_rel
            values["tolerance (of the length)"] = inputs.tolerance
            if inputs.orientation is not None:
                values["orientation error estimate (rad)"] = inputs.error_rad
                values["orientation tolerance (rad)"] = inputs.orientation
        if isinstance(inputs, LookedInputs):
            inputs.catch_up()  # here, where the physics thread does not wait for it
        if isinstance(inputs, SpaceInputs):
            values["error estimate in space (of the length)"] = inputs.space_rel
        doubts = [self._rivals.look(), self._clocks.look()]
        if isinstance(pacer, Follower):
            doubts.append(pacer.doubt())
            values["behind /clock (s)"] = pacer.behind_ns * 1e-9
        doubt = next(filter(None, doubts), None)
        ok, warn, error = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
        if physics.failure:
            return values, error, physics.failure
        if physics.diverged:
            return values, error, f"the solver gave up {physics.diverged}; holding the last state"
        if log is not None and log.error:
            return values, error, f"recording: {log.error}"
        if log is not None and log.dropped:
            return values, warn, f"recording: {log.dropped} messages dropped"
        if isinstance(inputs, WatchedInputs) and inputs.missed:
            return values, warn, inputs.doubt()
        if isinstance(inputs, SpaceInputs) and inputs.coarse:
            return values, warn, inputs.told()
        if withdrawn:
            return values, warn, f"the solver gave up {physics.recovery.said}"
        if doubt:
            return values, warn, doubt
        if physics.paused:
            return values, ok, "paused"
        if overruns and factor < _BEHIND * pacer.factor:
            wanted = f"real-time factor {factor:.3g} instead of {pacer.factor:g}"
            return values, warn, f"{wanted}, {overruns} deadlines missed in the last second"
        return values, ok, "running"


def _text(value: object) -> str:
    if isinstance(value, float):
        return "none" if math.isnan(value) else f"{value:.6g}"
    return str(value).lower() if isinstance(value, bool) else one_line(value)
