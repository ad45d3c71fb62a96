"""Coulomb friction with true stick: inclines, rolling, rods that slide at an angle."""

import numpy as np
import pytest
from scenes import scene_of
from touching import G, body, rod_on_table

from soft_sim_ros.core.settled import Simulation

FIRM = {"stiffness": 1e7, "dissipation": 1.0}
BOX = {"kind": "box", "size": [0.2, 0.2, 0.1]}


def acceleration(simulation, column, settle=2000, steps=500):
    simulation.advance(settle)
    before = simulation.v[column]
    simulation.advance(steps)
    return (simulation.v[column] - before) / (steps * simulation.scene.numerics.step)


def slide(tilt, mu):
    return G * (np.sin(tilt) - mu * np.cos(tilt))


@pytest.mark.parametrize(("tilt", "mu"), [(0.2, 0.5), (0.2, 0.06), (0.5, 0.1)])
def test_a_ball_rolls_down_while_friction_can_turn_it(tilt, mu):
    """5/7 g sin θ up to tan θ = 3.5 μ, beyond g (sin θ − μ cos θ)."""
    found = acceleration(body(tilt=tilt, contact=FIRM | {"friction": mu}), 3)
    rolls = np.tan(tilt) <= 3.5 * mu
    exact = 5 / 7 * G * np.sin(tilt) if rolls else slide(tilt, mu)
    assert found == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize(("tilt", "mu"), [(0.2, 0.5), (0.3, 0.11), (0.5, 0.15)])
def test_a_cylinder_rolls_down_while_friction_can_turn_it(tilt, mu):
    """2/3 g sin θ up to tan θ = 3 μ."""
    around = 0.5 * 0.5 * 0.05**2
    log = {"kind": "capsule", "radius": 0.05, "from": [0, -0.1, 0], "to": [0, 0.1, 0]}
    thing = body(shape=log, inertia=[3e-3, around, 3e-3], tilt=tilt,
                 contact=FIRM | {"friction": mu})  # fmt: skip
    found = acceleration(thing, 3)
    rolls = np.tan(tilt) <= 3.0 * mu
    exact = 2 / 3 * G * np.sin(tilt) if rolls else slide(tilt, mu)
    assert found == pytest.approx(exact, rel=1e-4)


def test_what_sticks_on_an_incline_does_not_creep():
    thing = body(shape=BOX, inertia=[2e-3, 2e-3, 3e-3], tilt=0.3, contact=FIRM | {"friction": 0.5})
    thing.advance(2000)
    before = thing.q.copy()
    thing.advance(60_000)
    assert np.abs(thing.q - before).max() < 1e-9
    assert all(contact.sticks for contact in thing.contacts())
    pull = sum(contact.friction for contact in thing.contacts())
    assert pull[0] == pytest.approx(-0.5 * G * np.sin(0.3), rel=1e-6)


def test_what_slides_down_an_incline_is_slowed_by_friction():
    thing = body(shape=BOX, inertia=[2e-3, 2e-3, 3e-3], tilt=0.6, contact=FIRM | {"friction": 0.5})
    assert acceleration(thing, 3) == pytest.approx(slide(0.6, 0.5), rel=1e-4)
    assert not any(contact.sticks for contact in thing.contacts())


def test_sticking_holds_more_than_sliding():
    """Between both angles of friction: at rest it stays, pushed it goes on."""
    options = {
        "shape": {"kind": "box", "size": [0.2, 0.2, 0.02]},
        "inertia": [2e-3, 2e-3, 3e-3],
        "tilt": 0.35,
        "contact": FIRM | {"friction": {"static": 0.5, "kinetic": 0.3}},
    }
    # as deep as four corners carry it: c φ²/2δ with c = k V^⅓/4, δ = 1 % of their radius
    each, stiff = 0.5 * G * np.cos(0.35) / 4, 1e7 * (0.2 * 0.2 * 0.02) ** (1 / 3) / 4
    depth = np.sqrt(2 * 0.01 * 0.001 * each / stiff)
    rests = body(**options, at=[0, 0, 0, 0, 0, 0.01 - depth])
    rests.advance(3000)
    assert np.abs(rests.v).max() < 1e-6 and np.abs(rests.q).max() < 0.0101
    moves = body(**options, at=[0, 0, 0, 0, 0, 0.01 - depth], speed=[0, 0, 0, 0.3, 0, 0])
    assert acceleration(moves, 3) == pytest.approx(slide(0.35, 0.3), rel=1e-4)


def test_a_rod_on_an_incline_does_not_creep():
    document = rod_on_table(free=True, length=0.2, elements=2, strains=["bend_y", "bend_z"])
    document["gravity"] = [G * np.sin(0.2), 0.0, -G * np.cos(0.2)]
    document["contact"] = {"friction": 0.4}
    rod = Simulation(scene_of(document))
    rod.advance(5000)
    before = rod.tips().poses()[0].copy()
    rod.advance(60_000)
    assert np.abs(rod.tips().poses()[0] - before)[:3].max() < 1e-9


@pytest.mark.parametrize(("along", "across"), [(0.1, 0.4), (0.4, 0.1)])
def test_a_segment_that_slides_obliquely_is_turned_aside_by_the_ratio(along, across):
    """Across a rod that slides at an angle it is pushed along it, one way or the other.

    The law is that of largest dissipation: f = −F (μ₁² w₁, μ₂² w₂) / |(μ₁ w₁, μ₂ w₂)|.
    """
    document = rod_on_table(free=True, length=0.2, elements=1, order=0,
                            strains=["bend_y", "bend_z"], young=1e9)  # fmt: skip
    document["bodies"][1]["contact"] = {"friction": {"kinetic": along, "across": across}}
    document["contact"] = {"stiffness": 1e6}
    document["initial"] = {"velocities": {"fly": [0, 0, 0, 0.7, 0.7, 0]}}
    rod = Simulation(scene_of(document))
    rod.advance(20)
    mu, total, normal, slip = np.array([along, across]), np.zeros(2), 0.0, np.zeros(2)
    for contact in rod.contacts():
        w, pull = contact.slip[:2], contact.friction[:2]
        law = -contact.normal_force * mu**2 * w / np.linalg.norm(mu * w)
        assert np.allclose(pull, law, rtol=0.02, atol=0.01 * contact.normal_force)
        total, slip, normal = total + pull, slip + w, normal + contact.normal_force
    mass = 1100.0 * np.pi * 0.01**2 * 0.2
    before = rod.v[3:5].copy()
    rod.advance(1)
    later = sum(contact.friction[:2] for contact in rod.contacts())
    push = mass * (rod.v[3:5] - before) / 1e-3
    assert np.allclose(push, 0.5 * (total + later), rtol=0.1, atol=0.05 * normal)
    # what slides is turned towards the axis of less friction
    assert np.sign(total[0] * slip[1] - total[1] * slip[0]) == np.sign(across - along)


def test_a_rope_half_around_a_post_pulls_as_the_capstan_says():
    """e^{μπ}; the friction acts at the post, R, and the tension at R + r: e^{μπR/(R + r)}."""
    mu, post, thick, weight = 0.3, 0.05, 3e-4, 0.2
    bent = {"curvature": [0.0, 1.0 / (post + thick), 0.0]}
    sections = [
        {"name": name, "length": length, "material": "soft", "reference": reference,
         "cross_section": {"shape": "circle", "radius": thick}}
        for name, length, reference in (
            ("up", 0.05, {}), ("around", np.pi * (post + thick), bent), ("down", 0.05, {}),
        )
    ]  # fmt: skip
    document = {
        "name": "capstan",
        "gravity": [0.0, 0.0, -G],
        "base": {"position": [-post - thick, 0.0, -0.05], "rpy": [0.0, -np.pi / 2, 0.0]},
        "materials": {"soft": {"young_modulus": 3e8, "poisson_ratio": 0.45, "density": 10.0,
                               "rayleigh": {"stiffness": 0.02}}},
        "bodies": [
            {"joint": "pull", "kind": "prismatic", "axis": [1.0, 0.0, 0.0],
             "driven": "-0.01*t*tanh(20*t)"},
            {"rod": "rope", "strains": ["bend_y", "stretch"], "sections": sections},
            {"rigid_body": "weight", "mass": weight},
        ],
        "environment": [{"cylinder": "post", "from": [0, -0.05, 0], "to": [0, 0.05, 0],
                         "radius": post}],
        "contact": {"stiffness": 1e6, "friction": mu, "onset": 1e-5},
        "numerics": {"step": 1e-3, "basis": {"order": 2, "elements": 12}},
    }  # fmt: skip
    rope = Simulation(scene_of(document))
    rope.advance(1250)
    contacts = rope.contacts()
    assert len(contacts) > 50 and not any(contact.sticks for contact in contacts)
    (pull,) = rope.dynamics.drive_forces(rope.q, rope.v, time=rope.time)
    assert -pull / (weight * G) == pytest.approx(np.exp(mu * np.pi), rel=1e-2)
    exact = np.exp(mu * np.pi * post / (post + thick))
    assert -pull / (weight * G) == pytest.approx(exact, rel=2e-3)
