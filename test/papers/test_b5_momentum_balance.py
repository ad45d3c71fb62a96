"""B-5: only what acts on a free body from outside changes its momentum."""

import numpy as np
import pytest
from scenes import ALL, SOFT, scene_of

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.settled import Dynamics, Simulation

BASE = {"position": [0.4, -1.0, 2.0], "rpy": [0.5, -0.3, 1.2]}
LENGTH, RADIUS = 0.4, 0.02
STRIP = {
    "length": LENGTH,
    "material": "soft",
    "cross_section": {"shape": "circle", "radius": RADIUS},
}
START = {"velocities": {"base": [1.0, 3.0, -2.0, 0.3, 0.2, -0.1]}}


def body(loads=(), *, gravity=(0, 0, 0), alpha=0.0, maxwell=None, bend=1.0, **numerics):
    """A rod, a hinge with spring and damper, a floating-frame link, a wheel; nothing holds them."""
    damping = {"viscosity": 200.0, "rayleigh": {"mass": alpha}}
    material = SOFT | damping | ({"maxwell": maxwell} if maxwell else {})
    return {
        "name": "flyer", "base": BASE, "gravity": gravity, "materials": {"soft": material},
        "bodies": [
            {"joint": "base", "kind": "free"},
            {"rod": "rod", "strains": ALL, "sections": [STRIP | {"name": "s"}]},
            {"joint": "waist", "kind": "revolute", "axis": [0.3, 1, 0.2], "stiffness": 0.1,
             "damping": 1e-3, "offset": {"position": [0.01, 0.02, 0.0], "rpy": [0.2, 0.1, 0.4]}},
            {"flexible_link": "link", "strains": ["torsion", "bend_y", "bend_z"],
             "modes": {"torsion": 1, "bend_y": 1, "bend_z": 2},
             "sections": [STRIP | {"name": "s", "length": 0.3}]},
            {"rigid_body": "wheel", "mass": 0.2, "inertia": [1e-4, 2e-4, 1.5e-4],
             "com": {"position": [0.02, 0.03, 0.0]}},
        ],
        "loads": list(loads),
        "initial": START | {"strains": {"rod/s": {"bend_y": bend, "torsion": 0.5 * bend}}},
        "numerics": {"basis": {"order": 4, "nodes": 12}} | numerics,
    }  # fmt: skip


def turned(pose, wrench):
    """A wrench along section axes as one about the world's origin, along world axes."""
    moment, force = pose[:3, :3] @ wrench[:3], pose[:3, :3] @ wrench[3:]
    return np.concatenate([moment + np.cross(pose[:3, 3], force), force])


def about_origin(pose, wrench):
    """A wrench along world axes at a section as one about the world's origin."""
    return np.concatenate([wrench[:3] + np.cross(pose[:3, 3], wrench[3:]), wrench[3:]])


WRENCH = np.array([0.02, -0.03, 0.01, 0.3, -0.4, 0.2])


def load(kind, frame, **more):
    first = {kind: "l", "body": "rod", "frame": frame}
    return first | {"moment": WRENCH[:3], "force": WRENCH[3:]} | more


def outside(dynamics, q, v, kind):
    """What acts on the body from outside, about the world's origin: moment and force (6,)."""
    poses = dynamics.node_poses(q)
    mass = dynamics.model.inertia[:, 0]
    rod = dynamics.compiled.chain.rods["rod"]
    start, tip = poses[rod.first_node], poses[rod.last_node]
    if kind == "weight":
        pull = np.array([0.5, -1.0, -9.0])
        at = mass @ poses[:, :3, 3]
        return np.concatenate([np.cross(at, pull), mass.sum() * pull])
    if kind == "drag":
        # of rods and links, not of the wheel
        node = dynamics.compiled.chain.frames["wheel"] + 1
        spin = np.array([1e-4, 2e-4, 1.5e-4, 0.2, 0.2, 0.2]) * dynamics.node_twists(q, v)[node]
        return -0.7 * (dynamics.momentum(q, v) - turned(poses[node], spin))
    if kind in ("dead", "follower"):
        return (about_origin if kind == "dead" else turned)(tip, WRENCH)
    # along the rod: integrate over its strains by ourselves
    x, w = np.polynomial.legendre.leggauss(30)
    total = np.zeros(6)
    frame, here = start, 0.0
    (element,) = rod.elements
    for s, weight in zip(0.5 * LENGTH * (x + 1), 0.5 * LENGTH * w, strict=True):
        for at in np.linspace(here, s, 9)[:-1] + (s - here) / 16:  # steps of constant strain
            strain = np.array([0, 0, 0, 1.0, 0, 0])
            for columns in element.columns:
                own = q[columns[1] : columns[1] + columns[2]]
                strain[columns[0]] += element.values(columns, np.array([at]))[0] @ own
            frame = frame @ se3.exp(strain * (s - here) / 8)
        here = s
        total += weight * (about_origin if kind == "line" else turned)(frame, WRENCH)
    return total


CASES = {
    "weight": body(gravity=[0.5, -1.0, -9.0]),
    "drag": body(alpha=0.7),
    "dead": body([load("point", "world")]),
    "follower": body([load("point", "body")]),
    "line": body([load("distributed", "world")]),
    "line follower": body([load("distributed", "body")]),
}


def rate_of_momentum(dynamics, q, v, a, h=1e-3):
    """P(q) a + (dP/dt) v: the momentum map is linear in v; differences of fourth order along v."""

    def at(t):
        return dynamics.momentum(q + t * v, v)

    turned = (8 * (at(h) - at(-h)) - at(2 * h) + at(-2 * h)) / (12 * h)
    return dynamics.momentum(q, a) + turned


@pytest.mark.parametrize("kind", CASES)
def test_momentum_changes_by_the_wrenches_from_outside(kind):
    """d/dt of the momentum map along the exact acceleration, at a bent, fast and turned state."""
    dynamics = Dynamics(scene_of(CASES[kind]))
    rng = np.random.default_rng(1)
    q = 0.01 * rng.normal(size=dynamics.n) / dynamics.model.weight
    v = 0.2 * rng.normal(size=dynamics.n) / dynamics.model.weight
    q[:6] = [0.4, -0.8, 1.1, 0.3, -0.2, 0.5]
    a = dynamics.forward_dynamics(q, v)
    found, expected = rate_of_momentum(dynamics, q, v, a), outside(dynamics, q, v, kind)
    assert np.abs(expected).max() > 0.05
    np.testing.assert_allclose(found, expected, atol=2e-6)
    # either part of it turned round would be seen
    for flip in ([-1] * 3 + [1] * 3, [1] * 3 + [-1] * 3):
        assert np.abs(expected * flip - found).max() > 1e-2


@pytest.mark.parametrize(
    ("integrator", "order"), [("sdirk4", 4), ("sdirk2", 2), ("generalized_alpha", 2)]
)
def test_momentum_is_the_impulse_of_a_follower_to_the_order_of_the_method(integrator, order):
    steps, errors, ramp = np.array([0.002, 0.001, 0.0005]), [], 0.02
    for step in steps:
        simulation = Simulation(scene_of(body(
            [load("point", "body", schedule={"ramp": ramp})], step=step, integrator=integrator,
            newton_tolerance=1e-12, bend=0.0,
        )))  # fmt: skip
        dynamics = simulation.dynamics

        def now(simulation=simulation, dynamics=dynamics):
            share = min(1.0, simulation.time / ramp)
            return share * outside(dynamics, simulation.q, simulation.v, "follower")

        start, impulse, before = dynamics.momentum(simulation.q, simulation.v), np.zeros(6), now()
        for _ in range(round(0.02 / step)):  # Simpson's rule over two steps
            simulation.advance(1)
            middle = now()
            simulation.advance(1)
            after = now()
            impulse += step / 3 * (before + 4 * middle + after)
            before = after
        change = dynamics.momentum(simulation.q, simulation.v) - start
        errors.append(np.abs(change - impulse).max())
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope > order - 0.4, errors
    assert errors[-1] < 1e-3 * np.abs(impulse).max()


@pytest.mark.parametrize("integrator", ["sdirk2", "generalized_alpha", "energy_midpoint"])
def test_nothing_inside_changes_momentum(integrator):
    """Rod, floating-frame link, Maxwell branches, spring and damper: 1e-10 over 20 000 steps."""
    simulation = Simulation(scene_of(body(
        maxwell={"ratio": 0.5, "time": 0.02}, step=0.002, integrator=integrator,
        basis={"order": {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 0, "shear_y": 0,
                         "shear_z": 0}},
    )))  # fmt: skip
    start = simulation.dynamics.momentum(simulation.q, simulation.v)
    size = np.repeat([np.linalg.norm(start[:3]), np.linalg.norm(start[3:])], 3)
    for _ in range(4):
        simulation.advance(5000)
        now = simulation.dynamics.momentum(simulation.q, simulation.v)
        assert np.all(np.abs(now - start) < 1e-10 * size)
    assert np.linalg.norm(simulation.q[3:6]) > 10.0
