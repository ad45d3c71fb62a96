"""What must not matter does not: units, cuts, refused steps, slivers of steps, load spelling."""

import numpy as np
import pytest
from scenes import ALL, SOFT, rod_document, scene_of
from scipy.integrate import quad

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import Diverged

E, RADIUS, LENGTH = SOFT["young_modulus"], 0.03, 0.6
INERTIA, AREA = np.pi * RADIUS**4 / 4, np.pi * RADIUS**2

# Two computations of one motion differ by what Newton's method leaves: here, next to nothing.
EXACT = {"newton_tolerance": 1e-13}


def in_units(metre, second, kilogram, integrator):
    """Return a swinging, pushed arm whose numbers are in other units of length, time and mass."""
    pressure, force = kilogram / metre / second**2, kilogram * metre / second**2
    return rod_document(
        length=0.5 * metre,
        radius=0.02 * metre,
        strains=ALL,
        gravity=np.array([1.0, 2.0, -9.0]) * metre / second**2,
        material={
            "young_modulus": 1e6 * pressure,
            "shear_modulus": 4e5 * pressure,
            "density": 1100.0 * kilogram / metre**3,
            "viscosity": 2e3 * pressure * second,
        },
        section={"reference": {"curvature": np.array([1.0, 0.0, 2.0]) / metre}},
        loads=[{"point": "p", "body": "rod", "force": np.array([0.2, 0.5, 0.1]) * force}],
        numerics={
            "step": 0.002 * second, "integrator": integrator, "basis": {"order": 2}, **EXACT,
        },
    )  # fmt: skip


@pytest.mark.parametrize("integrator", ["sdirk2", "generalized_alpha"])
@pytest.mark.parametrize("units", [(1000.0, 1.0, 1e-3), (0.01, 10.0, 50.0), (20.0, 0.01, 1e4)])
def test_the_units_of_length_time_and_mass_do_not_matter(integrator, units):
    metre, second, kilogram = units
    one = Simulation(scene_of(in_units(1.0, 1.0, 1.0, integrator)))
    two = Simulation(scene_of(in_units(metre, second, kilogram, integrator)))
    for simulation in (one, two):
        simulation.advance(80)
    a, b = one.sampler(4).poses().copy(), two.sampler(4).poses().copy()
    np.testing.assert_allclose(b[:, :3] / metre, a[:, :3], atol=1e-7)
    energy = kilogram * metre**2 / second**2
    np.testing.assert_allclose(two.ledger() / energy, one.ledger(), atol=1e-6)


def test_a_rod_cut_into_two_rods_moves_as_before():
    half = {"length": 0.3, "material": "soft", "cross_section": {"shape": "circle", "radius": 0.02}}
    whole = rod_document(strains=ALL[:4], gravity=(0.0, 1.0, -9.8), order=2)
    whole["numerics"] = {"basis": {"order": 2}} | EXACT
    sections = [half | {"name": "a"}, half | {"name": "b"}]
    cut = whole | {
        "bodies": [
            {"rod": f"r{i}", "strains": ALL[:4], "sections": [section]}
            for i, section in enumerate(sections)
        ]
    }
    whole["bodies"] = [{"rod": "r", "strains": ALL[:4], "sections": sections}]
    elements = whole | {
        "bodies": [
            {"rod": "r", "strains": ALL[:4], "sections": [half | {"name": "ab", "length": 0.6}]}
        ],
        "numerics": {"basis": {"order": 2, "elements": 2}} | EXACT,
    }
    tips = []
    for document in (whole, cut, elements):
        simulation = Simulation(scene_of(document))
        simulation.advance(100)
        tips.append(simulation.sampler(5).poses().copy())
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-10)
    np.testing.assert_allclose(tips[2], tips[0], atol=1e-10)


def test_weight_is_a_distributed_dead_load():
    weight = np.array([1.0, -2.0, -7.0])
    heavy = Dynamics(scene_of(rod_document(gravity=weight)))
    load = {"distributed": "w", "body": "rod", "force": 1000.0 * AREA * weight}
    loaded = Dynamics(scene_of(rod_document(loads=[load])))
    np.testing.assert_allclose(equilibrium(heavy), equilibrium(loaded), atol=1e-11)


@pytest.mark.parametrize("frame", ["world", "body"])
def test_a_distributed_moment_about_the_normal_of_a_plane(frame):
    """EI θ' is the moment of all that lies beyond, c (b − max(s, a)) for a load from a to b."""
    couple, begin, end = 4.0, 0.2, 0.5
    load = {"distributed": "c", "body": "rod", "start": begin, "end": end,
            "moment": [0, 0, couple], "frame": frame}  # fmt: skip
    document = rod_document(strains=["bend_z"], loads=[load], order=2)
    dynamics = Dynamics(scene_of(document))
    pose = dynamics.node_poses(equilibrium(dynamics))[-1]

    def angle(s):
        full = couple / (E * INERTIA) * (end - begin)
        if s < begin:
            return full * s
        s = min(s, end)
        bent = couple / (E * INERTIA) * ((s - begin) * end - (s**2 - begin**2) / 2)
        return full * begin + bent

    marks = {"points": [begin, end], "epsabs": 1e-12}
    expected = [quad(lambda s, f=f: f(angle(s)), 0, LENGTH, **marks)[0] for f in (np.cos, np.sin)]
    np.testing.assert_allclose(pose[:2, 3], expected, atol=1e-5)


@pytest.mark.parametrize("integrator", ["sdirk2", "sdirk4", "implicit_midpoint"])
def test_a_load_that_begins_just_before_the_end_of_a_step_leaves_the_motion_continuous(integrator):
    """However short the piece of a step that remains, the motion depends smoothly on the start."""

    def tip(start):
        document = rod_document(
            strains=ALL[:4],
            gravity=(0, 0, -9.81),
            material={"viscosity": 300.0},
            loads=[{"point": "p", "body": "rod", "force": [0, 0.5, 0],
                    "schedule": {"start": start}}],
            numerics={
                "step": 0.01, "integrator": integrator, "basis": {"order": 2}, **EXACT,
            },
        )  # fmt: skip
        simulation = Simulation(scene_of(document))
        simulation.advance(12)
        return simulation.sampler(2).poses()[-1, :3].copy()

    exact = tip(0.05)
    for sliver in (1e-5, 1e-7, 1e-9, 2e-11, 5e-12):
        error = np.linalg.norm(tip(0.05 - sliver) - exact)
        assert error < 1e-3 * LENGTH * sliver / 1e-5 + 1e-7 * LENGTH, sliver


@pytest.mark.parametrize("integrator", ["sdirk2", "sdirk4", "implicit_midpoint"])
def test_a_refused_step_leaves_every_bit_and_the_motion_can_go_on(integrator):
    document = rod_document(
        strains=ALL[:4],
        gravity=(0, 1.0, -9.81),
        material={"viscosity": 300.0},
        numerics={"integrator": integrator, "basis": {"order": 2}},
    )
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    one, two = (Simulation(scene_of(document)) for _ in range(2))
    one.advance(20)
    two.advance(20)
    one.set_efforts([1e12])
    q, v, ledger, time = one.q.copy(), one.v.copy(), one.ledger(), one.time_ns
    with pytest.raises(Diverged):
        one.advance(1)
    assert one.q.tobytes() == q.tobytes() and one.v.tobytes() == v.tobytes()
    assert one.ledger().tobytes() == ledger.tobytes() and one.time_ns == time
    one.set_efforts([0.0])
    one.advance(20)
    two.advance(20)
    np.testing.assert_allclose(one.q * one.model.weight, two.q * two.model.weight, atol=1e-6)
