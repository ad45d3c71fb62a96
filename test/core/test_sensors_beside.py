"""Sensors beside what else a scene may have: constraints, a fluid, contact, branches, links."""

import numpy as np
import pytest
from forests import forest_document, rod, section
from scenes import scene_of
from scipy.spatial.transform import Rotation

from soft_sim_ros import Simulation
from soft_sim_ros.errors import SceneError

SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0, "viscosity": 3e3}}
NUMERICS = {"step": 1e-3, "basis": {"order": 2}}
DOWN = np.array([0.0, 0.0, -9.81])
MASS = 1000.0 * np.pi * 0.02**2 * 0.3


def sensed(bodies, *sensors, **rest):
    """A scene with sensors that read at every step."""
    sensors = [{"rate": 1000.0} | one for one in sensors]
    rest = {"materials": SLACK, "numerics": NUMERICS, "gravity": DOWN.tolist()} | rest
    return Simulation(scene_of(forest_document(bodies, sensors=sensors, **rest)))


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_clamp_and_constraint_share_the_weight(integrator):
    simulation = sensed(
        [rod("arm", 0.3)],
        {"wrench": "clamp", "body": "arm"},
        constraints=[{"name": "pin", "kind": "ball", "frames": [{"body": "arm"}]}],
        initial={"state": "equilibrium"},
        numerics=NUMERICS | {"integrator": integrator},
    )
    simulation.set_tip_wrench([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])
    simulation.advance(3)
    reaction = simulation.reactions()["pin"]
    # it hardly moves: what the clamp feels is weight and load less what the pin carries
    outer = MASS * DOWN + [0.0, 0.5, 0.0] + reaction.force
    np.testing.assert_allclose(simulation.sensors()["clamp"]["force"], outer, atol=0.02)
    assert abs(reaction.force[2]) > 0.2 * MASS * 9.81


def test_a_load_cell_under_water_feels_the_weight_less_the_buoyancy():
    simulation = sensed(
        [rod("arm", 0.3)],
        {"wrench": "clamp", "body": "arm"},
        fluid={"density": 900.0},
        initial={"state": "equilibrium"},
    )
    simulation.advance(2)
    force = simulation.sensors()["clamp"]["force"]
    assert force[2] == pytest.approx(0.1 * MASS * -9.81, rel=2e-2)


def test_a_load_cell_at_the_end_of_a_rod_in_a_fluid_asks_for_a_place_of_its_own():
    bodies = [rod("arm", 0.3), {"joint": "wrist", "kind": "fixed"}, rod("hand", 0.1)]
    with pytest.raises(SceneError, match=r"sensors\[0\].body = wrist: .* offset .* the fluid acts"):
        sensed(bodies, {"wrench": "cell", "body": "wrist"}, fluid={"density": 900.0})
    bodies[1]["offset"] = {"position": [1e-3, 0.0, 0.0]}
    simulation = sensed(bodies, {"wrench": "cell", "body": "wrist"}, fluid={"density": 900.0})
    assert np.isfinite(simulation.sensors()["cell"].values).all()


@pytest.mark.parametrize("integrator", ["sdirk2", "implicit_midpoint"])
def test_dashpots_of_maxwell_branches_are_felt(integrator):
    soft = SLACK["soft"] | {"maxwell": {"ratio": 2.0, "time": 0.02}}
    simulation = sensed(
        [rod("arm", 0.3)],
        {"imu": "tip", "body": "arm"},
        materials={"soft": soft},
        numerics=NUMERICS | {"integrator": integrator, "newton_tolerance": 1e-12},
    )
    simulation.advance(60)
    check_tip(simulation, "tip")


def test_an_imu_on_a_flexible_link_reads_the_motion_of_its_tip():
    link = {"flexible_link": "beam", "sections": [section(0.3)], "modes": {"bend_y": 2}}
    simulation = sensed(
        [{"joint": "hip", "kind": "revolute", "axis": [0, 1, 0]}, link],
        {"imu": "tip", "body": "beam"},
        {"imu": "mid", "body": "beam", "s": 0.2},
        numerics={"step": 1e-3, "newton_tolerance": 1e-12},
    )
    simulation.advance(60)
    check_tip(simulation, "tip")
    assert np.isfinite(simulation.sensors()["mid"].values).all()


def test_a_load_cell_feels_what_a_part_beyond_it_touches():
    """A ball that lies on a floor: the floor carries it, the cell above it nothing of it."""
    bodies = [
        {"joint": "slide", "kind": "prismatic", "axis": [0, 0, 1], "damping": 20.0},
        {"joint": "cell", "kind": "fixed", "offset": {"position": [0, 0, -0.1]}},
        {"rigid_body": "ball", "mass": 0.2, "inertia": [1e-5, 1e-5, 1e-5],
         "shape": {"kind": "sphere", "radius": 0.02}},
    ]  # fmt: skip
    simulation = sensed(
        bodies,
        {"wrench": "cell", "body": "cell"},
        environment=[{"plane": "floor", "position": [0.0, 0.0, -0.12]}],
        contact={"stiffness": 1e6, "friction": 0.3, "onset": 1e-5, "dissipation": 1.0},
    )
    simulation.advance(400)
    push = sum(one.normal_force for one in simulation.contacts())
    assert push == pytest.approx(0.2 * 9.81, rel=1e-3)
    force = simulation.sensors()["cell"]["force"]
    np.testing.assert_allclose(force, 0.2 * DOWN + [0.0, 0.0, push], atol=1e-3)


def check_tip(simulation, name):
    """Compare a reading at the tip with difference quotients of its path."""
    frames, path, read, h = simulation.tips(), [], [], 1e-3
    for _ in range(3):
        path.append(frames.poses()[-1].copy())
        read.append(simulation.sensors()[name])
        simulation.advance(1)
    a = (path[2][:3] - 2.0 * path[1][:3] + path[0][:3]) / h**2
    force = Rotation.from_quat(path[1][3:]).inv().apply(a - DOWN)
    assert np.linalg.norm(a) > 1.0
    np.testing.assert_allclose(read[1]["acceleration"], force, atol=0.03 * np.linalg.norm(a))
