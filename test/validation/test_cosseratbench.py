"""The solver that cosseratbench finds: its scores, and what it says it cannot do."""

import ast
from dataclasses import replace

import numpy as np
import pytest
from cosseratbench.experiment import run
from cosseratbench.experiments.twist import growth_rates
from cosseratbench.registry import load_experiment
from cosseratbench.scenario import EndCondition

from soft_sim_ros.integrations.cosseratbench import SoftSimRos


def scored(name, **values):
    return run(load_experiment(name), SoftSimRos(), values=values, n_elements=20)


def test_the_cantilever_bends_as_its_linear_reference_says():
    result = scored("cantilever")
    assert result.outcome == "completed"
    assert result.metrics["tip_deflection_error"] < 1e-3  # what the reference leaves out
    assert result.metrics["settling_residual"] == 0.0


def test_the_catenary_differs_from_its_reference_by_its_bending_alone():
    """The reference is a string: what is left falls with the stiffness that it leaves out."""
    errors = [scored("catenary", youngs_modulus=e).metrics["shape_error"] for e in (1e5, 1e6)]
    assert errors[0] < 1.5e-4
    assert 4e-4 < errors[1] < 6e-4


def test_the_pendulum_is_laid_along_its_centre_line_and_keeps_its_swing():
    experiment = load_experiment("pendulum")
    trajectory = SoftSimRos().run(experiment.scenario, n_elements=20, n_frames=3)
    wanted = experiment.scenario.rods[0].nodes(20)
    assert np.abs(trajectory.positions[0][0] - wanted).max() < 1e-6
    moved = np.abs(trajectory.positions[0][1] - wanted).max()
    assert 0.01 < moved < 0.05


def test_ropes_that_cross_need_contact_and_so_are_unsupported():
    assert load_experiment("crossing").requires - SoftSimRos.capabilities


@pytest.mark.slow
def test_a_twisted_rod_leaves_its_axis_beyond_greenhills_twist_and_not_before():
    """Both ends clamped, one driven about the axis along which it slides."""
    scenario = load_experiment("twist").scenario
    rods = tuple(scenario.rods[k] for k in (1, 3))  # 0.98 and 1.02 of the critical twist
    scenario = replace(scenario, rods=rods)
    trajectory = SoftSimRos().run(scenario, n_elements=20, n_frames=161)
    below, beyond = growth_rates(scenario, trajectory)  # 1/s
    assert below < -0.1
    assert beyond > 0.2
    # the far end slides to where its tension of 10 EI/L² has it, ε = 10 r²/4 L², and nowhere else
    ends = trajectory.positions[0][80:, -1] - rods[0].centerline[-1]
    np.testing.assert_allclose(ends[:, 0], 2.5e-4, atol=5e-6)
    assert np.abs(ends[:, 1:]).max() < 1e-9


@pytest.mark.parametrize("name", ["capstan", "pile"])
def test_what_needs_contact_is_unsupported(name):
    result = scored(name)
    assert result.outcome == "unsupported"
    assert result.missing


def test_directions_are_those_of_the_scenario_at_the_start_and_upright_to_the_pieces():
    experiment = load_experiment("cantilever")
    rod = experiment.scenario.rods[0]
    assert rod.start is EndCondition.CLAMPED
    trajectory = SoftSimRos().run(experiment.scenario, n_elements=8, n_frames=2)
    assert np.allclose(trajectory.directors[0][0], rod.directors(8))
    along = np.diff(trajectory.positions[0][-1], axis=0)
    assert np.abs(np.sum(along * trajectory.directors[0][-1], axis=1)).max() < 1e-12


def test_the_entry_point_names_the_solver():
    root = __import__("pathlib").Path(__file__).resolve().parents[2]
    text = (root / "setup.py").read_text()
    assert '"cosseratbench.solvers"' in text and ast.parse(text)
    assert "integrations.cosseratbench:SoftSimRos" in text
