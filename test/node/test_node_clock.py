"""Deadlines and the account of step costs, with a clock in the hands of the test."""

import numpy as np
import pytest

from soft_sim_ros.node import clock
from soft_sim_ros.node.clock import MAX_LAG_NS, Pacer
from soft_sim_ros.node.timing import StepCosts

MS = 1_000_000


class Time:
    """A clock that only sleeping and the test move."""

    def __init__(self):
        self.ns = 0

    def now(self):
        return self.ns

    def sleep(self, seconds):
        self.ns += max(1, round(seconds * 1e9))


@pytest.fixture
def time(monkeypatch):
    result = Time()
    monkeypatch.setattr(clock.time, "sleep", result.sleep)
    return result


def never():
    return False


def pacer_at(time, factor):
    pacer = Pacer(factor, time.now)
    pacer.wait(0, never)
    return pacer


@pytest.mark.parametrize(("factor", "real"), [(1.0, 100), (2.0, 50), (0.5, 200)])
def test_simulated_time_takes_its_real_time_divided_by_the_factor(time, factor, real):
    pacer = pacer_at(time, factor)
    for t in range(2, 101, 2):
        pacer.wait(t * MS, never)
    assert time.ns == pytest.approx(real * MS, abs=MS / 10)
    assert pacer.overruns == 0


def test_factor_zero_never_waits(time):
    pacer = pacer_at(time, 0.0)
    pacer.wait(10**15, never)
    assert time.ns == 0


def test_a_late_step_is_counted_and_caught_up(time):
    pacer = pacer_at(time, 1.0)
    time.ns = 15 * MS
    pacer.wait(10 * MS, never)
    assert (pacer.overruns, time.ns) == (1, 15 * MS)
    pacer.wait(20 * MS, never)
    assert time.ns == 20 * MS


def test_a_long_stall_is_given_up_and_not_caught_up_by_racing(time):
    pacer = pacer_at(time, 1.0)
    time.ns = 10 * MAX_LAG_NS
    pacer.wait(10 * MS, never)
    assert pacer.lost_ns == 10 * MAX_LAG_NS - 10 * MS
    before = time.ns
    pacer.wait(20 * MS, never)
    assert time.ns - before == pytest.approx(10 * MS, abs=MS / 10)


def test_a_change_of_the_factor_takes_effect_from_now_on(time):
    pacer = pacer_at(time, 1.0)
    pacer.wait(100 * MS, never)
    pacer.factor = 10.0
    pacer.wait(100 * MS, never)
    before = time.ns
    pacer.wait(200 * MS, never)
    assert time.ns - before == pytest.approx(10 * MS, abs=MS / 10)


def test_who_is_in_a_hurry_does_not_wait_for_a_far_deadline(time):
    pacer = pacer_at(time, 1e-6)
    pacer.wait(100 * MS, lambda: True)
    assert time.ns <= 21 * MS


def test_costs_are_per_step_and_every_step_is_counted_once():
    costs = StepCosts()
    costs.add(10, 10 * 5_000, 10 * MS)
    costs.add(1, 900_000, 11 * MS)
    window = costs.look()
    assert window.steps == 11
    assert window.p50 == 5_000
    assert window.worst == 900_000
    assert np.isnan(costs.look().p50)
    summary = costs.summary()
    assert summary["steps"] == 11
    assert summary["mean_us"] == pytest.approx(950.0 / 11)
    assert (summary["worst_us"], summary["worst_at_s"]) == (900.0, 0.011)
    assert sum(bin["steps"] for bin in summary["histogram"]) == 11
    for bin in summary["histogram"]:
        assert bin["from_us"] <= (5.0 if bin["steps"] == 10 else 900.0) < bin["to_us"]
    assert summary["p50_us"] == pytest.approx(5.0, rel=0.3)
