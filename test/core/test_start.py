"""Kernels are compiled once for a method and a space: other numbers or bodies compile no more."""

import pytest
from numba.core import event
from scenes import rod_document, scene_of, zoo_document

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene.numerics import INTEGRATORS


class Compilations(event.Listener):
    def __init__(self):
        self.names = []

    def on_start(self, event):
        self.names.append(event.data["dispatcher"].py_func.__name__)

    def on_end(self, event):
        pass


def moved(document):
    simulation = Simulation(scene_of(document))
    simulation.advance(2)
    simulation.sampler(5).poses()
    simulation.ledger()


@pytest.fixture(scope="module", autouse=True)
def warm():
    """Compile or load what every method needs, in space and in a plane."""
    actuators = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"}]
    for integrator in INTEGRATORS:
        for strains in (None, ["bend_y", "stretch", "shear_z"]):
            numerics = {"integrator": integrator}
            moved(rod_document(order=2, strains=strains, actuators=actuators, numerics=numerics))


@pytest.mark.parametrize(
    "document",
    [
        rod_document(order=3, length=0.9, material={"young_modulus": 9e5, "viscosity": 50.0}),
        rod_document(order=1, elements=7, strains=["bend_y", "stretch"], gravity=(0, 0, -9.81)),
        zoo_document(),
    ],
    ids=["numbers", "strains and elements", "joints, bodies, loads, tendons"],
)
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_nothing_is_compiled_for_another_scene(document, integrator):
    assert compilations(document, integrator=integrator) == []


@pytest.mark.parametrize(
    "numerics",
    [
        {"integrator": "generalized_alpha", "options": {"rho": 0.9}},
        {"integrator": "generalized_alpha", "options": {"rho": 1}},
        {"integrator": "adaptive", "options": {"error": 1e-4}},
        {"integrator": "adaptive", "step": 0.01},
        {"newton_tolerance": 1e-3},
        {"newton_tolerance": 1e-11, "max_iterations": 50},
        {"integrator": "sdirk4", "max_iterations": 3, "step": 1e-6},
    ],
    ids=str,
)
def test_nothing_is_compiled_for_other_numbers_in_the_numerics(numerics):
    assert compilations(rod_document(order=2), **numerics) == []


@pytest.mark.parametrize(
    "rest",
    [
        {"gravity": [0, 0, 0]},
        {"gravity": [1, 2, -9]},
        {"gravity": [0.0, 0.0, -9.81], "base": {"position": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}},
        {"actuators": [], "loads": []},
        {"initial": {"strains": {"rod/s": {"bend_y": 1}}}, "gravity": [0, 0, -1]},
        {"loads": [{"point": "p", "body": "rod", "force": [0, 0, 1], "schedule": {"end": 1}}]},
    ],
    ids=str,
)
def test_nothing_is_compiled_for_gravity_loads_and_actuators(rest):
    assert compilations(rod_document(order=2) | rest) == []


def test_nothing_is_compiled_for_inputs():
    simulation = Simulation(scene_of(zoo_document()))
    watcher = Compilations()
    with event.install_listener("numba:compile", watcher):
        simulation.set_tip_wrench([0, 0, 0, 0, 0, 1])
        simulation.advance(1)
        simulation.set_tip_wrench([0.0, 0.1, 0.0, 0.0, 0.0, 0.0], "tip")
        simulation.set_efforts([0, 1, 0, 1])
        simulation.advance(1)
        simulation.ports()
        simulation.reset()
    assert watcher.names == []


def compilations(document, **numerics):
    """Return what is compiled to simulate a scene with other numerics."""
    watcher = Compilations()
    with event.install_listener("numba:compile", watcher):
        moved(document | {"numerics": document["numerics"] | numerics})
    return watcher.names
