"""The guard finds what got slower, and only that; what it stores fits what it measures."""

import json

from benchmarks import guard


def test_only_what_is_beyond_the_bound_is_found():
    before = {"a": {"time": 1.0, "evaluations": 8.0}, "b": {"time": 2.0}}
    assert guard.worse({"a": {"time": 1.4, "evaluations": 8.0}, "b": {"time": 1.0}}, before) == {}
    slower = {"a": {"time": 1.0, "evaluations": 16.0}, "b": {"time": 4.0}}
    assert guard.worse(slower, before) == {"a": {"evaluations": 2.0}, "b": {"time": 2.0}}


def test_work_made_twice_is_found():
    simulation = guard.Simulation(guard.load_scene("cantilever"))
    once, twice = guard.stepping(simulation, 50), guard.stepping(simulation, 100)
    double = guard.Work(twice.run, lambda: {k: 2 * v for k, v in once.count().items()})
    before, now = (guard.measured({"a": work}, rounds=5) for work in (once, double))
    assert set(guard.worse(now, before)["a"]) >= {"evaluations"}
    assert guard.measured({"a": once}, 1)["a"]["evaluations"] == before["a"]["evaluations"]


def test_every_guarded_work_has_a_baseline():
    stored = json.loads(guard.FILE.read_text())["works"]
    assert set(stored) == set(guard.works())
    assert all(values["time"] > 0.0 for values in stored.values())
