"""Kernels are compiled once for a method and a space: other numbers or bodies compile no more."""

import pytest
from numba.core import event
from scenes import rod_document, scene_of, zoo_document

from soft_sim_ros.core.simulation import Simulation
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
    watcher = Compilations()
    with event.install_listener("numba:compile", watcher):
        document = document | {"numerics": document["numerics"] | {"integrator": integrator}}
        moved(document)
    assert watcher.names == []
