"""A tolerance is met, and known to be met: by motion, against finer runs and other formulations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from scenes import SOFT, rod_document, scene_of

from soft_sim_ros.core.accuracy.contract import choose, settle
from soft_sim_ros.core.accuracy.drive import Drive, probe
from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import Diverged, SceneError, ToleranceMissed
from soft_sim_ros.scene import Free, load_scene, parse_scene

BEND = {"moment": "bend", "rod": "rod", "section": "s", "strain": "bend_y"}
TWIST = {"moment": "twist", "rod": "rod", "section": "s", "strain": "torsion"}


def arm(tolerance: float | None, numerics: dict | None = None, **options):
    """Return a soft arm with two moments, damped as silicone is."""
    document = rod_document(
        material={"viscosity": 5e3}, gravity=(0.0, 0.0, -9.81), actuators=[BEND, TWIST], **options
    )
    free = {} if tolerance is None else {"tolerance": tolerance}
    return scene_of(document | {"numerics": {"step": 0.01} | free | (numerics or {})})


def shaken(last: int = 60) -> Drive:
    """Return steps of both moments."""
    rows = np.array([[1.0, 0.5], [-0.7, 0.2], [0.2, -0.6]])
    return Drive(np.arange(3) * last // 3, rows, last, 2)


def exact_tips(drive: Drive) -> np.ndarray:
    """Return the tips of a run that is far finer than any choice, in another basis and method."""
    basis = {"kind": "chebyshev", "order": 8, "elements": 2, "nodes": 30}
    numerics = {"basis": basis, "integrator": "sdirk4", "step": 5e-4, "newton_tolerance": 1e-12}
    finer = Drive(drive.steps * 20, drive.efforts, drive.last * 20, drive.every * 20)
    return finer.tip(Simulation(arm(None, numerics)))


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    return exact_tips(shaken())


@pytest.mark.parametrize("tolerance", [3e-2, 1e-3, 1e-4])
def test_the_tip_is_within_the_tolerance_and_the_estimate_is_near_the_error(tolerance, exact):
    choice = choose(arm(tolerance), shaken())
    simulation = Simulation(choice.scene)
    tips = shaken().tip(simulation)
    error = np.linalg.norm(tips - exact, axis=1).max() / simulation.length
    assert error <= tolerance
    assert 0.9 * error <= choice.estimate <= min(tolerance, 5.0 * error)


def test_a_settled_arm_is_where_statics_by_another_formulation_has_it():
    # PDE limit: scipy's collocation for the boundary-value problem of the continuous rod
    document = rod_document(
        gravity=(0.0, -9.81, 0.0),
        material={"viscosity": 3e4},
        section={"shear_correction": 1.0},
        strains=["bend_z", "stretch", "shear_y"],
    )
    document["numerics"] = {"step": 0.05, "tolerance": 1e-5}
    drive = Drive(np.zeros(0, dtype=np.int64), np.zeros((0, 0)), 400, 10)
    simulation = Simulation(choose(scene_of(document), drive).scene)
    tip = drive.tip(simulation)[-1]
    area, inertia = np.pi * 0.03**2, 0.25 * np.pi * 0.03**4
    shear = SOFT["shear_modulus"]
    stiffness = [2.0 * shear * inertia, *2 * [1e6 * inertia], 1e6 * area, *2 * [shear * area]]
    straight = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    weight = (0.0, -9.81 * 1000.0 * area, 0.0)
    exact, _ = solve_rod(0.6, np.array(stiffness), lambda s: straight, density_force=weight)
    assert np.linalg.norm(tip - exact) < 1e-5 * simulation.length


def test_a_smaller_tolerance_costs_more_and_is_met_with_more():
    counts = [len(Simulation(choose(arm(t), shaken()).scene).q) for t in (1e-1, 1e-3, 1e-5)]
    assert counts == sorted(counts) and counts[0] < counts[2]


def test_the_same_scene_gives_the_same_choice_and_the_same_bits():
    runs = [choose(arm(1e-3), shaken()) for _ in range(2)]
    assert runs[0].scene.numerics == runs[1].scene.numerics
    first, second = (shaken().tip(Simulation(run.scene)) for run in runs)
    assert np.array_equal(first, second)


def test_the_chosen_scene_says_in_its_text_what_was_chosen():
    scene = choose(arm(1e-3), shaken()).scene
    assert not scene.numerics.free
    again = parse_scene(scene.source, scene.file)
    assert again.numerics == scene.numerics
    assert settle(again) is again
    same = (shaken().tip(Simulation(s)) for s in (scene, again))
    assert np.array_equal(*same)


def test_what_is_written_down_stays():
    basis = {"order": {"torsion": 2, "bend_y": 7, "bend_z": 4}, "nodes": 14}
    scene = choose(arm(1e-3, {"basis": basis}), shaken()).scene
    chosen = scene.numerics.rods["rod"]
    assert (chosen.order["bend_y"], chosen.order["bend_z"], chosen.nodes) == (7, 4, 14)
    assert scene.numerics.integrator == "adaptive"
    fixed = arm(1e-2, {"integrator": "sdirk4", "basis": basis | {"elements": 1}})
    assert not fixed.numerics.free
    assert choose(fixed, shaken()).rounds == 0


def test_fixed_elements_of_a_linear_basis_are_the_only_thing_refined():
    scene = choose(arm(3e-3, {"basis": {"kind": "linear"}}), shaken()).scene
    assert scene.numerics.rods["rod"].kind == "linear"
    assert scene.numerics.rods["rod"].elements > 2


def test_what_the_scene_fixes_too_coarsely_is_refused_with_its_numbers():
    coarse = arm(1e-5, {"basis": {"order": 1, "elements": 1}})
    with pytest.raises(ToleranceMissed) as caught:
        choose(coarse, shaken())
    assert caught.value.estimate > caught.value.tolerance == 1e-5
    assert "numerics.tolerance = 1e-05 is not met" in str(caught.value)
    assert "bend_y 1" in str(caught.value)


def test_without_known_commands_a_probe_decides():
    scene = arm(1e-2)
    assert scene.numerics.free
    simulation = Simulation(scene)
    assert not simulation.scene.numerics.free
    drive = probe(simulation)
    assert drive.efforts.any(axis=0).all()
    reference = Simulation(choose(arm(1e-4), drive).scene)
    error = np.linalg.norm(drive.tip(simulation) - drive.tip(reference), axis=1).max()
    assert error < 1e-2 * simulation.length


def test_a_probe_stays_within_the_limits():
    simulation = Simulation(load_scene("soft_arm"))
    limits = np.array([actuator.limits for actuator in simulation.scene.actuators])
    efforts = probe(simulation).efforts
    assert (efforts >= limits[:, 0]).all() and (efforts <= limits[:, 1]).all()
    assert np.ptp(efforts, axis=0).min() > 0.3 * np.ptp(limits, axis=1).min()


@pytest.mark.parametrize("value", ["0", "1e-9", "0.2", "-1e-3", ".nan", "fine", "[1e-3]"])
def test_a_tolerance_that_means_nothing_is_refused(value):
    text = f"""
materials: {{m: {{young_modulus: 1e6, poisson_ratio: 0.5, density: 1000.0}}}}
bodies:
  - rod: r
    sections:
      - {{name: s, length: 0.5, material: m, cross_section: {{shape: circle, radius: 0.01}}}}
numerics: {{tolerance: {value}}}
"""
    with pytest.raises(SceneError, match=r"numerics.tolerance"):
        parse_scene(text, "scene.yaml")


def watched(numerics: dict, tolerance: float) -> tuple[WatchedInputs, list[str]]:
    """Return a watched arm of fixed numerics, and what it complains of."""
    said: list[str] = []
    scene = arm(tolerance, numerics)
    simulation = Simulation(replace(scene, numerics=replace(scene.numerics, free=Free())))
    return WatchedInputs(simulation, 0.3, 0.1, said.append), said


COARSE = {"integrator": "sdirk2", "basis": {"order": 2, "elements": 1, "nodes": 7}}


def test_a_watched_run_knows_its_error_while_it_runs():
    inputs, said = watched(COARSE, 1e-5)
    basis = {"order": 8, "elements": 2, "nodes": 30}
    exact = Inputs(Simulation(arm(None, {"basis": basis, "step": 1e-3})), 0.3, 0.1)
    tips = [one.simulation.sampler(2) for one in (inputs, exact)]
    apart = 0.0
    for k in range(60):  # a command that times out, and a wrench at the tip
        for one, steps in ((inputs, 1), (exact, 10)):
            if k == 0:
                one.command([1.0, 0.3])
            if k == 30:
                one.wrench([0.0, 0.0, 0.0, 0.0, 0.2, 0.1])
            one.advance(steps)
        apart = max(apart, np.linalg.norm(tips[0].poses()[-1, :3] - tips[1].poses()[-1, :3]))
    error = apart / inputs.simulation.length
    assert 0.8 * error < inputs.error_rel < 3.0 * error
    assert len(said) == 1 and "more than the tolerance 1e-05" in said[0]
    inputs.reset()
    assert inputs.error_rel == 0.0
    assert inputs.companion.time == inputs.simulation.time
    assert np.array_equal(inputs.simulation.v, 0.0 * inputs.simulation.v)


def test_a_companion_that_gives_up_ends_the_estimate_not_the_run(monkeypatch):
    inputs, said = watched(COARSE, 1e-2)

    def broken(steps):
        raise Diverged(0.0, "broken")

    monkeypatch.setattr(inputs.companion, "advance", broken)
    inputs.advance(3)
    assert inputs.error_rel == np.inf and inputs.simulation.step_index == 3
    assert len(said) == 1
    inputs.advance(3)
    assert inputs.simulation.step_index == 6 and len(said) == 1


def test_everything_that_is_compiled_from_a_scene_uses_the_choice():
    scene = load_scene("precise_arm")
    simulation = Simulation(scene)
    dynamics = Dynamics(scene)
    assert dynamics.compiled.scene.numerics == simulation.scene.numerics
    assert dynamics.n == simulation.n_coordinates
