"""What callers of Simulation rely on."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scenes import ALL, rod_document, rod_simulation, scene_of, zoo_document

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.simulation import LEDGER
from soft_sim_ros.core.terms.forcing import schedule_factor
from soft_sim_ros.errors import Diverged, SceneError, StaticsFailed
from soft_sim_ros.scene import Schedule, load_scene, packaged_scenes


def test_grouping_steps_into_calls_changes_no_bit():
    one, two = (Simulation(scene_of(zoo_document())) for _ in range(2))
    for simulation, groups in ((one, [60]), (two, [1, 2, 3, 4, 50])):
        simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
        for steps in groups:
            simulation.advance(steps)
            simulation.ledger()
            simulation.sampler(5).poses()
    assert one.q.tobytes() == two.q.tobytes() and one.v.tobytes() == two.v.tobytes()
    assert one.time_ns == two.time_ns == 60 * one.step_ns


def test_steps_allocate_nothing_in_python():
    simulation = Simulation(scene_of(zoo_document()))
    simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
    simulation.advance(10)

    def peak(steps):
        tracemalloc.start()
        simulation.advance(steps)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    # the least of some: other threads of the test's process allocate as well
    few, many = (min(peak(steps) for _ in range(4)) for steps in (200, 1000))
    assert many <= few + 1000  # bytes; a call has its price, a step has none


def test_reset_brings_back_the_same_bits_and_time_goes_on():
    simulation = Simulation(scene_of(zoo_document()))

    def run():
        simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
        simulation.set_tip_wrench(np.ones(6) * 0.1)
        simulation.advance(20)
        return simulation.q.tobytes()

    first = run()
    simulation.reset()
    assert simulation.time_ns == 20 * simulation.step_ns
    # the loads of this scene are constant, so the motion repeats
    assert run() == first


@pytest.mark.parametrize(
    "integrator", ["sdirk2", "generalized_alpha", "energy_midpoint", "adaptive"]
)
@pytest.mark.parametrize(("start", "end"), [(0.0123, 0.0571), (0.02, 0.05), (0.0, 0.0571)])
@pytest.mark.parametrize("late", [0, 10**7])
def test_a_load_acts_for_exactly_its_time_on_and_between_steps(integrator, start, end, late):
    """A moment M on for a time T, no multiple of the step, turns a wheel at M T / J."""
    document = rod_document(strains=["stretch"], order=0)
    document["bodies"] = [
        {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1]},
        {"rigid_body": "wheel", "mass": 1.0, "inertia": [0.1, 0.1, 0.2]},
    ]
    begin = late * 0.01
    document["loads"] = [
        {"point": "push", "body": "wheel", "moment": [0, 0, 0.7],
         "schedule": {"start": begin + start, "end": begin + end}},
    ]  # fmt: skip
    document["numerics"] = {"step": 0.01, "integrator": integrator}
    simulation = Simulation(scene_of(document))
    simulation.step_index = late
    simulation.advance(10)
    assert simulation.v[0] == pytest.approx(
        0.7 * (end - start) / 0.2, rel=1e-9 if not late else 1e-8
    )


def test_kernel_and_scene_agree_on_schedules():
    rng = np.random.default_rng(0)
    for _ in range(500):
        start, length, t = rng.uniform(-1, 1), rng.uniform(0.1, 2), rng.uniform(-2, 3)
        ramp = rng.choice([0.0, rng.uniform(0, length / 2)])
        schedule = Schedule(start, start + length, ramp)
        assert schedule_factor(start, start + length, ramp, t) == schedule.factor(t)


def test_work_of_actuators_and_loads_is_in_the_ledger():
    simulation = Simulation(scene_of(zoo_document() | {"gravity": [0, 0, -1.0]}))
    rng = np.random.default_rng(1)
    for _ in range(10):
        simulation.set_efforts(rng.uniform(0, 1, 4) * [0.1, 0.2, 5.0, 3.0])
        simulation.set_tip_wrench(rng.normal(size=6) * 0.05, rng.choice(["world", "tip"]))
        simulation.advance(50)
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    assert abs(ledger["actuator_work"]) > 1e-3 and abs(ledger["load_work"]) > 1e-3
    assert ledger["dissipated"] > 1e-3
    assert abs(ledger["residual"]) < 2e-3 * (ledger["dissipated"] + abs(ledger["load_work"]))


@pytest.mark.parametrize("integrator", ["sdirk2", "implicit_midpoint", "generalized_alpha"])
@pytest.mark.parametrize("name", ["soft_arm", "tendon_arm"])
def test_efforts_that_jump_at_every_step_do_not_disturb_the_method(name, integrator):
    scene = load_scene(name)
    low, high = np.array([a.limits for a in scene.actuators]).T
    efforts = np.random.default_rng(6).uniform(0.2 * low, 0.2 * high, (60, len(low)))

    def path(integrator, parts):
        numerics = replace(scene.numerics, integrator=integrator, step=scene.numerics.step / parts)
        simulation = Simulation(replace(scene, numerics=numerics))
        sampler = simulation.sampler(2)
        tips = []
        for row in efforts:
            simulation.set_efforts(row)
            simulation.advance(parts)
            tips.append(sampler.poses()[-1, :3].copy())
        return np.array(tips), simulation.ledger()

    exact, _ = path("sdirk4", 4)
    tips, ledger = path(integrator, 1)
    assert np.abs(tips - exact).max() < 1e-3 * 0.6
    assert abs(ledger[-1]) < 0.3 * ledger[-2]


@pytest.mark.parametrize("force", [100.0, 3e3, 1e4, 1e6])
@pytest.mark.parametrize("step", [0.002, 0.1, 0.5])
@pytest.mark.parametrize("integrator", ["sdirk2", "implicit_midpoint", "generalized_alpha"])
def test_no_energy_comes_from_nowhere(force, step, integrator):
    """A wild pull is followed, or refused, but never answered with more energy than was put in."""
    simulation = rod_simulation(
        strains=["bend_y", "bend_z"],
        material={"viscosity": 300.0},
        numerics={"basis": {"order": 2}, "step": step, "integrator": integrator},
    )
    simulation.set_tip_wrench(np.array([0, 0, 0, 0, 0, force]))
    most = force * 2 * 0.6  # a dead force cannot do more work than this on a rod of 0.6 m
    for _ in range(10):
        try:
            simulation.advance(1)
        except Diverged:
            break
        kinetic, elastic = simulation.ledger()[:2]
        assert kinetic + elastic < 1.5 * most


def test_a_coordinate_without_mass_is_named():
    document = rod_document(strains=["stretch"], order=0)
    document["bodies"].append({"joint": "wrist", "kind": "revolute", "axis": [1, 0, 0]})
    with pytest.raises(SceneError, match="wrist"):
        Simulation(scene_of(document))


def test_too_few_nodes_are_refused():
    with pytest.raises(SceneError, match="nodes"):
        rod_simulation(order=4, nodes=3)
    section = {"reference": {"curvature": [60.0, 0, 0]}}
    with pytest.raises(SceneError, match="turns by"):
        rod_simulation(order=2, nodes=5, section=section)
    rod_simulation(order=2, section=section)  # by default there are enough


def test_an_unheld_hinge_is_named_where_an_equilibrium_is_asked_for():
    document = rod_document(gravity=(0, 0, -9.81), strains=["bend_y"])
    document["bodies"].insert(0, {"joint": "turntable", "kind": "revolute", "axis": [0, 0, 1]})
    document["initial"] = {"state": "equilibrium"}
    with pytest.raises(StaticsFailed, match=r"initial.positions.turntable"):
        Simulation(scene_of(document))


def test_state_can_be_set_and_the_ledger_starts_there():
    one, two = (Simulation(scene_of(zoo_document())) for _ in range(2))
    one.advance(30)
    two.set_state(one.q, one.v)
    np.testing.assert_array_equal(two.q, one.q)
    assert two.ledger()[-1] == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ValueError, match="finite"):
        two.set_state(np.full(one.n_coordinates, np.nan), one.v)


def test_a_pendulum_swings_like_one():
    """Rigid limit: a hinge with a payload is the mathematical pendulum of elliptic period."""
    from scipy.special import ellipk

    length, start = 0.5, 2.0
    document = rod_document(gravity=(0, 0, -9.81))
    document["bodies"] = [
        {"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0],
         "offset": {"rpy": [0, np.pi / 2, 0]}},
        {"joint": "arm", "kind": "fixed", "offset": {"position": [length, 0, 0]}},
        {"rigid_body": "bob", "mass": 0.3, "inertia": [0, 0, 0]},
    ]  # fmt: skip
    document["numerics"] = {"step": 0.001, "integrator": "sdirk4"}
    document["initial"] = {"positions": {"hinge": start}}
    simulation = Simulation(scene_of(document))
    period = 4 * np.sqrt(length / 9.81) * ellipk(np.sin(start / 2) ** 2)
    simulation.advance(round(period / 0.001))
    left = period - simulation.time
    assert simulation.q[0] + left * simulation.v[0] == pytest.approx(start, abs=1e-5)


def test_quaternions_do_not_jump_while_the_arm_turns_over():
    document = rod_document(strains=ALL[:1], order=0)
    document["bodies"].insert(0, {"joint": "spin", "kind": "revolute", "axis": [1, 1, 0]})
    document["initial"] = {"velocities": {"spin": 12.0}}
    simulation = Simulation(scene_of(document))
    sampler = simulation.sampler(4)
    before = sampler.poses()[:, 3:].copy()
    for _ in range(300):
        simulation.advance(2)
        now = sampler.poses()[:, 3:]
        assert np.all(np.sum(before * now, axis=1) > 0.99)
        np.testing.assert_allclose(np.linalg.norm(now, axis=1), 1.0, atol=1e-12)
        before = now.copy()


def test_poses_between_nodes_lie_on_the_curve_of_the_nodes():
    simulation = Simulation(scene_of(zoo_document()))
    simulation.advance(50)
    nodes = simulation.dynamics.node_poses(simulation.q)
    ends = [rod_map.last_node for rod_map in simulation.compiled.chain.rods.values()]
    fine = simulation.sampler(25).poses()
    distance = min(np.linalg.norm(fine[:, :3] - nodes[ends[0]][:3, 3], axis=1))
    assert distance < 0.6 / 24 * 1.5
    np.testing.assert_allclose(fine[-1, :3], nodes[ends[1]][:3, 3], atol=1e-12)
    assert len(simulation.sampler(1).poses()) == 1


def test_state_cannot_be_written_from_outside():
    simulation = rod_simulation()
    with pytest.raises(ValueError, match="read-only"):
        simulation.q[0] = 1.0


@pytest.mark.parametrize("bad", [[1.0], [np.nan] * 4, [[0.0] * 4]])
def test_bad_efforts_are_refused(bad):
    with pytest.raises(ValueError, match="efforts"):
        Simulation(scene_of(zoo_document())).set_efforts(bad)


def test_an_impossible_step_ends_in_diverged_with_the_last_good_state():
    simulation = rod_simulation(
        strains=["stretch"], order=0, numerics={"basis": {"order": 0}, "max_iterations": 2}
    )
    document = rod_document(strains=ALL[:4])
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    simulation = Simulation(scene_of(document))
    simulation.advance(5)
    simulation.set_efforts([1e9])
    with pytest.raises(Diverged) as failure:
        simulation.advance(1000)
    assert np.isfinite(simulation.q).all() and np.isfinite(simulation.v).all()
    assert failure.value.time == simulation.time


@pytest.mark.parametrize("moment", [1e3, 1e6, 1e12, 1e100, 1e300])
@pytest.mark.parametrize("integrator", ["sdirk2", "generalized_alpha"])
def test_a_moment_far_beyond_the_rod_is_refused_not_followed_into_nonsense(moment, integrator):
    document = rod_document(
        strains=ALL[:4], material={"viscosity": 300.0}, numerics={"integrator": integrator}
    )
    document["actuators"] = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"}]
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([moment])
    with pytest.raises(Diverged):
        simulation.advance(2000)
    assert np.isfinite(simulation.q).all() and np.isfinite(simulation.v).all()
    # what is left is the last good state: bent by less than half a turn per segment
    assert np.abs(simulation.ports()[0]).max() < np.pi * len(simulation.model.half)


def test_a_refused_step_leaves_every_bit_as_it_was():
    document = rod_document(strains=ALL[:4])
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.01, 0.0]}]
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([3.0])
    simulation.advance(50)
    simulation.set_efforts([1e9])
    with pytest.raises(Diverged):
        simulation.advance(1000)
    state, ledger = simulation.q.tobytes() + simulation.v.tobytes(), simulation.ledger()
    with pytest.raises(Diverged):
        simulation.advance(1)
    assert simulation.q.tobytes() + simulation.v.tobytes() == state
    np.testing.assert_array_equal(simulation.ledger(), ledger)


def test_options_without_effect_are_refused():
    document = rod_document(numerics={"options": {"rho": 0.5}})
    with pytest.raises(SceneError, match="rho"):
        Simulation(scene_of(document))


@pytest.mark.parametrize("name", sorted(packaged_scenes()))
def test_packaged_scenes_move_and_stay_finite(name):
    simulation = Simulation(load_scene(name))
    rng = np.random.default_rng(4)
    for _ in range(5):
        limits = np.array([a.limits for a in simulation.scene.actuators]).reshape(-1, 2)
        low, high = np.clip(limits, -1.0, 1.0).T
        simulation.set_efforts(rng.uniform(low, high))
        simulation.advance(40)
    assert np.isfinite(simulation.ledger()).all()
    assert np.abs(simulation.sampler(5).poses()[:, :3]).max() < 5.0
