"""Tendon paths, spans along a rod, schedules of loads."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from soft_sim_ros.scene import Schedule, TendonActuator, parse_scene
from soft_sim_ros.scene.taper import Taper
from soft_sim_ros.scene.tendon import HelicalPath, StraightPath

ROD = """
materials: {m: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}}
bodies:
  - rod: arm
    sections:
      - &one {name: a, length: 0.2, material: m, cross_section: {shape: circle, radius: 0.02}}
      - {<<: *one, name: b}
      - {<<: *one, name: c}
"""

numbers = st.floats(-0.05, 0.05)
tapers = st.builds(Taper, numbers, numbers)
paths = st.one_of(
    st.builds(StraightPath, tapers, tapers),
    st.builds(HelicalPath, tapers, st.floats(-7, 7), st.floats(-3, 3)),
)


@given(paths, st.floats(0.01, 0.3), st.floats(0.35, 0.9), st.floats(0, 1))
def test_slope_is_the_derivative_of_the_offset(path, start, end, fraction):
    tendon = TendonActuator("t", (0, 1), 0, "arm", start, end, path)
    step = (end - start) * 1e-4
    s = start + fraction * (end - start)
    stencil = tendon.offset(s + step * np.array([-2, -1, 1, 2]))
    derivative = np.array([1, -8, 8, -1]) @ stencil / (12 * step)
    assert tendon.slope(s) == pytest.approx(derivative, abs=1e-8)
    assert tendon.offset(s)[0] == tendon.slope(s)[0] == 0.0


def tendon_of(keys: str) -> TendonActuator:
    return parse_scene(f"{ROD}\nactuators:\n  - {{tendon: t, rod: arm, {keys}}}").actuators[0]


def test_straight_tendon_starts_and_ends_where_it_says():
    tendon = tendon_of("start: 0.1, end: 0.5, offset: {from: [0.01, 0], to: [0, -0.02]}")
    assert tendon.offset(np.array([0.1, 0.3, 0.5])) == pytest.approx(
        np.array([[0, 0.01, 0], [0, 0.005, -0.01], [0, 0, -0.02]]), abs=1e-17
    )


def test_helix_turns_from_y_towards_z_and_pitch_is_arc_length_per_turn():
    by_turns = tendon_of("end: 0.4, helix: {radius: 0.01, angle: 0.5, turns: 2}")
    by_pitch = tendon_of("end: 0.4, helix: {radius: 0.01, angle: 0.5, pitch: 0.2}")
    s = np.linspace(0, 0.4, 7)
    assert by_pitch.offset(s) == pytest.approx(by_turns.offset(s), abs=1e-17)
    quarter = tendon_of("end: 0.4, helix: {radius: 0.01, turns: 1}").offset(0.1)
    assert quarter == pytest.approx(np.array([0, 0, 0.01]), abs=1e-17)


def test_tendons_pull_by_default_and_moments_are_unlimited():
    assert tendon_of("offset: [0.01, 0]").limits == (0.0, math.inf)
    moment = "actuators: [{moment: m, rod: arm, section: a, strain: bend_y}]"
    (actuator,) = parse_scene(f"{ROD}\n{moment}").actuators
    assert (actuator.limits, actuator.safe, actuator.unit) == ((-math.inf, math.inf), 0.0, "N·m")
    (force,) = parse_scene(f"{ROD}\n{moment.replace('bend_y', 'stretch')}").actuators
    assert force.unit == "N"


def test_arc_lengths_that_mean_a_section_boundary_are_that_boundary():
    # 0.2 + 0.2 + 0.2 is not 0.6; the rod must not get a slice of 1e-16 m there.
    rod = parse_scene(ROD).bodies[0]
    assert rod.length != 0.6
    assert tendon_of("end: 0.6, offset: [0.01, 0]").end == rod.length
    (load,) = parse_scene(
        f"{ROD}\nloads: [{{point: p, body: arm, s: 0.6, force: [0, 0, 1]}}]"
    ).loads
    assert load.s == rod.length


def test_loads_act_at_the_tip_or_on_the_whole_rod_by_default():
    text = "loads:\n  - {point: p, body: arm, force: [0, 0, 1]}\n"
    text += "  - {distributed: d, body: arm, moment: [1, 0, 0], frame: body}\n"
    point, spread = parse_scene(ROD + text).loads
    length = parse_scene(ROD).bodies[0].length
    assert (point.s, point.frame, point.moment.tolist()) == (length, "world", [0, 0, 0])
    assert (spread.start, spread.end, spread.frame) == (0.0, length, "body")


def test_schedule_without_ramp_switches_exactly_at_its_times():
    schedule = Schedule(1.0, 2.0)
    before = [math.nextafter(1.0, 0.0), math.nextafter(2.0, 0.0)]
    assert [schedule.factor(t) for t in (before[0], 1.0, before[1], 2.0)] == [0, 1, 1, 0]
    assert schedule.switch_times == (1.0, 2.0)


def test_schedule_ramps_up_after_its_start_and_down_before_its_end():
    schedule = Schedule(1.0, 3.0, 0.5)
    times = (0.9, 1.0, 1.25, 1.5, 2.0, 2.5, 2.75, 3.0, 3.1)
    assert [schedule.factor(t) for t in times] == pytest.approx([0, 0, 0.5, 1, 1, 1, 0.5, 0, 0])
    assert schedule.switch_times == (1.0, 1.5, 2.5, 3.0)


def test_default_schedule_acts_from_zero_for_ever():
    assert Schedule().factor(0.0) == Schedule().factor(1e9) == 1.0
    assert Schedule().switch_times == (0.0,)
