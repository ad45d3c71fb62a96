"""Errors keep their numbers, print them, and survive a trip between processes."""

import pickle

import pytest

from soft_sim_ros import errors

ERRORS = [
    (
        errors.SceneError("arm.yaml", "gravity", "[0]", "a list of 3 numbers", 4),
        "arm.yaml:4: gravity = [0]: expected a list of 3 numbers",
    ),
    (
        errors.SceneError("arm.yaml", "bodies", None, "a list"),
        "arm.yaml: bodies is missing: expected a list",
    ),
    (errors.Diverged(1.25, "energy grew"), "at t = 1.25 s: energy grew"),
    (
        errors.NewtonFailed(0.5, 20, 1e-3, 1e-9),
        "at t = 0.5 s: Newton's method reached 0.001 after 20 iterations, tolerance 1e-09",
    ),
    (
        errors.StaticsFailed(0.75, 0.1),
        "at t = 0 s: no equilibrium found beyond 0.75 of the load "
        "(residual 0.1 of the last attempt)",
    ),
    (errors.RecordingError("runs/1", "no metadata.yaml"), "runs/1: no metadata.yaml"),
    (errors.TornRecording("runs/1", "no footer"), "runs/1: no footer"),
    (errors.NoSuchPlace("leg", "one of the rods arm"), "'leg': expected one of the rods arm"),
    (errors.CommandError("~/command", "5 efforts, not 6"), "~/command: 5 efforts, not 6"),
]


@pytest.mark.parametrize(("error", "text"), ERRORS, ids=[type(e).__name__ for e, _ in ERRORS])
def test_error_prints_its_numbers_and_pickles(error, text):
    copy = pickle.loads(pickle.dumps(error))
    assert str(error) == str(copy) == text
    assert type(copy) is type(error) and vars(copy) == vars(error)
    assert isinstance(error, errors.SoftSimError)


def test_families_can_be_caught_together():
    assert issubclass(errors.TornRecording, errors.RecordingError)
    solver = (errors.Diverged, errors.NewtonFailed, errors.StaticsFailed)
    assert all(issubclass(kind, errors.SolverError) for kind in solver)
