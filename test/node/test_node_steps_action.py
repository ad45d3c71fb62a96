"""The action SimulateSteps of simulation_interfaces, with stand-ins of its types."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from simulation_interfaces_stand_in import MESSAGES, SERVICES, Result

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.node.clock import Grid, Pacer
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.standard import standard_services
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import load_scene

SCENE = Path(__file__).with_name("arm.yaml")


# nobody listens to what it publishes
DEAF = SimpleNamespace(
    wanted=lambda key: False,
    send=lambda key, data: None,
    tick=lambda time: None,
    clock=lambda time: None,
    joined=dict,
)


class SimulateSteps:
    """Goal, result and feedback of the action."""

    Result = staticmethod(lambda: SimpleNamespace(result=Result()))
    Feedback = SimpleNamespace


class Goal:
    """A goal that a client has sent; it is cancelled after some feedbacks."""

    def __init__(self, steps, patience=10**9):
        self.request, self.told, self.ended = SimpleNamespace(steps=steps), [], None
        self.patience = patience

    @property
    def is_cancel_requested(self):
        return len(self.told) >= self.patience

    def publish_feedback(self, feedback):
        self.told.append((feedback.completed_steps, feedback.remaining_steps))

    def succeed(self):
        self.ended = "succeeded"

    def abort(self):
        self.ended = "aborted"

    def canceled(self):
        self.ended = "cancelled"


@pytest.fixture
def offered(monkeypatch):
    """Give the physics and what an action server was made of."""
    made = {}

    def server(node, kind, name, execute, cancel_callback):
        made.update(name=name, execute=execute, cancel=cancel_callback)

    action = ModuleType("simulation_interfaces.action")
    action.SimulateSteps = SimulateSteps
    package = ModuleType("simulation_interfaces")
    modules = {"": package, ".msg": MESSAGES, ".srv": SERVICES, ".action": action}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, f"simulation_interfaces{name}", module)
    monkeypatch.setattr("rclpy.action.ActionServer", server)
    simulation = Simulation(load_scene(SCENE))
    inputs = Inputs(simulation, 1.0, 0.5)
    telemetry = Telemetry(simulation, 5, "world", "/soft_arm")
    grid = Grid.of(simulation.step_ns, 100.0, 250.0)
    physics = Physics(inputs, telemetry, DEAF, None, grid, Pacer(1.0), paused=True)
    services = {}
    quiet = SimpleNamespace(info=str, warning=str)
    desk = SimpleNamespace(
        create_service=lambda kind, name, answer: services.update({name: (kind, answer)}),
        get_logger=lambda: quiet,
    )
    assert standard_services(desk, physics, "world") is not None
    physics.start()
    yield physics, made, services
    physics.stop()
    physics.join()


def carry_out(execute, goal):
    """Do what an executor does with a coroutine."""
    task = execute(goal)
    while True:
        try:
            task.send(None)
        except StopIteration as end:
            return end.value.result


def test_it_makes_so_many_steps_and_tells_how_far_it_is(offered):
    physics, made, services = offered
    assert made["name"] == "~/simulate_steps"
    goal = Goal(25)
    result = carry_out(made["execute"], goal)
    assert (result.result, result.error_message, goal.ended) == (1, "", "succeeded")
    assert physics.simulation.step_index == 25
    assert goal.told == [(10, 15), (20, 5), (25, 0)]
    kind, answer = services["~/get_simulator_features"]
    features = answer(kind.Request(), kind.Response()).features.features
    assert MESSAGES.SimulatorFeatures.STEP_SIMULATION_ACTION in features


def test_it_can_be_cancelled_between_two_states(offered):
    physics, made, _ = offered
    goal = Goal(1000, patience=3)
    result = carry_out(made["execute"], goal)
    assert goal.ended == "cancelled"
    assert physics.simulation.step_index == 30
    assert "cancelled after 30 of 1000 steps" in result.error_message


def test_it_fails_where_steps_cannot_be_made(offered):
    physics, made, _ = offered
    goal = Goal(0)
    assert carry_out(made["execute"], goal).result == Result.RESULT_OPERATION_FAILED
    assert goal.ended == "aborted"
    assert physics.pause(False)[0]
    goal = Goal(5)
    result = carry_out(made["execute"], goal)
    assert result.result == Result.RESULT_OPERATION_FAILED
    assert "not paused" in result.error_message and goal.ended == "aborted"


@pytest.mark.parametrize("make", [SingleThreadedExecutor, EventsExecutor])
def test_executors_call_others_meanwhile(offered, context, make):
    """Real executors of rclpy: the goal is cancelled by a timer that is due while it runs."""
    physics, made, _ = offered
    node = rclpy.create_node("steps", context=context)
    goal = Goal(10**6)
    node.create_timer(0.05, lambda: setattr(goal, "patience", 0))
    executor = make(context=context)
    executor.add_node(node)
    task = executor.create_task(made["execute"], goal)
    for _ in range(1000):
        executor.spin_once(timeout_sec=0.1)
        if task.done():
            break
    assert goal.ended == "cancelled"
    assert 0 < physics.simulation.step_index < 10**6
    executor.shutdown()
    node.destroy_node()
