"""Tendon paths, spans along a rod, schedules of loads."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import ChamberActuator, Schedule, TendonActuator, parse_scene
from soft_sim_ros.scene.taper import Taper
from soft_sim_ros.scene.tendon import HelicalPath, StraightPath, Stretch, TablePath

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
    st.builds(lambda a, b, c, d: TablePath((0.0, 0.3, 0.7, 1.0), (a, b, c, d)),
              *[st.tuples(numbers, numbers)] * 4),
)  # fmt: skip


@given(paths, st.floats(0.01, 0.3), st.floats(0.35, 0.9), st.floats(0, 1))
def test_slope_is_the_derivative_of_the_offset(path, start, end, fraction):
    tendon = Stretch("arm", start, end, path)
    step = (end - start) * 1e-4
    s = start + fraction * (end - start)
    stencil = tendon.offset(s + step * np.array([-2, -1, 1, 2]))
    derivative = np.array([1, -8, 8, -1]) @ stencil / (12 * step)
    # a spline has jumps in its third derivative, and no more than these
    assert tendon.slope(s) == pytest.approx(derivative, abs=2e-7)
    assert tendon.offset(s)[0] == tendon.slope(s)[0] == tendon.curvature(s)[0] == 0.0
    stencil = tendon.slope(s + step * np.array([-2, -1, 1, 2]))
    derivative = np.array([1, -8, 8, -1]) @ stencil / (12 * step)
    assert tendon.curvature(s) == pytest.approx(derivative, abs=1e-3)


def tendon_of(keys: str) -> TendonActuator:
    return parse_scene(f"{ROD}\nactuators:\n  - {{tendon: t, rod: arm, {keys}}}").actuators[0]


def test_straight_tendon_starts_and_ends_where_it_says():
    (tendon,) = tendon_of(
        "start: 0.1, end: 0.5, offset: {from: [0.01, 0], to: [0, -0.02]}"
    ).stretches
    assert tendon.offset(np.array([0.1, 0.3, 0.5])) == pytest.approx(
        np.array([[0, 0.01, 0], [0, 0.005, -0.01], [0, 0, -0.02]]), abs=1e-17
    )


def test_helix_turns_from_y_towards_z_and_pitch_is_arc_length_per_turn():
    (by_turns,) = tendon_of("end: 0.4, helix: {radius: 0.01, angle: 0.5, turns: 2}").stretches
    (by_pitch,) = tendon_of("end: 0.4, helix: {radius: 0.01, angle: 0.5, pitch: 0.2}").stretches
    s = np.linspace(0, 0.4, 7)
    assert by_pitch.offset(s) == pytest.approx(by_turns.offset(s), abs=1e-17)
    quarter = tendon_of("end: 0.4, helix: {radius: 0.01, turns: 1}").stretches[0].offset(0.1)
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
    assert tendon_of("end: 0.6, offset: [0.01, 0]").stretches[0].end == rod.length
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


MISTAKES = [
    ("tendon: t, rod: arm", "one of the keys offset, helix, points"),
    ("tendon: t, rod: arm, ofset: [0.01, 0]", "(did you mean offset?)"),
    ("tendon: t, rod: arm, offset: [0.01, 0], points: []", "only one of offset and points"),
    ("tendon: t, rod: arm, points: 3", "points = 3: expected a list of lists of 3 numbers"),
    ("tendon: t, rod: arm, points: [[0, 0.01]]", "points[0] = [0, 0.01]: expected a list of lists"),
    ("tendon: t, rod: arm, points: [[0, 0.01, x], [1, 0, 0]]", "points[0][2] = x: expected a fini"),
    ("tendon: t, rod: arm, points: [[0.1, 0, 0]]", "at least two points [s, y, z]"),
    ("tendon: t, rod: arm, points: [[0.1, 0, 0], [0.1, 0, 1]]", "in the order of rising s"),
    ("tendon: t, rod: arm, points: [[0, 0, 0], [0.7, 0, 0]]", "every s a number in [0, 0.6]"),
    (
        "tendon: t, rod: arm, end: 0.3, points: [[0, 0, 0], [0.6, 0, 0]]",
        "end = 0.3: expected",
    ),
    ("tendon: t, rod: arm, offset: [0, 0], control: force", "one of tension, length"),
    (
        "tendon: t, rod: arm, offset: [0, 0], control: length",
        "axial_stiffness is missing",
    ),
    ("tendon: t, rod: arm, offset: [0, 0], axial_stiffness: 1", "it is for a tendon with control:"),
    (
        "tendon: t, rod: arm, offset: [0, 0], axial_damping: 1",
        "it is for a tendon with control",
    ),
    ("tendon: t, rod: arm, offset: [0, 0], control: length, axial_stiffness: 0", "a number > 0"),
    (
        "tendon: t, rod: arm, offset: [0, 0], friction: -0.1",
        "friction = -0.1: expected a number",
    ),
    ("tendon: t, rod: arm, offset: [0, 0], slip_speed: 0.1", "it is for a tendon with friction"),
    ("tendon: t, rod: arm, offset: [0, 0], friction: 0.1, slip_speed: 0", "a number > 0"),
    ("tendon: t, rod: arm, offset: [0, 0], section: a", "section = a: expected a known key"),
    ("chamber: t, rod: arm, offset: [0, 0]", "area is missing: expected a number > 0"),
    ("chamber: t, rod: arm, offset: [0, 0], area: 0", "area = 0: expected a number > 0"),
    (
        "chamber: t, rod: arm, offset: [0, 0], area: 1, friction: 0.1",
        "friction = 0.1: expected a",
    ),
    (
        "chamber: t, rod: arm, offset: [0, 0], area: 1, section: z",
        "section of the rod, one of a",
    ),
    ("chamber: t, rod: arm, offset: [0, 0], area: 1, section: a, end: 0.1", "the section says it"),
]


@pytest.mark.parametrize(("keys", "expected"), MISTAKES)
def test_mistakes_in_tendons_and_chambers_name_the_key_and_what_is_expected(keys, expected):
    with pytest.raises(SceneError) as failure:
        parse_scene(f"{ROD}\nactuators:\n  - {{{keys}}}")
    assert "actuators[0]" in str(failure.value) and expected in str(failure.value)


def test_units_of_commands_and_a_chamber_may_be_named_by_its_section():
    keys = "offset: [0.01, 0], control: length, axial_stiffness: 1e4, limits: [-0.1, 0.1]"
    winch = tendon_of(keys)
    assert (winch.unit, winch.limits, winch.friction) == ("m", (-0.1, 0.1), 0.0)
    assert tendon_of("offset: [0.01, 0], friction: 0.2").slip_speed == 1e-3
    chamber = "{chamber: c, rod: arm, section: b, offset: [0.01, 0], area: 1e-4}"
    (actuator,) = parse_scene(f"{ROD}\nactuators: [{chamber}]").actuators
    assert isinstance(actuator, ChamberActuator) and actuator.unit == "Pa"
    (stretch,) = actuator.stretches
    assert (stretch.start, stretch.end) == pytest.approx((0.2, 0.4))
    assert actuator.limits == (-math.inf, math.inf)
