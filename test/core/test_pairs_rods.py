"""Rods that touch rods: against elasticas with a point force, whatever the mesh; self-contact."""

import numpy as np
import pytest
from meeting import LAW, free, rod, scene, solid
from scenes import scene_of
from scipy.integrate import quad, solve_bvp
from scipy.optimize import brentq

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.contacts import ContactReader, resultants
from soft_sim_ros.core.settled import Dynamics, Simulation

G, R, LENGTHS, CLEAR = 9.81, 0.01, (0.4, 0.6), 1e-4
YOUNG, STIFFNESS, ONSET = 2e7, 1e6, 1e-4
R2 = 0.02


def crossing(elements):
    """Two ropes held at both ends; the longer one lies across the other, both sag."""
    strains = ["torsion", "bend_y", "bend_z", "stretch"]
    pose = {"position": [0.2, -0.3, 2 * R + CLEAR], "rpy": [0, 0, np.pi / 2]}
    bodies = [
        rod("a", R, LENGTHS[0], strains=strains),
        rod("b", R, LENGTHS[1], strains=strains, parent={"body": "base", "offset": pose}),
    ]
    law = {"friction": 0.0, "stiffness": STIFFNESS, "onset": ONSET}
    document = scene(
        bodies, [{"bodies": ["a", "b"], "contact": law}], {}, gravity=[0, 0, -G],
        numerics={"basis": {"order": 3, "elements": elements}},
    )  # fmt: skip
    document["materials"]["soft"] = document["materials"]["soft"] | {"young_modulus": YOUNG}
    document["initial"] = {}
    document["constraints"] = [
        {"name": f"{name}_end", "kind": "weld", "frames": [{"body": name}, {"world": "here"}]}
        for name in "ab"
    ]
    return Dynamics(scene_of(document))


def own_sag(length, force):
    """Height of the middle of a heavy elastica held at both ends, a force on its middle, in m."""
    area = np.pi * R**2
    ea, ei, weight = YOUNG * area, YOUNG * 0.25 * np.pi * R**4, 1100.0 * area * G

    def slopes(s, y):
        angle, bend, h, v = y[2:]
        c, d = np.cos(angle), np.sin(angle)
        stretch = 1.0 + (h * c + v * d) / ea
        along, up = stretch * c, stretch * d
        moment = -(along * v - up * h)
        return np.array([along, up, bend / ei, moment, 0.0 * h, weight + 0.0 * v])

    def ends(a, b):
        return np.array([a[0], a[1], a[2], b[0] - 0.5 * length, b[2], b[5] - 0.5 * force])

    s = np.linspace(0, 0.5 * length, 60)
    start = np.zeros((6, len(s)))
    start[0], start[4], start[5] = s, 0.1, weight * (s - 0.5 * length)
    start[1] = -0.01 * np.sin(np.pi * s / length) ** 2
    found = solve_bvp(slopes, ends, s, start, tol=1e-10, max_nodes=100000)
    assert found.success
    return found.y[1, -1]


def pressing(distance):
    """Force of two crossing cylinders whose axes are so far apart, of the law per length."""

    def per_length(s):
        depth = max(0.0, 2 * R - np.hypot(distance, s))
        return STIFFNESS * (0.5 * depth**2 / ONSET if depth < ONSET else depth - 0.5 * ONSET)

    return 2.0 * quad(per_length, 0, 0.5 * R, epsabs=1e-12, limit=200)[0]


@pytest.mark.parametrize("elements", [2, 4])
def test_ropes_that_cross_press_like_two_elasticas(elements):
    def off(force):
        apart = own_sag(LENGTHS[1], force) + 2 * R + CLEAR - own_sag(LENGTHS[0], -force)
        return pressing(apart) - force

    own = brentq(off, 0.3, 1.2, xtol=1e-9)
    dynamics = crossing(elements)
    q = equilibrium(dynamics)
    found = resultants(ContactReader(dynamics.compiled).near(q, np.zeros(dynamics.n)))
    assert found["b", "a"][5] == pytest.approx(own, rel=1e-3)
    assert np.abs(found["b", "a"] + found["a", "b"]).max() == 0.0
    assert np.abs(found["b", "a"][3:5]).max() < 1e-9


def helix(pitch, turns=1.15, curvature=13.3, **options):
    """A free rod, a turn and more of a helix, with a radius of 2 cm."""
    twist = pitch * curvature**2 / (2.0 * np.pi)
    bend = np.sqrt(curvature**2 - twist**2)
    coil = rod("coil", R2, 2.0 * np.pi * turns / curvature)
    coil["sections"][0]["reference"] = {"curvature": [twist, 0.0, bend]}
    return scene(
        [free("coil"), coil], [{"self": ["coil"], "overlap": True}], {"coil": [0] * 6},
        contact=options.pop("contact", LAW), numerics={"basis": {"order": 2, "elements": 3}},
        **options,
    )  # fmt: skip


def own_gap(pitch, curvature=13.3):
    """Least distance of the axis of a helix from itself about a turn later, less two radii."""
    twist = pitch * curvature**2 / (2.0 * np.pi)
    bend = np.sqrt(curvature**2 - twist**2)
    size, rise = bend / curvature**2, twist / curvature**2
    angles = np.linspace(1.5 * np.pi, 2.3 * np.pi, 20001)
    d = np.hypot(2.0 * size * np.sin(0.5 * angles), rise * angles)
    return d.min() - 2.0 * R2


def test_a_rod_touches_itself_a_turn_later_and_not_its_neighbours():
    apart = Simulation(scene_of(helix(0.0415)))
    assert apart.contacts() == ()
    touching = Simulation(scene_of(helix(0.038)))
    found = touching.contacts()
    assert len(found) > 10
    assert min(abs(contact.s - contact.s_there) for contact in found) > 0.4
    middle = [c for c in found if 0.01 < c.s < touching.compiled.scene.bodies[1].length - 0.01]
    own = own_gap(0.038)
    assert own < -1e-3
    assert min(c.gap for c in middle) == pytest.approx(own, rel=1e-2)


def test_self_contact_pushes_nothing_but_the_rod_itself():
    document = helix(0.038)
    alone = {key: value for key, value in document.items() if key not in ("pairs", "contact")}
    with_it, without = Dynamics(scene_of(document)), Dynamics(scene_of(alone))
    rng = np.random.default_rng(4)
    q = np.concatenate([0.3 * rng.normal(size=6), 1e-3 * rng.normal(size=with_it.n - 6)])
    v, zero = 0.1 * rng.normal(size=with_it.n), np.zeros(with_it.n)
    with_it._data.touch.mode[0] = 0.01
    force = with_it.inverse_dynamics(q, v, zero) - without.inverse_dynamics(q, v, zero)
    assert np.abs(force[6:]).max() > 0.1
    assert np.abs(force[:6]).max() < 1e-12


def forces(document):
    """Resultants in the reference shape at rest, and how many places touch."""
    dynamics = Dynamics(scene_of(document))
    q = np.zeros(dynamics.n)
    for name, x in dynamics.compiled.scene.initial.positions.items():
        q[dynamics.compiled.chain.columns(name)] = x
    found = ContactReader(dynamics.compiled).near(q, np.zeros(dynamics.n))
    return resultants(found), len(found)


@pytest.mark.parametrize("angle", [0.5 * np.pi, np.pi / 6])
@pytest.mark.parametrize("radii", [(0.02, 0.02), (0.01, 0.03)])
def test_crossed_cylinders_touch_with_the_integral_of_the_law(angle, radii):
    """4/3 k √(2 (r₁ + r₂)) φ^1.5/sin α: at right angles π/2 times Hertz's, if they are alike."""
    depth = 0.1 * min(radii)
    at = {
        "a": [0] * 6,
        "b": [0, 0, angle, 0.15 - 0.15 * np.cos(angle), -0.15 * np.sin(angle), sum(radii) - depth],
    }
    law = {"stiffness": 1e5, "onset": 0.0, "friction": 0.0}
    document = scene(
        [free("a"), rod("a", radii[0]), free("b"), rod("b", radii[1])],
        [{"bodies": ["a", "b"], "overlap": True}], at, contact=law,
        numerics={"basis": {"order": 1, "nodes": 4}},
    )  # fmt: skip
    found, places = forces(document)
    own = 4.0 / 3.0 * 1e5 * np.sqrt(2.0 * sum(radii)) * depth**1.5 / np.sin(angle)
    assert places > 3
    assert found["b", "a"][5] == pytest.approx(own, rel=0.05)  # for small depths

    def per_length(s):
        return 1e5 * max(0.0, sum(radii) - np.hypot(sum(radii) - depth, s * np.sin(angle)))

    exact = 2.0 * quad(per_length, 0.0, 0.1, epsabs=1e-9, limit=400)[0]
    assert found["b", "a"][5] == pytest.approx(exact, rel=0.02)
    if radii[0] == radii[1] and angle > 1.5:
        modulus = 1e5 / (0.25 * np.pi)  # of which the law is Hertz's for parallel ones
        hertz = 4.0 / 3.0 * modulus * np.sqrt(radii[0]) * depth**1.5
        assert found["b", "a"][5] == pytest.approx(0.5 * np.pi * hertz, rel=0.05)


def test_parallel_rods_touch_with_the_law_per_length():
    depth = 1e-3
    at = {"a": [0] * 6, "b": [0, 0, 0, 0.1, 0, 0.04 - depth]}
    document = scene(
        [free("a"), rod("a"), free("b"), rod("b")], [{"bodies": ["a", "b"], "overlap": True}], at,
        contact={"stiffness": 1e5, "onset": 0.0, "friction": 0.0},
        numerics={"basis": {"order": 1, "nodes": 4}},
    )  # fmt: skip
    found, _ = forces(document)
    # 0.2 m side by side, and the round end of the one with the stations
    assert found["b", "a"][5] == pytest.approx(1e5 * depth * 0.22, rel=0.03)


@pytest.mark.parametrize(("radius", "curved"), [(0.03, 1 / 0.05 + 1 / 0.03), (None, 1 / 0.05)])
def test_balls_touch_as_hertz_says(radius, curved):
    """Two balls, and a ball on a box."""
    other = {"kind": "sphere", "radius": radius} if radius else {"kind": "box", "size": [0.2] * 3}
    depth, size = 1e-4, radius or 0.1
    contact = {"contact": {"material": "soft"}}
    document = scene(
        [free("a"), solid("a", **contact), free("b"), solid("b", shape=other, **contact)],
        [{"bodies": ["a", "b"], "overlap": True}],
        {"a": [0] * 6, "b": [0, 0, 0, 0, 0, 0.05 + size - depth]},
    )  # fmt: skip
    found, places = forces(document)
    modulus = 1e6 / (2.0 * (1.0 - 0.45**2))
    own = 4.0 / 3.0 * modulus * depth**1.5 / np.sqrt(curved)
    assert places == 1
    assert found["b", "a"][5] == pytest.approx(own, rel=1e-10)


def test_a_wire_between_two_nodes_is_felt_if_it_is_on_the_base():
    """Stations of shapes on bodies, or on the base, are a quarter of a radius apart."""
    wire = {"capsule": "wire", "from": [0.1, -0.2, 0], "to": [0.1, 0.2, 0], "radius": 1e-3}
    wire |= {"overlap": True}
    for own, touches in (({}, False), ({"on": "base"}, True)):
        document = scene(
            [free("a"), rod("a", 2e-3)], [], {"a": [0, 0, 0, 0, 0, 2.9e-3]},
            contact={"stiffness": 1e6}, environment=[wire | own],
            numerics={"basis": {"order": 1, "nodes": 5}},
        )  # fmt: skip
        del document["pairs"]
        found, _ = forces(document)
        assert bool(found) == touches
    assert found["a", "wire"][5] > 0.01
    assert np.abs(found["a", "wire"][3:5]).max() < 0.01 * found["a", "wire"][5]
