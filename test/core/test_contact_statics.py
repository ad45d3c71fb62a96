"""Arms at rest on what they touch, without friction: against own boundary value problems."""

import numpy as np
import pytest
from scenes import scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import root
from touching import G, rod_on_table

from soft_sim_ros.core.analysis.modes import frequencies
from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.mechanics import field, spatial
from soft_sim_ros.core.mechanics.contacts import resultants
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

LENGTH, HEIGHT, RADIUS, YOUNG = 0.4, 0.02, 0.01, 2e6
EI = YOUNG * np.pi / 4 * RADIUS**4
WEIGHT = 1100.0 * np.pi * RADIUS**2 * G


def droop():
    """Return length in the air, force at the base, tip x of an elastica that sinks onto a table.

    Where it touches it is level, at the height of the table, and its moment vanishes.
    """

    def shape(x):
        lift, curvature, force = x

        def law(s, y):
            shear = force + WEIGHT * s
            return [np.cos(y[2]), -np.sin(y[2]), y[3], shear * np.cos(y[2]) / EI]

        start = [0.0, 0.0, 0.0, curvature]
        return solve_ivp(law, (0.0, lift), start, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]

    def ends(x):
        y = shape(x)
        return [y[1] + HEIGHT, y[2], 0.1 * y[3]]

    found = root(ends, [0.25, WEIGHT * 0.25**2 / EI / 6, -0.15 * WEIGHT], tol=1e-13)
    assert found.success
    lift, _, force = found.x
    return lift, -force, shape(found.x)[0] + LENGTH - lift


def test_an_arm_that_droops_onto_a_table_is_the_elastica_with_a_free_boundary():
    lift, force, tip = droop()
    document = rod_on_table(
        length=LENGTH,
        height=HEIGHT,
        strains=["bend_y"],
        elements=20,
        contact={"stiffness": 1e8, "onset": 1e-7, "friction": 0.3},
        initial={"state": "equilibrium"},
    )
    arm = Simulation(scene_of(document))
    contacts = arm.contacts()
    pushed = resultants(contacts)["rod", "table"][5]
    assert arm.tips().poses()[0, 0] == pytest.approx(tip, abs=1e-6 * LENGTH)
    assert WEIGHT * LENGTH - pushed == pytest.approx(force, rel=1e-4)
    assert contacts[0].s == pytest.approx(lift, abs=LENGTH / 40)
    assert not any(contact.friction.any() for contact in contacts)  # rest knows no friction
    # what is stored in the table is part of the energy, and small where it is stiff
    assert 0.0 < -min(contact.gap for contact in contacts) < 1e-5
    # and the motion from there on stays there
    start = arm.q.copy()
    arm.advance(100)
    assert np.abs(arm.q - start).max() < 1e-3 * np.abs(start).max()


def test_what_is_pressed_on_a_table_swings_faster():
    document = rod_on_table(height=HEIGHT, strains=["bend_y"], elements=8,
                            initial={"state": "equilibrium"})  # fmt: skip
    arm = Simulation(scene_of(document))
    bare = dict(document)
    del bare["environment"]
    own, without = Dynamics(arm.compiled), Dynamics(scene_of(bare))
    assert frequencies(own, arm.q, 1)[0] > 1.5 * frequencies(without, arm.q, 1)[0]


@pytest.mark.parametrize("form", ["port_hamiltonian", "spatial", "field"])
def test_forms_without_contact_refuse_environments(form):
    dynamics = Dynamics(scene_of(rod_on_table(elements=1, order=1)))
    zero = np.zeros(dynamics.n)
    with pytest.raises(SceneError) as found:
        if form == "port_hamiltonian":
            PortHamiltonian(dynamics)
        elif form == "spatial":
            spatial.inverse_dynamics(dynamics, zero, zero, zero)
        else:
            field.fields(dynamics, zero, zero, zero)
    assert found.value.key_path == "environment[0].plane"
