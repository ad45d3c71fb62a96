"""Sensors against closed forms, balances and difference quotients."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros import Simulation, parse_scene

RADIUS, LENGTH, YOUNG, SHEAR, DENSITY = 0.01, 0.5, 1e6, 1e6 / 3.0, 1100.0
AREA, INERTIA = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
MASS = DENSITY * AREA * LENGTH
ROD = """
materials:
  rubber: {density: 1100, young_modulus: 1.0e6, poisson_ratio: 0.5, viscosity: 200}
"""
ARM = """
  - rod: arm
    sections:
      - {name: only, length: 0.5, material: rubber, cross_section: {shape: circle, radius: 0.01}}
"""


@lru_cache
def scene(text):
    return parse_scene(ROD + text, "sensors.yaml")


def rod_scene(sensors, more="", rod=ARM, numerics=""):
    text = f"bodies:{rod}{more}\nsensors:\n{sensors}\n"
    return scene(text + (numerics or "numerics: {step: 0.001, basis: {order: 3}}\n"))


# Strain and curvature.


def small_load(force, moment, sensors):
    loads = f"loads:\n  - {{point: pull, body: arm, force: {force}, moment: {moment}}}\n"
    more = f"gravity: [0, 0, 0]\n{loads}initial: {{state: equilibrium}}"
    return Simulation(rod_scene(sensors, f"\n{more}"))


def test_a_strain_gauge_reads_bending_by_euler_and_bernoulli():
    sensors = """
  - {strain: top, rod: arm, s: 0.1, offset: [0.0, 0.01]}
  - {strain: side, rod: arm, s: 0.1, offset: [0.01, 0.0]}
  - {strain: low, rod: arm, s: 0.4, offset: [0.0, -0.004]}
  - {curvature: fbg, rod: arm, s: [0.1, 0.4]}"""
    force = 1e-4
    read = small_load([0.0, 0.0, -force], [0.0, 0.0, 0.0], sensors).sensors()
    moment = force * (LENGTH - 0.1)  # the load pulls down: what is on top gets longer
    assert read["top"]["strain"] == pytest.approx(moment * 0.01 / (YOUNG * INERTIA), rel=1e-3)
    assert abs(read["side"]["strain"]) < 1e-3 * read["top"]["strain"]
    below = -force * (LENGTH - 0.4) * 0.004 / (YOUNG * INERTIA)
    assert read["low"]["strain"] == pytest.approx(below, rel=2e-3)
    # bending about +y turns x towards −z
    assert read["fbg"]["curvature/0/bend_y"] == pytest.approx(moment / (YOUNG * INERTIA), rel=1e-3)
    assert read["fbg"]["curvature/1/bend_y"] == pytest.approx(-below / 0.004, rel=2e-3)


def test_a_strain_gauge_reads_stretch_and_torsion_in_its_direction():
    sensors = """
  - {strain: along, rod: arm, s: 0.2, offset: [0.0, 0.0]}
  - {strain: right, rod: arm, s: 0.2, offset: [0.01, 0.0], direction: [1, 0, 1]}
  - {strain: left, rod: arm, s: 0.2, offset: [0.01, 0.0], direction: [1, 0, -1]}"""
    pull, twist = 0.02, 1e-6
    read = small_load([pull, 0.0, 0.0], [0.0, 0.0, 0.0], sensors).sensors()
    assert read["along"]["strain"] == pytest.approx(pull / (YOUNG * AREA), rel=1e-6)
    read = small_load([0.0, 0.0, 0.0], [twist, 0.0, 0.0], sensors).sensors()
    # the shear γ = T r / G J of a surface is a strain of ± γ/2 at 45°
    shear = twist * RADIUS / (SHEAR * 2.0 * INERTIA)
    assert read["right"]["strain"] == pytest.approx(0.5 * shear, rel=1e-3)
    assert read["left"]["strain"] == pytest.approx(-0.5 * shear, rel=1e-3)


def test_a_strain_gauge_of_a_curved_rod_reads_nothing_without_load():
    rod = ARM.replace("radius: 0.01}}", "radius: 0.01}, reference: {curvature: [0, 3.0, 0]}}")
    sensors = """
  - {strain: gauge, rod: arm, s: 0.2, offset: [0.0, 0.01], direction: [1, 0.5, 0]}
  - {curvature: fbg, rod: arm, s: 0.2}"""
    read = Simulation(rod_scene(sensors, "\ngravity: [0, 0, 0]", rod)).sensors()
    assert abs(read["gauge"]["strain"]) < 1e-15
    assert read["fbg"]["curvature/bend_y"] == pytest.approx(3.0, rel=1e-12)


# Inertial units.


def test_an_imu_at_rest_reads_gravity_upwards_in_its_own_axes():
    sensors = """
  - {imu: tip, body: arm}
  - {imu: mid, body: arm, s: 0.123, offset: {position: [0.0, 0.01, 0.0], rpy: [0.3, 0.2, 0.1]}}"""
    more = "\ngravity: [0.5, 0, -9.7]\nbase: {rpy: [0.1, 0.4, -0.7]}\ninitial: {state: equilibrium}"
    simulation = Simulation(rod_scene(sensors, more))
    simulation.advance(5)
    for reading in simulation.sensors().values():
        turn = Rotation.from_quat(reading["orientation"])
        np.testing.assert_allclose(turn.apply(reading["acceleration"]), [-0.5, 0, 9.7], atol=1e-4)
        np.testing.assert_allclose(reading["angular_velocity"], 0.0, atol=1e-6)
    pose = simulation.sampler(2).poses()[-1]
    tip = simulation.sensors()["tip"]["orientation"]
    np.testing.assert_allclose(abs(tip @ pose[3:]), 1.0, rtol=1e-12)


SPINNING = """
bodies:
  - {joint: loose, kind: free}
  - {rigid_body: ball, mass: 2.0, inertia: [0.01, 0.01, 0.01]}
initial: {velocities: {loose: [0, 0, 3.0, 0.5, 0, 0]}}
sensors:
  - {imu: centre, body: ball, rate: 500}
  - {imu: rim, body: ball, offset: {position: [0.2, 0, 0]}, rate: 500}
numerics: {step: 0.002, integrator: %s, newton_tolerance: 1.0e-13}
"""


@pytest.mark.parametrize("method", ["sdirk2", "adaptive"])
def test_an_imu_in_free_fall_reads_nothing_but_what_its_spin_gives(method):
    simulation = Simulation(scene(SPINNING % method))
    for steps in (1, 1, 400, 200, 398):  # the chart of its rotation is left after half a turn
        simulation.advance(steps)
        read = simulation.sensors()
        np.testing.assert_allclose(read["centre"]["acceleration"], 0.0, atol=1e-7)
        np.testing.assert_allclose(read["centre"]["angular_velocity"], [0, 0, 3.0], atol=1e-7)
        inwards = [-(3.0**2) * 0.2, 0.0, 0.0]
        np.testing.assert_allclose(read["rim"]["acceleration"], inwards, atol=1e-6)


def test_an_imu_on_a_driven_joint_reads_euler_and_centripetal_acceleration():
    text = """
gravity: [0, 0, -9.81]
bodies:
  - {joint: table, kind: revolute, axis: [0, 0, 1], driven: "1.5 * t**2"}
  - {rigid_body: plate, mass: 1.0, inertia: [0.1, 0.1, 0.1]}
sensors:
  - {imu: rim, body: plate, offset: {position: [0.3, 0, 0]}, rate: 100}
  - {encoder: angle, joint: table}
numerics: {step: 0.001}
"""
    simulation = Simulation(scene(text))
    simulation.advance(1000)
    read = simulation.sensors()
    rate, speed = 3.0, 3.0
    wanted = [-(speed**2) * 0.3, rate * 0.3, 9.81]
    np.testing.assert_allclose(read["rim"]["acceleration"], wanted, rtol=1e-9)
    np.testing.assert_allclose(read["rim"]["angular_velocity"], [0, 0, speed], rtol=1e-12)
    assert read["angle"]["position/table"] == pytest.approx(1.5, rel=1e-12)
    assert read["angle"]["velocity/table"] == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize("method", ["sdirk2", "sdirk4", "generalized_alpha", "adaptive"])
def test_an_imu_reads_the_difference_quotients_of_its_path(method):
    sensors = """
  - {imu: tip, body: arm, rate: 1000}
  - {imu: mid, body: arm, s: 0.217, rate: 1000}"""
    numerics = f"numerics: {{step: 0.001, integrator: {method}, basis: {{order: 3}}}}\n"
    more = "\ngravity: [0, 3.0, -9.81]"
    simulation = Simulation(rod_scene(sensors, more, numerics=numerics))
    simulation.advance(150)
    # places of a sampler at the ends and at 0.217 m of 0.5 m
    frames = simulation.sampler(501)
    path, read = [], []
    for _ in range(3):
        path.append(frames.poses()[[-1, 217]].copy())
        read.append(simulation.sensors())
        simulation.advance(1)
    h = simulation.step_ns * 1e-9
    for i, name in enumerate(("tip", "mid")):
        a = (path[2][i, :3] - 2.0 * path[1][i, :3] + path[0][i, :3]) / h**2
        turn = Rotation.from_quat(path[1][i, 3:])
        force = turn.inv().apply(a - np.array([0.0, 3.0, -9.81]))
        np.testing.assert_allclose(read[1][name]["acceleration"], force, rtol=2e-2, atol=0.03)
        ends = [Rotation.from_quat(path[k][i, 3:]) for k in (0, 2)]
        omega = (turn.inv() * (ends[1] * ends[0].inv()) * turn).as_rotvec() / (2.0 * h)
        np.testing.assert_allclose(read[1][name]["angular_velocity"], omega, rtol=1e-3, atol=1e-3)


# Wrenches.

HELD = """
gravity: [0, 1.0, -9.81]
base: {rpy: [0.2, -0.3, 0.5]}
bodies:
  - rod: arm
    sections:
      - {name: only, length: 0.5, material: rubber, cross_section: {shape: circle, radius: 0.01}}
  - {rigid_body: ring, mass: 0.02, inertia: [1e-6, 1e-6, 1e-6]}
  - {joint: wrist, kind: fixed}
  - {rigid_body: camera, mass: 0.03, inertia: [1e-6, 1e-6, 1e-6]}
  - {rigid_body: tool, mass: 0.05, inertia: [1e-5, 2e-5, 3e-5], com: {position: [0.04, 0, 0.01]}}
  - {rigid_body: cargo, mass: 0.04, inertia: [1e-6, 1e-6, 1e-6], attached: true, parent: tool}
  - {rod: twig, parent: {body: arm}, sections: [
       {name: t, length: 0.1, material: rubber, cross_section: {shape: circle, radius: 0.005}}]}
  - {rod: other, parent: base, sections: [
       {name: o, length: 0.2, material: rubber, cross_section: {shape: circle, radius: 0.01}}]}
loads:
  - {point: pull, body: arm, force: [0.1, 0, 0]}
  - {distributed: wind, body: arm, force: [0, 0.2, 0]}
  - {point: push, body: tool, force: [0, 0, 0.05], frame: body}
  - {input: hand, body: arm, frame: body}
initial: {state: equilibrium}
sensors:
  - {wrench: clamp, body: arm, rate: 1000}
  - {wrench: wrist, body: wrist, rate: 1000}
  - {wrench: second, body: other, rate: 1000}
  - {imu: pose, body: wrist, rate: 1000}
numerics: {step: 0.001, basis: {order: 2}}
"""
PULL = np.array([0.0, 1.0, -9.81])


def at_rest(text):
    simulation = Simulation(scene(text))
    simulation.advance(10)
    return simulation


def test_a_wrench_at_a_joint_is_that_of_what_is_beyond_alone():
    """Not of the end of the rod and the ring before it, nor of a branch, which share its place."""
    simulation = at_rest(HELD)
    read = simulation.sensors()
    turn = Rotation.from_quat(read["pose"]["orientation"])
    mass = 0.03 + 0.05 + 0.04
    push = np.array([0.0, 0.0, 0.05])
    weight = turn.inv().apply(mass * PULL)
    np.testing.assert_allclose(read["wrist"]["force"], weight + push, atol=1e-6)
    # the tool's frame, where it is pushed and the cargo hangs, is at the wrist
    moment = np.cross([0.04, 0, 0.01], turn.inv().apply(0.05 * PULL))
    np.testing.assert_allclose(read["wrist"]["torque"], moment, atol=1e-7)
    read = at_rest(HELD.replace("attached: true", "attached: false")).sensors()
    turn = Rotation.from_quat(read["pose"]["orientation"])
    np.testing.assert_allclose(
        read["wrist"]["force"], turn.inv().apply(0.08 * PULL) + push, atol=1e-6
    )


def test_a_wrench_at_a_clamp_is_what_the_arm_does_to_the_ground():
    """Its weight points down: the arm pulls at the ground where gravity points to."""
    simulation = at_rest(HELD)
    read = simulation.sensors()
    base = simulation.compiled.base[:3, :3]
    twig = DENSITY * np.pi * 0.005**2 * 0.1
    mass = MASS + twig + 0.02 + 0.03 + 0.05 + 0.04
    turn = Rotation.from_quat(read["pose"]["orientation"])
    loads = np.array([0.1, 0.2 * LENGTH, 0.0]) + turn.apply([0.0, 0.0, 0.05])
    np.testing.assert_allclose(base @ read["clamp"]["force"], mass * PULL + loads, atol=1e-5)
    own = DENSITY * AREA * 0.2
    np.testing.assert_allclose(base @ read["second"]["force"], own * PULL, atol=1e-6)
    middle = np.cross(base[:, 0] * 0.1, own * PULL)  # it hardly bends
    np.testing.assert_allclose(base @ read["second"]["torque"], middle, rtol=0.02, atol=1e-5)


@pytest.mark.parametrize("method", ["sdirk2", "sdirk4", "adaptive", "implicit_midpoint"])
def test_a_wrench_in_motion_balances_the_rate_of_momentum(method):
    sensors = "  - {wrench: clamp, body: arm, rate: 1000}"
    numerics = f"numerics: {{step: 0.001, integrator: {method}, basis: {{order: 3}}}}\n"
    more = "\ngravity: [0, 3.0, -9.81]\nloads: [{point: pull, body: arm, force: [0, 0, 0.2]}]"
    simulation = Simulation(rod_scene(sensors, more, numerics=numerics))
    simulation.advance(200)
    swung = []
    for k in range(3):
        swung.append(simulation.dynamics.momentum(simulation.q, simulation.v))
        if k == 1:
            read = simulation.sensors()["clamp"]
            centre = simulation.dynamics.node_poses(simulation.q)[:, :3, 3]
            masses = simulation.model.inertia[:, 0]
            tip = centre[-1]
        simulation.advance(1)
    rate = (swung[2] - swung[0]) / 0.002
    gravity, load = np.array([0, 3.0, -9.81]), np.array([0, 0, 0.2])
    outer = masses.sum() * gravity + load
    turn = np.cross(masses @ centre, gravity) + np.cross(tip, load)
    size = np.abs(rate[3:]).max()
    assert size > 0.05
    np.testing.assert_allclose(read["force"], outer - rate[3:], atol=0.02 * size)
    np.testing.assert_allclose(read["torque"], turn - rate[:3], atol=0.02 * np.abs(rate[:3]).max())


# Tendons.


def test_a_tendon_gauge_reads_the_length_of_its_path():
    sensors = "  - {tendon: pull, actuator: pull, rate: 1000}"
    more = """
gravity: [0, 0, 0]
actuators:
  - {tendon: pull, rod: arm, start: 0.0, end: 0.4, offset: {from: [0.0, 0.008], to: [0.003, 0.004]}}
"""
    simulation = Simulation(rod_scene(sensors, more))
    simulation.set_efforts([0.4])
    simulation.advance(100)
    read = simulation.sensors()["pull"]
    s = np.linspace(0.0, 0.4, 2001)
    poses = simulation.sampler(2501).poses()[:2001]
    offset = np.stack([0 * s, 0.003 * s / 0.4, 0.008 - 0.004 * s / 0.4], axis=1)
    path = poses[:, :3] + Rotation.from_quat(poses[:, 3:]).apply(offset)
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert read["length"] == pytest.approx(length, rel=1e-6)
    assert read["length"] < 0.3995  # it is pulled in
    assert read["tension"] == 0.4
    simulation.advance(1)
    after = simulation.sensors()["pull"]
    rate = (after["length"] - read["length"]) / 0.001
    assert abs(rate) > 1e-3
    assert 0.5 * (read["rate"] + after["rate"]) == pytest.approx(rate, rel=0.01)


def test_a_load_cell_at_the_start_of_a_rod_that_follows_another_feels_the_second_alone():
    text = """
gravity: [0, 0, -9.81]
bodies:
  - rod: first
    sections:
      - {name: f, length: 0.2, material: rubber, cross_section: {shape: circle, radius: 0.01}}
  - rod: second
    sections:
      - {name: s, length: 0.1, material: rubber, cross_section: {shape: circle, radius: 0.005}}
loads:
  - {point: pull, body: first, force: [0, 1.0, 0]}
  - {distributed: wind, body: first, force: [0, 2.0, 0]}
  - {distributed: breeze, body: second, force: [0, 0.3, 0]}
initial: {state: equilibrium}
sensors:
  - {wrench: cell, body: second, rate: 1000}
  - {imu: pose, body: second, s: 0.0, rate: 1000}
numerics: {step: 0.001, basis: {order: 2}}
"""
    read = at_rest(text).sensors()
    weight = DENSITY * np.pi * 0.005**2 * 0.1 * np.array([0.0, 0.0, -9.81])
    turn = Rotation.from_quat(read["pose"]["orientation"])
    wanted = turn.inv().apply(weight + np.array([0.0, 0.03, 0.0]))
    np.testing.assert_allclose(read["cell"]["force"], wanted, atol=1e-6)
