"""Data that change fast are found and cut, however narrow; data that change gently are left."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import rod_document, scene_of

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.enclosure import enclose
from soft_sim_ros.scene.expression import Expression
from soft_sim_ros.scene.profile import register_profile


def section_of(**section):
    """Return a section of 0.3 m."""
    return scene_of(rod_document(length=0.3, section=section)).bodies[0].sections[0]


def with_radius(radius):
    return section_of(cross_section={"shape": "circle", "radius": radius})


FORMULAS = [
    "2 - 3*s", "s**2 - 0.1*s", "(s - 0.2)**3", "(s - 0.2)**-2", "1/(s - 0.15)", "exp(-s)/(1 + s)",
    "sin(9*s)", "cos(20*s - 1)*s", "tan(4*s)", "cosh(5*s - 1)", "sqrt(s)", "log(s + 0.1)",
    "atan(s/0.01) - tanh(s)*sinh(s)", "s**s", "(s + 0.1)**0.5", "-pi*s", "2**(3*s)",
    "sqrt(s - 0.1)",
]  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(FORMULAS), st.floats(0.0, 0.299), st.floats(1e-6, 0.3))
def test_bounds_of_a_formula_hold_all_its_values(text, begin, width):
    formula, end = Expression(text), min(0.3, begin + width)
    low, high = enclose(formula, np.array([begin]), np.array([end]))
    values = formula(np.linspace(begin, end, 301))
    values = values[np.isfinite(values)]
    slack = 1e-12 * (1.0 + np.abs(values).max(initial=0.0))
    assert (values >= low - slack).all() and (values <= high + slack).all()


@pytest.mark.parametrize("text", FORMULAS[:2] + FORMULAS[5:12])
def test_bounds_close_in_on_the_values_of_short_intervals(text):
    formula, s = Expression(text), np.linspace(0.02, 0.28, 14)
    low, high = enclose(formula, s, s + 1e-7)
    assert np.abs(high - low).max() < 1e-4 * (1.0 + np.abs(formula(s)).max())


@settings(max_examples=25, deadline=None)
@given(st.floats(0.02, 0.28), st.floats(2.5e-5, 2e-3), st.floats(0.3, 0.7))
def test_a_narrow_feature_of_a_formula_is_found_wherever_it_is(place, width, depth):
    section = with_radius(
        {"expression": f"0.01*(1 - {depth!r}*exp(-((s - {place!r})/{width!r})**2))"}
    )
    cuts = 0.3 * np.array(section.cuts)
    assert len(cuts) <= 12
    # cuts on both sides, or one in it: no piece has the feature inside and is much longer
    ends = np.array([0.0, *cuts, 0.3])
    piece = np.searchsorted(ends, place) - 1
    assert np.diff(ends)[piece] < 30.0 * width


@pytest.mark.parametrize(
    "radius",
    [
        0.01,
        [0.02, 0.004],
        {"expression": "0.01 + 0.005*s"},
        {"expression": "0.01*exp(-2*s)"},
        {"expression": "0.01 + 0.002*sin(10*s)"},
        {"table": [[0.0, 0.01], [0.1, 0.011], [0.3, 0.012]]},
    ],
)
def test_gentle_data_are_not_cut(radius):
    assert with_radius(radius).cuts == ()


def test_a_jump_needs_one_cut():
    section = with_radius({"expression": "0.01 + 0.004*tanh((s - 0.1)/1e-7)"})
    assert 0.3 * np.array(section.cuts) == pytest.approx([0.1], abs=1e-4)


def test_narrow_features_of_functions_and_tables_are_cut_too():
    register_profile("dented", lambda s: 0.01 - 0.006 * np.exp(-(((s - 0.0777) / 4e-4) ** 2)))
    s = np.unique(np.concatenate([np.linspace(0.0, 0.3, 31), np.linspace(0.19, 0.2, 41)]))
    table = np.stack([s, 0.01 - 0.006 * np.exp(-(((s - 0.195) / 1e-3) ** 2))], axis=1)
    for radius, place in (({"function": "dented"}, 0.0777), ({"table": table.tolist()}, 0.195)):
        assert np.abs(0.3 * np.array(with_radius(radius).cuts) - place).min() < 4e-3


@pytest.mark.parametrize(
    "text",
    [
        "0.01*(1 - 0.9*exp(-((s - 0.1234567)/1e-8)**2))",
        "0.01 + 0.004*sin(4e6*s)",
        "0.01 - 0.02*exp(-((s - 0.15123)/1e-4)**2)",
    ],
)
def test_what_no_reasonable_rod_shows_is_refused_by_its_key(text):
    with pytest.raises(SceneError) as caught:
        with_radius({"expression": text})
    assert caught.value.key_path == "bodies[0].sections[0].cross_section.radius.expression"


def test_a_narrow_reference_curvature_is_cut():
    fold = {"expression": "500*exp(-((s - 0.2)/0.001)**2)"}
    cuts = section_of(reference={"curvature": [0.0, fold, 0.0]}).cuts
    assert np.abs(0.3 * np.array(cuts) - 0.2).min() < 4e-3


@pytest.mark.parametrize("bend", [0.0, 2.0])
def test_round_off_of_a_centre_line_is_no_feature(bend):
    s = np.linspace(0.0, 0.3, 12)
    turn = bend * s
    side = s if bend == 0.0 else np.sin(turn) / bend
    up = np.zeros(12) if bend == 0.0 else (1.0 - np.cos(turn)) / bend
    points = np.stack([0.8 * side, 0.6 * side, up], axis=1)
    reference = {"centre_line": {"points": points.tolist()}}
    assert section_of(reference=reference).cuts == ()
