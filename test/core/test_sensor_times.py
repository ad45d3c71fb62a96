"""When sensors measure, what noise adds, and what a state keeps of them."""

import copy
import pickle
from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros import Simulation, SimulationState, parse_scene
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.errors import NoSuchPlace, OtherModel, SceneError, StateError

PENDULUM = """
bodies:
  - {joint: hinge, kind: revolute, axis: [0, 1, 0], stiffness: 0.1}
  - {rigid_body: bob, mass: 0.1, inertia: [1e-4, 1e-4, 1e-4], com: {position: [0.2, 0, 0]}}
actuators:
  - {joint_torque: motor, joint: hinge}
numerics: {step: 0.001%s}
"""


@lru_cache
def compiled(sensors, numerics=""):
    return compile_scene(parse_scene(PENDULUM % numerics + f"sensors:\n{sensors}", "times.yaml"))


def pendulum(sensors, numerics=""):
    return Simulation(compiled(sensors, numerics))


def swing(simulation, steps=1):
    """Push and advance, one step at a time; return all readings by name."""
    out = {name: [] for name in simulation.sensors()}
    for _ in range(steps):
        simulation.set_efforts([0.05 * np.sin(0.1 * simulation.step_index)])
        simulation.advance(1)
        for name, reading in simulation.sensors().items():
            out[name].append((simulation.step_index, reading))
    return out


NOISY = """
  - {encoder: clean, joint: hinge, rate: 1000}
  - {encoder: one, joint: hinge, rate: 1000, noise: {position: 0.01}, seed: 7}
  - {encoder: two, joint: hinge, rate: 1000, noise: {position: 0.01}, seed: 7}
  - {encoder: late, joint: hinge, rate: 1000, latency: 0.0123}
  - {encoder: slow, joint: hinge, rate: 300}
  - {imu: imu, body: bob, rate: 250, seed: 3, latency: 0.01,
     noise: {acceleration: 0.1, angular_velocity: 0.02, orientation: 0.01},
     bias: {acceleration: [0.5, 0.0, -0.5]}}
  - {wrench: torque, body: hinge, rate: 100, bias: {force: 1.0}}
"""


def test_noise_has_the_deviation_that_is_written_and_no_memory():
    read = swing(pendulum("\n".join(NOISY.splitlines()[:4])), 3000)
    clean, one, two = (
        np.array([r["position/hinge"] for _, r in read[name]]) for name in ("clean", "one", "two")
    )
    error, other = one - clean, two - clean
    count = len(error)
    assert abs(error.mean()) < 4 * 0.01 / np.sqrt(count)
    assert abs(error.std() / 0.01 - 1.0) < 4 / np.sqrt(2 * count)
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 4 / np.sqrt(count)
    assert abs(np.corrcoef(error, other)[0, 1]) < 4 / np.sqrt(count)  # one seed, two sensors
    assert all(r["velocity/hinge"] == c["velocity/hinge"]
               for (_, r), (_, c) in zip(read["one"], read["clean"], strict=True))  # fmt: skip


def test_noise_follows_from_seed_and_step_alone():
    first, again = pendulum(NOISY), pendulum(NOISY)
    swing(first, 50)
    again.step_index = 20  # another motion, at the same steps
    swing(again, 30)
    errors = [s.sensors()["one"]["position/hinge"] - s.q[0] for s in (first, again)]
    assert errors[0] == pytest.approx(errors[1], abs=1e-14)
    other = pendulum(NOISY.replace("seed: 7", "seed: 8"))
    swing(other, 50)
    assert abs(other.sensors()["one"]["position/hinge"] - other.q[0] - errors[0]) > 1e-6


def test_an_orientation_with_noise_is_turned_by_it():
    simulation = pendulum(NOISY + "  - {imu: true, body: bob, rate: 250, latency: 0.01}")
    angles = []
    for _ in range(300):
        swing(simulation, 4)
        read = simulation.sensors()
        if np.isnan(read["imu"].time):  # it is still under way
            continue
        turns = [Rotation.from_quat(read[name]["orientation"]) for name in ("true", "imu")]
        angles.append((turns[0].inv() * turns[1]).as_rotvec())
        assert np.linalg.norm(read["imu"]["orientation"]) == pytest.approx(1.0)
    assert abs(np.std(angles) / 0.01 - 1.0) < 0.15


def test_bias_is_added():
    clean = "  - {imu: imu, body: bob, rate: 1000}\n  - {wrench: torque, body: hinge, rate: 1000}"
    biased = clean.replace("rate: 1000}", "rate: 1000, bias: {acceleration: [1, 2, 3]}}", 1)
    biased = biased.replace("hinge, rate: 1000}", "hinge, rate: 1000, bias: {force: -1.0}}")
    reads = []
    for sensors in (clean, biased):
        simulation = pendulum(sensors)
        swing(simulation, 10)
        reads.append(simulation.sensors())
    more = reads[1]["imu"]["acceleration"] - reads[0]["imu"]["acceleration"]
    np.testing.assert_allclose(more, [1.0, 2.0, 3.0], rtol=1e-12)
    np.testing.assert_allclose(reads[1]["torque"]["force"] - reads[0]["torque"]["force"], -1.0)
    np.testing.assert_array_equal(reads[1]["torque"]["torque"], reads[0]["torque"]["torque"])


def test_a_latency_delays_the_value_and_changes_no_bit_of_it():
    read = swing(pendulum(NOISY), 200)
    clean = dict(read["clean"])
    for index, late in read["late"]:
        if index < 13:  # 12.3 ms, at the first step that is not before
            assert late.time_ns is None
            assert np.isnan(late.values).all()
            continue
        assert late.time_ns == (index - 13) * 1_000_000
        assert late.delivered_ns == index * 1_000_000
        if index > 13:
            assert late.values.tobytes() == clean[index - 13].values.tobytes()


def test_a_rate_that_is_no_divisor_is_kept_at_the_first_steps_that_are_not_before():
    read = swing(pendulum(NOISY), 100)
    times = sorted({reading.time_ns for _, reading in read["slow"]})
    assert times[:5] == [0, 4_000_000, 7_000_000, 10_000_000, 14_000_000]
    assert len(times) == 31  # of 0 to 100 ms


def test_a_rate_beyond_the_steps_is_refused():
    with pytest.raises(SceneError, match=r"sensors\[0\].rate = 2000: expected at most 1000 Hz"):
        pendulum("  - {encoder: fast, joint: hinge, rate: 2000}")


@pytest.mark.parametrize("numerics", ["", ", integrator: adaptive"])
def test_sensors_change_no_bit_of_the_motion_and_grouping_none_of_theirs(numerics):
    one, other = pendulum(NOISY, numerics), pendulum(NOISY, numerics)
    bare = Simulation(parse_scene(PENDULUM % numerics, "bare.yaml"))
    for simulation in (one, other, bare):
        simulation.set_efforts([0.1])
    one.advance(137)
    bare.advance(137)
    for steps in (1, 50, 7, 79):
        other.advance(steps)
        other.sensors()
    assert one.q.tobytes() == bare.q.tobytes()
    assert one.v.tobytes() == bare.v.tobytes()
    assert bits(one) == bits(other)
    assert one.state() == other.state()


def bits(simulation):
    return {
        name: (reading.time_ns, reading.values.tobytes())
        for name, reading in simulation.sensors().items()
    }


def test_states_copies_pickles_and_files_keep_readings_under_way(tmp_path):
    simulation = pendulum(NOISY)
    swing(simulation, 33)
    state = simulation.state()
    state.save(tmp_path / "state.npz")
    twins = [
        copy.copy(simulation),
        copy.deepcopy(simulation),
        pickle.loads(pickle.dumps(simulation)),
        Simulation(simulation.compiled, state),
        Simulation(simulation.compiled, SimulationState.load(tmp_path / "state.npz")),
    ]
    assert all(bits(twin) == bits(simulation) for twin in twins)
    swing(simulation, 40)
    for twin in twins:
        swing(twin, 40)
        assert bits(twin) == bits(simulation)
    simulation.restore(state)
    swing(simulation, 40)
    assert bits(simulation) == bits(twins[0])


def test_a_reset_begins_anew_and_nothing_from_before_arrives():
    simulation = pendulum(NOISY)
    swing(simulation, 30)
    simulation.reset()
    read = simulation.sensors()
    assert read["clean"].time_ns == read["slow"].time_ns == 30_000_000
    assert read["clean"]["position/hinge"] == 0.0
    assert np.isnan(read["late"].values).all()
    swing(simulation, 13)
    assert simulation.sensors()["late"].time_ns == 30_000_000


def test_an_interrupt_between_a_step_and_its_readings_loses_none(monkeypatch):
    simulation, other = pendulum(NOISY), pendulum(NOISY)
    sensing, times = simulation._sensing, []
    measure = sensing.measure

    def interrupted(now, index):
        times.append(index)
        if len(times) == 7:
            raise KeyboardInterrupt
        measure(now, index)

    monkeypatch.setattr(sensing, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulation.advance(40)
    simulation.advance(40 - simulation.step_index)
    other.advance(40)
    assert len(times) == len({*times}) + 1
    assert bits(simulation) == bits(other)
    assert simulation.state() == other.state()


def test_readings_that_no_sensor_made_are_refused():
    simulation = pendulum(NOISY)
    state = simulation.state()
    for place, change in ((0, 0.5), (0, 1.0), (0, -2.0), (3, -2.0), (3, 0.0), (3, 1.0)):
        sensed = state.sensed.copy()
        sensed[place] = change
        fields = {name: part for name, part in state.parts()} | {"sensed": sensed}
        with pytest.raises(StateError, match="sensed"):
            simulation.restore(SimulationState(**fields))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("encoder: clean", "encoder: dirty"), "sensors 'encoder clean of hinge.* is expected"),
        (("clean, joint: hinge, rate: 1000", "clean, joint: hinge, rate: 500"), "1000.0 Hz"),
        (("  - {encoder: clean, joint: hinge, rate: 1000}\n", ""), "it has 7 sensors, not 6"),
    ],
)
def test_a_state_of_other_sensors_is_of_another_model(change, words):
    state = pendulum(NOISY).state()
    with pytest.raises(OtherModel, match=words):
        pendulum(NOISY.replace(*change)).restore(state)


def test_a_quantity_that_a_sensor_has_not_is_refused_with_those_it_has():
    reading = pendulum(NOISY).sensors()["imu"]
    with pytest.raises(NoSuchPlace, match="orientation, angular_velocity, acceleration"):
        reading["force"]


def test_steps_to_the_next_reading_lead_to_it():
    simulation = pendulum("  - {encoder: a, joint: hinge, rate: 300, latency: 0.0045}")
    delivered = []
    for _ in range(6):
        simulation.advance(simulation.steps_to_reading())
        delivered.append(simulation.sensors()["a"].delivered_ns // 1_000_000)
        assert delivered[-1] == simulation.step_index
    assert delivered == [5, 9, 12, 15, 19, 22]
