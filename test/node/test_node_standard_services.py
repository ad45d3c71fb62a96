"""The services of simulation_interfaces do what they say, and say what they cannot do."""

import re
import sys
import time
from collections import Counter
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from peer import wait_for
from simulation_interfaces_stand_in import MESSAGES, SERVICES, Bounds, EntityCategory, Result

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.node.clock import Grid, Pacer
from soft_sim_ros.node.follower import Follower
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.standard import standard_services
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import load_scene, packaged_scenes, parse_scene
from soft_sim_ros.viewing.motion import MovingFrames

SCENE = Path(__file__).with_name("arm.yaml")
STATE = MESSAGES.SimulationState
OK, UNSUPPORTED, NOT_FOUND = (
    Result.RESULT_OK,
    Result.RESULT_FEATURE_UNSUPPORTED,
    Result.RESULT_NOT_FOUND,
)
FAILED = Result.RESULT_OPERATION_FAILED


class Outlet:
    """Takes what the physics thread sends."""

    def __init__(self):
        self.sent = Counter()

    def wanted(self, key):
        return False

    def send(self, key, data):
        self.sent[data] += 1

    def tick(self, time_ns):
        pass

    clock = tick

    def joined(self):
        return {}


class Desk:
    """A node of which only the services are asked for."""

    def __init__(self):
        self.services, self.said = {}, []

    def create_service(self, kind, name, answer):
        self.services[name.removeprefix("~/")] = (kind, answer)

    def get_logger(self):
        return SimpleNamespace(info=self.said.append, warning=self.said.append)

    def call(self, name, **request):
        kind, answer = self.services[name]
        return answer(kind.Request(**request), kind.Response())

    def code(self, name, **request):
        return self.call(name, **request).result.result


@pytest.fixture(scope="module")
def shared():
    return Simulation(load_scene(SCENE))


@pytest.fixture
def offer(shared, monkeypatch):
    """Offer the services for a physics thread with a pacer; the arm itself is shared."""
    package = ModuleType("simulation_interfaces")
    for name, module in (("", package), (".msg", MESSAGES), (".srv", SERVICES)):
        monkeypatch.setitem(sys.modules, f"simulation_interfaces{name}", module)
    threads = []

    def make(pacer, **options):
        shared.reset()
        inputs = Inputs(shared, 1.0, 0.5)
        inputs.reset()
        telemetry = Telemetry(shared, 5, "world", "/soft_arm")
        grid = Grid.of(shared.step_ns, 100.0, 250.0)
        physics = Physics(inputs, telemetry, Outlet(), None, grid, pacer, **options)
        desk = Desk()
        assert standard_services(desk, physics, "world") is not None
        physics.start()
        threads.append(physics)
        return desk, physics

    yield make
    for physics in threads:
        physics.stop()
        physics.join()


@pytest.fixture
def desk(offer):
    return offer(Pacer(1.0), paused=True)


def state_of(desk):
    return desk.call("get_simulation_state").state.state


def test_without_the_package_its_absence_is_said_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "simulation_interfaces", None)
    desk = Desk()
    assert standard_services(desk, None, "world") is None
    assert len(desk.said) == 1 and "simulation_interfaces is not installed" in desk.said[0]


def test_every_feature_that_is_named_is_there_and_no_other(desk):
    desk, _ = desk
    known = MESSAGES.SimulatorFeatures
    features = desk.call("get_simulator_features").features.features
    assert known.SIMULATION_RESET_TIME in features and known.STEP_SIMULATION_MULTIPLE in features
    for missing in ("SPAWNING", "ENTITY_STATE_SETTING", "ENTITY_TAGS", "STEP_SIMULATION_ACTION"):
        assert getattr(known, missing) not in features
    assert len(features) == len(set(features))


def test_it_plays_pauses_and_stops_and_knows_in_which_state_it_is(desk):
    desk, physics = desk
    go = lambda state: desk.code("set_simulation_state", state=STATE(state=state))  # noqa: E731
    assert state_of(desk) == STATE.STATE_PAUSED
    assert go(STATE.STATE_PAUSED) == 101, "already in that state"
    assert go(STATE.STATE_PLAYING) == OK
    wait_for(lambda: physics.stamp_ns > 20_000_000, "time to pass")
    assert state_of(desk) == STATE.STATE_PLAYING
    assert go(STATE.STATE_STOPPED) == OK
    assert state_of(desk) == STATE.STATE_STOPPED
    assert physics.paused and physics.stamp_ns == 0
    assert go(STATE.STATE_PAUSED) == OK, "a stopped simulation may be started paused"
    assert state_of(desk) == STATE.STATE_PAUSED and physics.stamp_ns == 0
    assert go(STATE.STATE_NO_WORLD) == UNSUPPORTED
    assert go(STATE.STATE_QUITTING) == OK
    wait_for(lambda: not physics.alive, "the end")


def test_steps_are_steps_of_the_scene_and_only_made_while_paused(desk):
    desk, physics = desk
    before = physics.simulation.step_index
    assert desk.code("step_simulation", steps=7) == OK
    assert physics.simulation.step_index == before + 7
    assert desk.code("step_simulation") == OK
    assert physics.simulation.step_index == before + 8
    assert desk.code("step_simulation", steps=0) == FAILED
    assert physics.pause(False)[0]
    refused = desk.call("step_simulation", steps=7).result
    assert refused.result == FAILED and "not paused" in refused.error_message


@pytest.mark.parametrize(
    ("scope", "code", "state_is_new", "time_is_new"),
    [
        (0, OK, True, True),
        (255, OK, True, True),
        (1, OK, False, True),
        (2, OK, True, False),
        (3, OK, True, True),
        (6, OK, True, False),
        (4, UNSUPPORTED, False, False),
        (8, UNSUPPORTED, False, False),
    ],
)
def test_a_reset_has_the_scope_it_is_asked_for(desk, scope, code, state_is_new, time_is_new):
    desk, physics = desk
    start, begin, step = (
        np.array(physics.simulation.q),
        physics.stamp_ns,
        physics.simulation.step_ns,
    )
    physics.simulation.set_efforts(np.array([0.3, 0.1]))
    assert desk.code("step_simulation", steps=50) == OK
    moved = np.array(physics.simulation.q)
    assert np.abs(moved - start).max() > 1e-3
    assert desk.code("reset_simulation", scope=scope) == code
    assert np.array_equal(physics.simulation.q, start if state_is_new else moved)
    assert physics.stamp_ns == (0 if time_is_new else begin + 50 * step)
    assert desk.code("step_simulation", steps=10) == OK
    assert physics.stamp_ns == (10 * step if time_is_new else begin + 60 * step)


def test_time_of_another_program_is_not_reset(offer):
    follower = Follower(10_000_000, False, lambda ns: physics.set_offset(ns), print, print)
    desk, physics = offer(follower)
    follower.hear(3_000_000_000)
    wait_for(lambda: physics.stamp_ns >= 3_000_000_000, "the clock")
    joined = physics.stamp_ns
    known = MESSAGES.SimulatorFeatures
    features = desk.call("get_simulator_features").features.features
    assert known.SIMULATION_RESET_TIME not in features
    for scope in (0, 1, 255):
        assert desk.code("reset_simulation", scope=scope) == UNSUPPORTED
    assert desk.code("reset_simulation", scope=2) == OK
    stop = STATE(state=STATE.STATE_STOPPED)
    assert desk.code("set_simulation_state", state=stop) == 102
    assert desk.code("step_simulation", steps=1) == FAILED
    assert physics.stamp_ns == joined


def test_entities_are_found_by_their_names_and_filters(desk):
    desk, _ = desk
    filters = MESSAGES.EntityFilters
    found = lambda **f: desk.call("get_entities", filters=filters(**f))  # noqa: E731
    assert found().entities == ["base", "tip"]
    assert found(filter="^t").entities == ["tip"]
    assert found(filter="(").result.result == FAILED
    assert found(categories=[EntityCategory(category=1)]).entities == ["base", "tip"]
    assert found(categories=[EntityCategory(category=2)]).entities == []
    assert found(tags=MESSAGES.TagsFilter(tags=["a"])).result.result == UNSUPPORTED
    assert found(bounds=Bounds(type=Bounds.TYPE_BOX)).result.result == UNSUPPORTED
    assert desk.code("get_entity_state", entity="elbow") == NOT_FOUND
    assert desk.code("set_entity_state", entity="elbow") == NOT_FOUND
    assert desk.code("set_entity_state", entity="tip") == UNSUPPORTED
    info = desk.call("get_entity_info", entity="tip").info
    assert (
        info.category.category == EntityCategory.CATEGORY_ROBOT and "test_arm" in info.description
    )


def test_states_of_entities_are_those_of_the_moving_arm(desk):
    desk, physics = desk
    physics.simulation.set_efforts(np.array([0.3, 0.1]))
    begin = physics.stamp_ns
    assert desk.code("step_simulation", steps=40) == OK
    answer = desk.call("get_entities_states")
    assert answer.entities == ["base", "tip"]
    base, tip = answer.states
    one = desk.call("get_entity_state", entity="tip").state
    assert one.pose == tip.pose and one.twist == tip.twist
    assert tip.header.frame_id == "world"
    stamp = tip.header.stamp
    told = stamp.sec * 1_000_000_000 + stamp.nanosec
    assert told == begin + 40 * physics.simulation.step_ns
    assert base.pose.position.z == pytest.approx(0.5)
    assert base.twist.linear.x == 0.0
    poses = physics.simulation.sampler(2).poses()
    place = [tip.pose.position.x, tip.pose.position.y, tip.pose.position.z]
    np.testing.assert_allclose(place, poses[-1, :3], rtol=0, atol=1e-12)


@pytest.mark.parametrize("scene", ["mixed_chain", "flying_body"])
def test_twists_are_what_poses_change_by_over_time(scene):
    """Against the difference of poses over a short stretch of the motion, from its middle."""
    # steps so fine that the difference over two of them is the velocity between
    text = (packaged_scenes()[scene]).read_text()
    simulation = Simulation(parse_scene(re.sub(r"step: [0-9.e-]+", "step: 1.0e-4", text)))
    names = [b.name for b in simulation.scene.bodies if hasattr(b, "mass") or hasattr(b, "axes")]
    frames = MovingFrames(simulation, [(name, 0.0) for name in ("base", "tip", *names)])
    simulation.set_efforts(np.full(simulation.n_actuators, 0.2))
    simulation.advance(20)
    before, _ = frames.look()
    simulation.advance(1)
    _, twists = frames.look()
    simulation.advance(1)
    after, _ = frames.look()
    h = 2.0 * simulation.step_ns * 1e-9
    moved = (after[:, :3] - before[:, :3]) / h
    assert np.abs(twists[:, :3]).max() > 1e-3
    scale = np.abs(twists).max()
    np.testing.assert_allclose(twists[:, :3], moved, rtol=0, atol=1e-3 * scale)
    # q_after * conj(q_before), vector part: half the turn
    b, a = before[:, 3:], after[:, 3:]
    vector = b[:, 3:] * a[:, :3] - a[:, 3:] * b[:, :3] - np.cross(a[:, :3], b[:, :3])
    np.testing.assert_allclose(twists[:, 3:], 2.0 * vector / h, rtol=0, atol=1e-3 * scale)


def test_services_are_answered_while_the_arm_runs(offer):
    desk, physics = offer(Pacer(1.0))
    begin = time.monotonic()
    for _ in range(10):
        assert desk.code("get_entity_state", entity="tip") == OK
    assert time.monotonic() - begin < 2.0
    assert not physics.paused
