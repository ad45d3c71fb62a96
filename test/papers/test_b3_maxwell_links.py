"""B-3 with C-4: a floating-frame link whose material relaxes, against closed forms."""

import numpy as np
import pytest
from scenes import scene_of
from scipy.integrate import trapezoid
from scipy.linalg import expm

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError

RATIO, TIME = 0.8, 0.05


def cantilever(step=0.002, **more):
    """One bending mode and a branch; a force at the tip while its schedule lasts."""
    material = {"young_modulus": 2e9, "poisson_ratio": 0.3, "density": 1000.0,
                "maxwell": {"ratio": RATIO, "time": TIME}}  # fmt: skip
    return {
        "name": "relaxing", "gravity": [0, 0, 0], "materials": {"m": material},
        "bodies": [{"flexible_link": "link", "strains": ["bend_z"], "modes": 1, "sections": [
            {"name": "s", "length": 1.0, "material": "m",
             "cross_section": {"shape": "circle", "radius": 0.01}}]}],
        "numerics": {"step": step, "integrator": "sdirk4", "newton_tolerance": 1e-12},
    } | more  # fmt: skip


def parts(simulation):
    """Mass and stiffness of the one mode, by Rayleigh's quotient of the shapes themselves."""
    (own,) = simulation.compiled.chain.links.values()
    s = np.linspace(0.0, 1.0, 4001)
    shape = own.modes.fields(s)[1][:, 1, 0]
    area, second = np.pi * 0.01**2, np.pi * 0.01**4 / 4
    bent = np.gradient(np.gradient(shape, s, edge_order=2), s, edge_order=2)
    return 1000.0 * area * trapezoid(shape**2, s), 2e9 * second * trapezoid(bent**2, s)


def test_a_plucked_link_rings_as_the_standard_linear_solid():
    """m q″ + K q + r K (q − d) = 0, τ d′ = q − d, by the exponential of its matrix."""
    simulation = Simulation(scene_of(cantilever(initial={"positions": {"link": [0.01]}})))
    mass, stiffness = parts(simulation)
    rest = np.array([[0, 1, 0], [-(1 + RATIO) * stiffness / mass, 0, RATIO * stiffness / mass],
                     [1 / TIME, 0, -1 / TIME]])  # fmt: skip
    state = np.array([0.01, 0.0, 0.01])  # held for so long that the branch has relaxed
    sizes = []
    for _ in range(20):
        simulation.advance(10)
        state = expm(rest * 0.02) @ state
        sizes.append(abs(state[0]))
        assert simulation.q[0] == pytest.approx(state[0], abs=2e-7)
    assert min(sizes[-5:]) < 0.5 * max(sizes[:5])


def test_a_loaded_link_creeps():
    """J(t) = (1 − r/(1 + r) e^(−t/τ(1 + r)))/K once the ringing is damped away by the branch."""
    load = {"point": "p", "body": "link", "force": [0.0, 0.2, 0.0]}
    simulation = Simulation(scene_of(cantilever(loads=[load])))
    _, stiffness = parts(simulation)
    simulation.advance(1500)
    assert simulation.q[0] == pytest.approx(0.2 / stiffness, rel=1e-5)


def test_two_branches_in_one_link_are_refused():
    scene = cantilever()
    scene["materials"]["other"] = scene["materials"]["m"] | {"maxwell": {"ratio": 1.0, "time": 1.0}}
    (link,) = scene["bodies"]
    link["sections"].append(link["sections"][0] | {"name": "t", "material": "other"})
    with pytest.raises(SceneError, match="one Maxwell branch for all sections"):
        scene_of(scene)
