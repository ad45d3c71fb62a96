"""The force of contact: exact tangent, no pull, energy only lost, a state of its own."""

import copy
import pickle

import numpy as np
import pytest
from differences import central_difference
from forests import tree_document
from scenes import random_state, scene_of
from scipy.integrate import solve_ivp
from touching import BALL, G, body, body_document, rod_on_table

from soft_sim_ros.core.mechanics.contacts import resultants
from soft_sim_ros.core.model.contact import CODE
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.state import SimulationState

FIRM = {"stiffness": 1e6, "dissipation": 0.5}


@pytest.fixture(scope="module")
def pressed():
    """A tree in a strong motion, pressed by every shape, and its state."""
    document = tree_document(base={"position": [0.1, 0.2, -0.3], "rpy": [0.4, -0.7, 1.1]})
    bare = Dynamics(scene_of(document))
    state = random_state(bare, 3)
    p = bare.node_poses(state[0])[:, :3, 3]
    middle = p.mean(axis=0).tolist()
    document["environment"] = [
        {"plane": "p", "position": middle, "normal": [0.3, -0.5, 1.0]},
        {"sphere": "s", "position": p[5] + [0.03, 0, 0], "radius": 0.04},
        {"capsule": "c", "from": p[9] + [0, 0.03, 0.1], "to": p[9] + [0.02, 0.03, -0.1],
         "radius": 0.03},
        {"cylinder": "y", "from": p[14] + [0, 0.03, 0.02], "to": p[14] + [0.02, 0.03, -0.1],
         "radius": 0.03},
        {"box": "b", "position": p[18] + [0.03, 0, 0], "size": [0.05, 0.04, 0.08],
         "rpy": [0.3, 0.4, 0.5]},
        {"ellipsoid": "e", "position": p[22] + [0.03, 0, 0], "semi_axes": [0.05, 0.04, 0.03],
         "rpy": [0.3, 0.4, 0.5]},
        {"sphere": "hollow", "position": middle, "radius": 0.3, "inside": True},
    ]  # fmt: skip
    document["contact"] = {
        "stiffness": 3e3, "onset": 0.02, "dissipation": 0.3, "tangential_time": 0.002,
        "friction": {"static": 0.6, "kinetic": 0.4, "across": 0.3},
    }  # fmt: skip
    return bare, Dynamics(scene_of(document)), list(state)


@pytest.mark.parametrize("span", [-1.0, 0.003, 0.5])
def test_the_tangent_with_contact_is_its_difference_quotient(pressed, span):
    """Without friction, mostly sticking, mostly slipping."""
    bare, dynamics, state = pressed
    touch = dynamics._data.touch
    touch.mode[0] = span
    touch.start[:] = 0.0
    dynamics.residual(*state, dynamics.forcing())
    touch.start[..., :CODE] = 1e-3 * np.random.default_rng(1).normal(size=(*touch.kept.shape, 2, 3))
    touch.start[..., CODE] = touch.after[..., CODE]
    touch.kept[:] = 1
    for which in (0, 1):
        exact = dynamics.tangents(*state)[which]

        def residual(x, which=which):
            moved = [*state]
            moved[which] = x
            return dynamics.inverse_dynamics(*moved)

        size = np.full(dynamics.n, 1e-5) / np.maximum(dynamics.model.weight, 1e-3)
        quotient = central_difference(residual, state[which], size)
        scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
        assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 1e-6
        assert np.abs(exact - bare.tangents(*state)[which]).max() > 0.1
    code = touch.after[..., CODE].astype(int)
    assert set((code // 2).ravel()) == set(range(8 if span > 0.0 else 1))
    if span > 0.0:
        sticks, slips = np.sum(code % 2 == 1), np.sum((code > 0) & (code % 2 == 0))
        assert min(sticks, slips) > 5 and slips > (5 if span < 0.1 else 20)


def test_contact_is_no_weight_and_no_elasticity(pressed):
    bare, dynamics, state = pressed
    assert np.allclose(dynamics.gravity_force(state[0]), bare.gravity_force(state[0]), atol=1e-9)
    zero = np.zeros(dynamics.n)
    # and without friction it is the slope of the energy that it stores
    dynamics._data.touch.mode[0] = -1.0
    force = dynamics.inverse_dynamics(state[0], zero, zero)
    force = force - bare.inverse_dynamics(state[0], zero, zero)

    def stored(q):
        return np.array([dynamics.energies(q, zero)[1] - bare.energies(q, zero)[1]])

    size = np.full(dynamics.n, 1e-5) / np.maximum(dynamics.model.weight, 1e-3)
    slope = central_difference(stored, state[0], size)[0]
    assert np.allclose(force, slope, rtol=1e-6, atol=1e-7 * np.abs(slope).max())
    assert np.abs(slope).max() > 1.0


def own_bounce(stiffness, dissipation, mass, radius, height, time, share):
    """Return height, speed of a ball that falls onto the floor: the same law, by scipy, exact."""
    onset = 0.01 * radius
    c = stiffness * share

    def law(t, x):
        depth, rate = radius - x[0], -x[1]
        if depth <= 0.0:
            return [x[1], -G]
        push = 0.5 * c * depth**2 / onset if depth < onset else c * (depth - 0.5 * onset)
        return [x[1], -G + push * max(0.0, 1.0 + dissipation * rate) / mass]

    def touches(t, x):
        return x[0] - radius

    touches.terminal = True
    t, x = 0.0, np.array([height, 0.0])
    while t < time:
        found = solve_ivp(law, (t, time), x, "DOP853", rtol=1e-12, atol=1e-14, events=touches,
                          max_step=1e-3)  # fmt: skip
        t, x = found.t[-1], found.y[:, -1]
        if found.status == 1:  # a little across, on the same way
            t, x = t + 1e-9, x + 1e-9 * np.array([x[1], -G])
    return x


@pytest.mark.parametrize(
    ("integrator", "step", "off"), [("sdirk2", 2e-5, 2e-5), ("adaptive", 1e-3, 2e-5)]
)
def test_a_ball_bounces_as_the_law_says(integrator, step, off):
    options = {"options": {"error": 1e-8}} if integrator == "adaptive" else {}
    ball = body(
        contact=FIRM | {"friction": 0.0},
        at=[0, 0, 0, 0, 0, 0.15],
        numerics={"step": step, "integrator": integrator} | options,
    )
    ball.advance(round(0.4 / step))
    height, speed = own_bounce(1e6, 0.5, 0.5, 0.05, 0.15, 0.4, 0.05)
    assert ball.q[5] == pytest.approx(height, abs=off)
    assert ball.v[5] == pytest.approx(speed, abs=30 * off)
    lost = ball.ledger()[5]
    assert lost == pytest.approx(
        0.5 * G * 0.1 - 0.5 * (G * (height - 0.05) + speed**2 / 2), rel=1e-3
    )


def test_a_ball_comes_to_rest_and_stays():
    ball = body(contact=FIRM | {"dissipation": 5.0}, at=[0, 0, 0, 0, 0, 0.06])
    ball.advance(4000)
    place = ball.q.copy()
    ball.advance(10000)
    assert np.abs(ball.q - place).max() < 1e-9
    (contact,) = ball.contacts()
    assert contact.normal_force == pytest.approx(0.5 * G, rel=1e-9)
    # c (φ − δ/2) with c = k R, δ = R/100, or c φ²/2δ before
    assert contact.gap == pytest.approx(-np.sqrt(2 * 5e-4 * 0.5 * G / 5e4), rel=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_contact_never_makes_energy(seed):
    """Thrown boxes and balls, spinning: what is stored and moves only falls."""
    rng = np.random.default_rng(seed)
    shape = BALL if seed % 2 else {"kind": "box", "size": rng.uniform(0.05, 0.12, 3)}
    thing = body(
        shape=shape,
        inertia=[5e-4, 6e-4, 7e-4],
        contact={"stiffness": 1e6, "dissipation": rng.choice([0.0, 0.5]),
                 "friction": {"static": 0.7, "kinetic": 0.5}},
        at=[*rng.normal(size=3), 0, 0, 0.2],
        speed=[*(4 * rng.normal(size=3)), *rng.normal(size=2), -1.0],
        numerics={"step": 5e-4},
    )  # fmt: skip
    energy, residual = [], []
    for _ in range(100):
        thing.advance(20)
        ledger = thing.ledger()
        energy.append(ledger[:3].sum())
        residual.append(ledger[-1])
    turned = energy[0] - min(ledger[2], energy[-1])
    assert np.diff(energy).max() < 1e-4 * turned
    assert np.abs(residual).max() < 0.02 * turned
    assert ledger[5] > 0.1 * energy[0] or seed % 2


def test_contact_pushes_and_never_pulls():
    """A ball that leaves fast: with (1 + d φ̇) below zero the force is zero."""
    ball = body(
        contact={"stiffness": 1e6, "dissipation": 5.0},
        at=[0, 0, 0, 0, 0, 0.0495],
        speed=[0, 0, 0, 0, 0, 1.0],
    )
    (contact,) = ball.contacts()
    assert contact.gap < 0.0 and contact.normal_force == 0.0
    ball.advance(1)
    assert ball.v[5] == pytest.approx(1.0 - 1e-3 * G, abs=1e-12)


SLIDING = body_document(
    shape={"kind": "box", "size": [0.1, 0.1, 0.1]},
    inertia=[8e-4] * 3,
    at=[0, 0, 0, 0, 0, 0.051],
    speed=[0, 0, 1.0, 0.3, 0.1, 0],
    tilt=0.3,
    contact=FIRM | {"friction": {"static": 0.5, "kinetic": 0.4}},
)


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_states_with_friction_go_on_with_the_same_bits(integrator, tmp_path):
    scene = scene_of(SLIDING | {"numerics": {"step": 1e-3, "integrator": integrator}})
    one = Simulation(scene)
    one.advance(150)
    state = one.state()
    assert state.bristles.any()
    state.save(tmp_path / "state.npz")
    others = [Simulation(one.compiled), copy.deepcopy(one), pickle.loads(pickle.dumps(one))]
    others[0].advance(37)
    others[0].restore(SimulationState.load(tmp_path / "state.npz"))
    two = Simulation(scene)
    for _ in range(250):
        two.advance(1)
    one.advance(100)
    assert two.state() == one.state()
    for other in others:
        other.advance(100)
        assert other.state() == one.state()
        assert other.ledger().tobytes() == one.ledger().tobytes()


def test_a_reset_lets_go():
    thing = Simulation(scene_of(SLIDING))
    start = thing.state()
    thing.advance(150)
    thing.reset()
    assert not thing.state().bristles.any() and (thing.q == start.q).all()


def test_twice_the_elements_have_the_same_forces():
    """A soft rod that hangs down onto a table: the resultant, and where it acts."""
    found = []
    for elements in (4, 8, 16):
        document = rod_on_table(height=0.02, elements=elements)
        document["initial"] = {"state": "equilibrium"}
        rod = Simulation(scene_of(document))
        wrench = resultants(rod.contacts())["rod", "table"]
        found.append([wrench[5], -wrench[1] / wrench[5], *rod.tips().poses()[0, :3]])
    found = np.array(found)
    off = np.abs(found - found[-1]).max(axis=1) / 0.4
    assert off[1] < 2e-4 and off[0] < 2e-3
    assert 0.5 < found[-1, 0] < 1.0


def test_what_is_far_away_changes_no_bit():
    document = rod_on_table(height=5.0)
    near, without = Simulation(scene_of(document)), dict(document)
    del without["environment"]
    alone = Simulation(scene_of(without))
    for simulation in (near, alone):
        simulation.advance(200)
    assert near.q.tobytes() == alone.q.tobytes() and near.contacts() == ()


@pytest.mark.parametrize(("normal", "flat"), [([0, 0, 1], True), ([0, 0.1, 1], False)])
def test_a_rod_stays_in_its_plane_where_the_shapes_do(normal, flat):
    document = rod_on_table(height=0.02, numerics={"step": 1e-3})
    document["environment"][0]["normal"] = normal
    document["environment"][0]["position"] = [0, 0, -0.04]
    pruned, full = (Simulation(scene_of(document), prune=prune) for prune in (True, False))
    name = type(pruned._problem.model.space).__name__
    assert (name != "Spatial") == flat
    for simulation in (pruned, full):
        simulation.advance(300)
    assert np.allclose(pruned.q, full.q, rtol=0.0, atol=1e-9 * np.abs(full.q).max())
    assert pruned.contacts()
