"""The examples of docs/control.md run, and do on the nonlinear arm what the page says of them."""

import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ("pd_gravity", "computed_torque", "lqr", "track_tip", "mpc")


@pytest.fixture
def example():
    """Return the names that an example defines."""

    def load(name):
        return runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="example")

    return load


def rms(path, wanted):
    return np.sqrt(np.mean(np.sum((path - wanted) ** 2, axis=-1)))


def test_the_page_shows_every_example_with_its_figure():
    page = (ROOT / "docs" / "control.md").read_text()
    for name in EXAMPLES:
        assert f"(../examples/{name}.py)" in page
        assert f"(control/{name}.png)" in page


def test_a_pd_loop_holds_the_goal_better_under_an_unknown_payload(example):
    run = example("pd_gravity")["run"]
    (_, alone), (_, held) = run(False), run(True)
    assert held[-1] < 0.7 * alone[-1]
    assert np.ptp(held[-200:]) < 0.02 * held[-1], "at rest"


def test_inverse_dynamics_of_a_simpler_model_carries_the_arm(example):
    run = example("computed_torque")["run"]
    (_, pd, wanted), (_, carried, _) = run(False), run(True)
    assert rms(carried, wanted) < 0.05 * rms(pd, wanted)


def test_the_wanted_motion_has_the_rates_it_gives(example):
    reference = example("computed_torque")["reference"]
    h = 1e-4
    for time in (0.2, 0.6, 1.7):
        before, now, after = (reference(time + k * h) for k in (-1, 0, 1))
        np.testing.assert_allclose((after[0] - before[0]) / (2 * h), now[1], atol=1e-6)
        np.testing.assert_allclose((after[1] - before[1]) / (2 * h), now[2], atol=1e-5)


def test_the_regulator_damps_the_nonlinear_arm(example):
    run = example("lqr")["run"]
    (_, free), (_, regulated) = run(False), run(True)
    np.testing.assert_allclose(free[0], regulated[0], atol=0.02)
    assert np.sum(regulated**2) < 0.3 * np.sum(free**2)
    assert np.abs(regulated[-1]).max() < 1e-3


@pytest.mark.slow
def test_feedback_on_the_angles_takes_most_of_the_lag_away(example):
    run = example("track_tip")["run"]
    assert rms(*run(True)) < 0.5 * rms(*run(False))


def test_the_predictive_controller_is_fast_and_keeps_its_bounds(example):
    names = example("mpc")
    goal = names["GOAL"][:2]
    late = {}
    for predictive in (False, True):
        times, moved, torques = names["run"](predictive)
        away = np.linalg.norm(moved - goal, axis=1)
        late[predictive] = times[np.flatnonzero(away > 0.1 * np.linalg.norm(goal))[-1]]
        limits = names["BOUND"] * np.array([4.0, 4.0, 2.0, 2.0])
        assert (np.abs(torques) <= limits + 1e-9).all()
    assert late[True] < 0.5 * late[False]
    assert np.isclose(np.abs(torques), limits).any(), "a bound is reached"
