"""The thread that owns the simulation: it takes up orders, steps, and hands out bytes."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable

import numpy as np

from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.orders import Order
from soft_sim_ros.errors import Diverged, NotMet
from soft_sim_ros.node.clock import Grid, Pacer
from soft_sim_ros.node.events import Events
from soft_sim_ros.node.follower import Follower
from soft_sim_ros.node.inbox import Answer, Inbox
from soft_sim_ros.node.looks import Looks
from soft_sim_ros.node.outlet import Outlet
from soft_sim_ros.node.readings import Readings
from soft_sim_ros.node.recovery import RESET, Recovery
from soft_sim_ros.node.states import BEAT, States
from soft_sim_ros.node.timing import StepCosts
from soft_sim_ros.recording.offset import offset_event
from soft_sim_ros.recording.orders import ATTACHED, DROPPED, HELD, RELEASED, SENDER_LEFT
from soft_sim_ros.recording.sensors import SensorMessages

LONGEST_STEPPING = 2.0  # s of one ~/step: nothing else of the node answers meanwhile


class Physics:
    """Runs a simulation in real time, or faster, or slower, in a thread of its own.

    Nothing else touches the simulation while the thread runs. Orders and requests wait in one queue
    and are carried out in order of arrival between two steps.

    Parameters
    ----------
    inputs : Inputs
        Orders of the simulation to be run.
    telemetry : Telemetry
        Builds the bytes of every outgoing message.
    outlet : Outlet
        Publishes bytes.
    log : BagWriter or None
        Records bytes.
    grid : Grid
        When to publish and to take up orders.
    pacer : Pacer or Follower
        When in the real world, or on somebody else's clock.
    paused : bool
        Whether to wait for a request before the first step.
    exit_on_error : bool
        Whether to end when the solver gives up.
    complain : callable
        Told in words what goes wrong.
    sensors : SensorMessages or None
        Builds the bytes of readings of sensors.
    """

    def __init__(
        self,
        inputs: Inputs,
        telemetry,
        outlet: Outlet,
        log,
        grid: Grid,
        pacer: Pacer | Follower,
        *,
        paused: bool = False,
        exit_on_error: bool = False,
        complain: Callable[[str], None] = print,
        sensors: SensorMessages | None = None,
    ):
        self.simulation = inputs.simulation
        self.inputs, self.outlet, self.log, self.grid, self.pacer = inputs, outlet, log, grid, pacer
        self.paused = paused
        self.costs = StepCosts()
        self.diverged: str | None = None
        self.last_error: str | None = None
        self.failure: str | None = None
        self.ran_ns = self.running_ns = 0  # simulated and real time while not paused
        self._telemetry = telemetry
        self._follows = isinstance(pacer, Follower)
        self._restamped = False  # the present state has a new stamp, with which it was not sent
        messages = SensorMessages(self.simulation, (), "") if sensors is None else sensors
        self._readings = Readings(self.simulation, messages, outlet, log, grid)
        self._states = States(
            self.simulation, telemetry, outlet, log, grid, self._readings.send_again
        )
        self._exit_on_error, self._complain = exit_on_error, complain
        self.recovery = Recovery(inputs, complain)
        self._inbox = Inbox()
        self._stop = threading.Event()
        self._event = Events(self.simulation, outlet, log).say
        self.looks = Looks(self.simulation, log, complain)
        self._thread = threading.Thread(target=self._main, name="physics", daemon=True)

    # From other threads.

    def start(self) -> None:
        """Start the thread; the initial state is sent at once."""
        self._thread.start()

    def stop(self) -> None:
        """Ask the thread to end after the step it is in; safe in a signal handler."""
        self._stop.set()
        self._inbox.wake.set()

    def join(self) -> None:
        """Wait for the end of the thread."""
        if self._thread.ident is not None:
            self._thread.join()

    @property
    def alive(self) -> bool:
        """Whether the thread still runs."""
        return self._thread.is_alive()

    @property
    def residual(self) -> float:
        """Residual of the energy ledger in J when it was last looked at."""
        return self.looks.residual

    @property
    def command_age(self) -> float:
        """Simulated s since the last order was taken up; nan without any."""
        last = self.inputs.last_order_ns
        return np.nan if last is None else (self.simulation.time_ns - last) * 1e-9

    def submit(self, key: str, order: Order, data: bytes) -> bool:
        """Queue an order with the bytes of its message, for the next instant of control.

        False if too many wait already: then it is not queued.
        """
        taken = self._inbox.submit(key, order, data)
        if self.paused:  # a pause that begins now finds the order in the queue
            self._inbox.wake.set()
        return taken

    def pause(self, pause: bool) -> Answer:
        """Stop at the next instant of control, or go on; the answer comes when it is done."""
        return self._ask(lambda: self._set_paused(pause))

    def step(self, steps: int) -> Answer:
        """Advance a paused simulation by ``steps``, without waiting for deadlines."""
        return self._ask(lambda: self._single_steps(steps))

    def reset(self, state: bool = True, time: bool = False, resume: bool = True) -> Answer:
        """Go back to the initial state with safe efforts, to stamps from 0 on, or to both.

        ``resume`` ends the hold after a divergence, which ends with the state in any case.
        """
        return self._ask(lambda: self._reset(state, time, resume))

    def carry(self, name: str, attached: bool) -> Answer:
        """Attach or drop a payload."""
        return self._ask(lambda: self._carry(name, attached))

    def latch(self, name: str, hold: bool) -> Answer:
        """Hold or release a constraint."""
        return self._ask(lambda: self._latch(name, hold))

    def look(self, action: Callable[[], Answer]) -> Answer:
        """Have something looked at while nothing moves; it must change nothing."""
        return self._ask(action)

    @property
    def follows(self) -> bool:
        """Whether time is that of another program."""
        return self._follows

    @property
    def stamp_ns(self) -> int:
        """Time that messages carry now, ns."""
        return int(self._telemetry.stamp_ns)

    def release(self) -> None:
        """Give a timeout to what lasts without one: its sender has left."""
        self._inbox.post(self._release)
        if self.paused:
            self._inbox.wake.set()

    def _ask(self, action: Callable[[], Answer]) -> Answer:
        return self._inbox.ask(action, self._thread.is_alive)

    # In the thread.

    def _main(self) -> None:
        try:
            self._run()
        except Exception as error:  # whatever it is, the node must hear of it and end
            self.failure = f"{type(error).__name__}: {error}"
            self.last_error = self.failure
            self._complain(f"the physics thread failed:\n{traceback.format_exc()}")

    def _run(self) -> None:
        if isinstance(self.pacer, Follower) and not self._wait_for_clock(self.pacer):
            return
        self._emit()
        before, counted_ns = time.monotonic_ns(), self.simulation.time_ns
        while not self._stop.is_set():
            # A state is computed ahead of its time and sent when it is due, but with somebody
            # else's clock, where commands between two ticks count from the first of them on. A
            # request need not wait, an order does: neither lets the next step begin early.
            due = not self.paused and self.pacer.wait(self._next_ns(), self._interrupted)
            now, time_ns = time.monotonic_ns(), self.simulation.time_ns
            self.running_ns += now - before
            before = now
            if due and not self._follows:
                self.ran_ns += time_ns - counted_ns
                counted_ns = time_ns
                self._emit_on_grid()
            self._inbox.empty(self._take)
            if self.paused:
                self._inbox.wake.wait(BEAT)
                self._inbox.wake.clear()
                self._states.look_for_latecomers()
                before, counted_ns = time.monotonic_ns(), self.simulation.time_ns
            elif due and self._restamped:
                self._emit()
            elif due:
                self._advance(self._readings.steps())
                if self._follows:
                    self.ran_ns += self.simulation.time_ns - time_ns
                    self._emit_on_grid()
            elif self._follows:
                self._states.look_for_latecomers()
        self._emit_on_grid()  # what was computed last may not have been due yet
        self.looks.at_ledger()

    def _next_ns(self) -> int:
        """Return the simulated time that has to be due before anything else happens."""
        ahead = 0
        if self._follows and not self._restamped:
            ahead = self._readings.steps()
        return self.simulation.time_ns + ahead * self.simulation.step_ns

    def _wait_for_clock(self, clock: Follower) -> bool:
        """Send nothing before there is a time to stamp it with; False if the end came first."""
        while not clock.join(self.simulation.time_ns, self._interrupted):
            if self._stop.is_set():
                return False
            self._inbox.empty(self._take)
        return True

    def set_offset(self, offset_ns: int) -> None:
        """Stamp with simulated time plus this from now on; only for the thread itself."""
        self._telemetry.offset_ns, self._restamped = offset_ns, True
        self._event(offset_event(offset_ns))

    def _interrupted(self) -> bool:
        return self._inbox.asked.is_set() or self._stop.is_set()

    def _take(self, key: str, order: Order, data: bytes) -> None:
        self.inputs.take(order)
        if self.log is not None:
            self.log.write(key, self.simulation.time_ns, data)

    def _advance(self, steps: int) -> bool:
        """Advance by ``steps``, or less where commands are withdrawn; False if that ended it."""
        first = self.simulation.step_index
        begin = time.perf_counter_ns()
        error = None
        try:
            self.inputs.advance(steps)
        except Diverged as caught:
            error = caught
        end = time.perf_counter_ns()
        made = self.simulation.step_index - first
        if made:
            self.costs.add(made, end - begin, self.simulation.time_ns)
        for time_ns, text in self.inputs.take_events():
            self._event(text, time_ns)
        if error is None or self._recover(error):
            return True
        self._give_up(error)
        return False

    def _recover(self, error: Diverged) -> bool:
        if (event := self.recovery.after(error)) is None:
            return False
        self.last_error = self.recovery.said
        self._event(event)
        if event == RESET:
            self._emit()
        return True

    def _give_up(self, error: Diverged) -> None:
        self.diverged = self.last_error = str(error)
        self.paused = True
        # the event comes first: from it on the inputs that broke the step are in force
        self._event(f"diverged: {error}")
        self._emit()
        if self._exit_on_error:
            self._complain(f"the solver gave up {error}; ending, as exit_on_error says")
            self._stop.set()
        else:
            self._complain(
                f"the solver gave up {error}; holding the last good state, ~/reset starts again"
            )

    def _emit_on_grid(self) -> None:
        self._readings.send()
        if self._states.due:
            self._emit()
        self._states.tick()

    def _emit(self) -> None:
        self._restamped = False
        self._readings.send()
        self._states.send()
        if self.log is not None and self.pacer.factor == 0.0:
            self.log.wait_for_room(1.0)  # nobody waits for us, so nothing need be dropped
        self.looks.now_and_then()

    def _set_paused(self, pause: bool) -> Answer:
        if pause == self.paused:
            return True, "already paused" if pause else "already running"
        if not pause and self.diverged:
            return False, f"the solver gave up {self.diverged}: call ~/reset first"
        self.paused = pause
        if pause:
            self._emit()
        self._event("pause" if pause else "resume")
        self.pacer.restart(self.simulation.time_ns)
        return True, f"{'paused' if pause else 'running'} at t = {self.stamp_ns * 1e-9:.9g} s"

    def _single_steps(self, steps: int) -> Answer:
        if self._follows:
            return False, "this arm follows /clock: step the program that publishes it"
        if not self.paused:
            return False, "not paused: ~/step advances a paused simulation"
        if self.diverged:
            return False, f"the solver gave up {self.diverged}: call ~/reset first"
        self._event("step")
        last = self.simulation.step_index + steps
        end = time.monotonic() + LONGEST_STEPPING
        while (left := last - self.simulation.step_index) > 0:
            if self._stop.is_set():
                return False, f"ended {left} steps early"
            if time.monotonic() > end:
                if not self._states.up_to_date:
                    self._emit()
                made = f"{steps - left} of {steps} steps, now at t = {self.stamp_ns * 1e-9:.9g} s"
                return False, f"{made}: more take over {LONGEST_STEPPING:g} s; call ~/step again"
            if not self._advance(min(left, self._readings.steps())):
                return False, f"the solver gave up {self.diverged}"
            self._emit_on_grid()
        if last % self.grid.publish:
            self._emit()
        return True, f"{steps} steps, now at t = {self.stamp_ns * 1e-9:.9g} s"

    def _carry(self, name: str, attached: bool) -> Answer:
        if self.simulation.payloads[name] == attached:
            return True, "already attached" if attached else "not attached"
        self.inputs.carry(name, attached)
        self._event(f"{ATTACHED if attached else DROPPED}{name}")
        return True, f"{name} {'attached' if attached else 'dropped'}"

    def _latch(self, name: str, hold: bool) -> Answer:
        try:
            self.inputs.latch(name, hold)
        except NotMet as error:
            return False, str(error)
        self._event(f"{HELD if hold else RELEASED}{name}")
        return True, f"{name} {'held' if hold else 'released'}"

    def _release(self) -> Answer:
        if order := self.inputs.released():
            self.inputs.take(order)
            self._event(SENDER_LEFT)
        return True, ""

    def _reset(self, state: bool, time: bool, resume: bool) -> Answer:
        if time and self._follows:
            return False, "time belongs to the program that publishes /clock"
        was_diverged = state and self.diverged is not None
        if state:
            self.diverged = None
            self.inputs.reset()
            self._event(RESET)
        if time:
            self.set_offset(-self.simulation.time_ns)
        self._emit()
        if was_diverged and resume:
            self.paused = False
            self._event("resume")
        self.pacer.restart(self.simulation.time_ns)
        what = "initial state" if state else "the same state"
        return True, f"{what} at t = {self.stamp_ns * 1e-9:.9g} s"
