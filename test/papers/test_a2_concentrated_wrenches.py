"""A-2: wrenches at both ends and at inner sections; the internal wrench Θ jumps by what acts."""

import numpy as np
import pytest
from scenes import ALL, SOFT, random_state, rod, rod_document, scene_of, zoo_document
from scipy.integrate import solve_ivp

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import load_scene

E, G, RHO = SOFT["young_modulus"], SOFT["shear_modulus"], SOFT["density"]
LENGTH, RADIUS = 0.6, 0.03
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
STIFF = np.array([2 * G * INERTIA, E * INERTIA, E * INERTIA, E * AREA, G * AREA, G * AREA])
DEAD = {0.15: [0.1, -0.05, 0.2, 1.0, -2.0, 1.5], 0.4: [0.0, 0.3, -0.1, -0.5, 1.0, 2.0]}
TIP = np.array([-0.1, 0.05, 0.1, 0.4, 0.8, -0.6])


def loaded(frame, **options):
    loads = [
        {"point": f"p{i}", "body": "rod", "s": s, "moment": w[:3], "force": w[3:], "frame": frame}
        for i, (s, w) in enumerate(DEAD.items())
    ]
    document = rod_document(section={"shear_correction": 1.0}, loads=loads, **options)
    return Dynamics(scene_of(document))


def world_parts(dynamics, q, wrench):
    """Moments and forces (N, 3) of section wrenches along world axes."""
    turn = dynamics.node_poses(q)[:, :3, :3]
    return [np.einsum("kij,kj->ki", turn, x) for x in (wrench[:, :3], wrench[:, 3:])]


def test_dead_wrenches_beyond_a_section_are_what_it_carries():
    """Without weight n(s) = Σ f_k and m(s) = Σ m_k + (r_k − r) × f_k over all σ_k beyond s."""
    dynamics = loaded("world", order=7)
    q = equilibrium(dynamics, tip=TIP)
    wrench = dynamics.internal_wrench(q, tip=TIP)
    position = dynamics.node_poses(q)[:, :3, 3]
    loads = [*DEAD.items(), (LENGTH, TIP)]
    at = {s: position[np.argmin(abs(wrench.s - s))] for s, _ in loads}
    for side, beyond in ((wrench.before, np.greater_equal), (wrench.after, np.greater)):
        moment, force = world_parts(dynamics, q, side)
        for k, s in enumerate(wrench.s):
            expected = np.zeros(6)
            for where, (*m, fx, fy, fz) in loads:
                if beyond(where, s) or (abs(where - s) < 1e-12 and beyond is np.greater_equal):
                    f = np.array([fx, fy, fz])
                    expected += np.concatenate([m + np.cross(at[where] - position[k], f), f])
            np.testing.assert_allclose(np.concatenate([moment[k], force[k]]), expected, atol=1e-11)


@pytest.mark.parametrize("frame", ["world", "body"])
def test_equilibrium_at_the_jumps_holds_to_round_off(frame):
    """The part between σ⁻ and σ⁺ has no length: Θ(σ⁺) − Θ(σ⁻) + 𝒯_k = 0, ends included."""
    dynamics = loaded(frame, order=4, gravity=(0, 0, -9.81))
    q = equilibrium(dynamics, tip=TIP, tip_follows=frame == "body")
    wrench = dynamics.internal_wrench(q, tip=TIP, tip_follows=frame == "body")
    turn = dynamics.node_poses(q)[:, :3, :3]
    jump = wrench.after - wrench.before
    applied = np.zeros_like(jump)
    for s, load in [*DEAD.items(), (LENGTH, TIP)]:
        k = np.argmin(abs(wrench.s - s))
        axes = turn[k].T if frame == "world" else np.eye(3)
        applied[k] = [*(axes @ load[:3]), *(axes @ load[3:])]
    assert np.abs(jump[1:] + applied[1:]).max() < 1e-10
    assert np.abs(wrench.after[-1]).max() == 0.0
    assert np.abs(applied).max() > 1.0


def test_follower_wrenches_are_an_initial_value_problem_from_the_tip():
    """In section axes m′ = −K × m − Γ × n, n′ = −K × n with the strains of the section law."""
    dynamics = loaded("body", order=9, nodes=24)
    q = equilibrium(dynamics, tip=TIP, tip_follows=True)
    wrench = dynamics.internal_wrench(q, tip=TIP, tip_follows=True)

    def rates(s, w):
        k, gamma = np.split(np.array([0, 0, 0, 1.0, 0, 0]) + w / STIFF, 2)
        return np.concatenate([-np.cross(k, w[:3]) - np.cross(gamma, w[3:]), -np.cross(k, w[3:])])

    state, end = TIP.copy(), LENGTH
    for start in (0.4, 0.15, 0.0):
        path = solve_ivp(rates, (end, start), state, rtol=1e-11, atol=1e-13, dense_output=True)
        inside = (wrench.s > start + 1e-9) & (wrench.s < end - 1e-9)
        for side in (wrench.before, wrench.after):
            np.testing.assert_allclose(side[inside], path.sol(wrench.s[inside]).T, atol=1e-6)
        state = path.y[:, -1] + (DEAD[start] if start else 0.0)
        end = start
    np.testing.assert_allclose(wrench.before[0], state, atol=1e-6)


def test_a_spinning_inextensible_rod_pulls_with_half_rho_a_omega_squared():
    """N(s) = ρA ω² (ℓ² − s²)/2 in a straight rod that turns about its end."""
    document = rod_document(strains=["bend_y"])
    document["bodies"].insert(0, {"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]})
    dynamics = Dynamics(scene_of(document))
    v = np.zeros(dynamics.n)
    v[0] = 7.0
    wrench = dynamics.internal_wrench(np.zeros(dynamics.n), v)
    expected = RHO * AREA * 7.0**2 * (LENGTH**2 - wrench.s**2) / 2
    np.testing.assert_allclose(wrench.before[:, 3], expected, atol=1e-11 * expected[0])
    np.testing.assert_allclose(np.delete(wrench.before, 3, axis=1), 0.0, atol=1e-11 * expected[0])


@pytest.mark.parametrize("seed", range(2))
def test_the_part_beyond_any_joint_or_element_obeys_newton_and_euler(seed):
    """d/dt momentum of everything beyond = applied wrenches − Λ, by differences of momenta."""
    document = zoo_document(base={})
    document["gravity"] = [0.0, 0.0, 0.0]
    document["loads"] = []
    document["bodies"][-1]["com"] = {"position": [0.03, -0.01, 0.02]}
    dynamics = Dynamics(scene_of(document))
    q, v, a = random_state(dynamics, seed)
    tip = np.array([0.1, 0.2, -0.1, 0.4, -0.3, 0.5])
    wrench = dynamics.internal_wrench(q, v, a, tip=tip)

    def momenta(h):
        """Moment of momentum about the origin and momentum (N, 6) of nodes k, k + 1, …"""
        x, rate = q + h * v + 0.5 * h * h * a, v + h * a
        poses, twists = dynamics.node_poses(x), dynamics.node_twists(x, rate)
        turn, r = poses[:, :3, :3], poses[:, :3, 3]
        inertia = dynamics.model.inertia
        spin = np.einsum("kij,kj->ki", turn, inertia[:, 1:] * twists[:, :3])
        push = np.einsum("kij,kj->ki", turn, inertia[:, :1] * twists[:, 3:])
        each = np.concatenate([spin + np.cross(r, push), push], axis=1)
        return np.cumsum(each[::-1], axis=0)[::-1]

    h = 2e-4
    rate = (8 * (momenta(h) - momenta(-h)) - momenta(2 * h) + momenta(-2 * h)) / (12 * h)
    moment, force = world_parts(dynamics, q, wrench.before)
    poses = dynamics.node_poses(q)
    applied = np.concatenate([tip[:3] + np.cross(poses[-1, :3, 3], tip[3:]), tip[3:]])
    chain = dynamics.compiled.chain
    frames = chain.frames
    nodes = {0, frames["hip"], frames["motor"], frames["knee"], frames["payload"] + 1}
    for k in nodes | {m.first_node for m in chain.rods.values()}:
        about = np.concatenate([moment[k] + np.cross(poses[k, :3, 3], force[k]), force[k]])
        np.testing.assert_allclose(about, applied - rate[k], atol=1e-7 * np.abs(rate).max())


def test_weight_of_the_part_beyond_is_carried_and_converges_with_the_nodes():
    """The law of active strains and the balance of wrenches must agree as the mesh is refined."""
    errors = []
    for order in (4, 8, 12):
        dynamics = rod(order=order, nodes=40, gravity=(3.0, -2.0, -9.81), strains=ALL)
        q = equilibrium(dynamics)
        wrench = dynamics.internal_wrench(q)
        turn = dynamics.node_poses(q)[:, :3, :3]
        force = RHO * AREA * (LENGTH - wrench.s)[:, None] * np.array([3.0, -2.0, -9.81])
        held = np.einsum("kji,kj->ki", turn, force)
        np.testing.assert_allclose(wrench.before[:, 3:], held, atol=1e-11)
        element = dynamics.compiled.chain.rods["rod"].elements[0]
        law = np.zeros_like(wrench.before)
        stiffness = element.section.stiffness(element.normalised(wrench.s))
        for columns in element.columns:
            component, first, count = columns
            strain = element.values(columns, wrench.s) @ q[first : first + count]
            law[:, component] = stiffness[:, component] * strain
        errors.append(np.abs(law - wrench.before).max() / np.abs(law).max())
    assert errors[0] > 30 * errors[1] > 900 * errors[2], errors


def test_the_scene_of_this_row_jumps_where_it_says():
    dynamics = Dynamics(load_scene("loaded_beam"))
    wrench = dynamics.internal_wrench(equilibrium(dynamics))
    jumps = np.abs(wrench.after - wrench.before).max(axis=1) > 1e-9
    np.testing.assert_allclose(wrench.s[jumps], [0.25, 0.5, 0.8, 1.0], atol=1e-12)


def test_distributed_loads_are_carried_by_all_sections_before_them():
    """A dead line load on [0.15, 0.4] m and, while its schedule lasts, one that follows."""
    dead, moment = np.array([1.0, -3.0, 2.0]), np.array([0.2, 0.0, 0.0])
    loads = [
        {"distributed": "d", "body": "rod", "start": 0.15, "end": 0.4, "force": dead},
        {"distributed": "m", "body": "rod", "moment": moment, "frame": "body",
         "schedule": {"start": 1.0}},
    ]  # fmt: skip
    dynamics = Dynamics(scene_of(rod_document(order=8, nodes=16, loads=loads)))
    q = equilibrium(dynamics)
    wrench = dynamics.internal_wrench(q)
    _, force = world_parts(dynamics, q, wrench.before)
    covered = np.clip(0.4 - wrench.s, 0.0, 0.25)
    np.testing.assert_allclose(force, np.outer(covered, dead), atol=1e-11)
    np.testing.assert_allclose(wrench.after[:-1], wrench.before[:-1], atol=1e-11)
    zero = np.zeros(dynamics.n)
    later = dynamics.internal_wrench(zero, time=2.0).before - dynamics.internal_wrench(zero).before
    np.testing.assert_allclose(later[:, :3], np.outer(LENGTH - wrench.s, moment), atol=1e-12)


def test_rayleigh_drag_is_carried_as_any_load():
    """A bar that spins about its own axis: the drag's moment α ρ(I_y + I_z) ω (ℓ − s)."""
    document = rod_document(strains=["bend_y"], material={"rayleigh": {"mass": 2.0}})
    document["bodies"].insert(0, {"joint": "hub", "kind": "revolute", "axis": [1, 0, 0]})
    dynamics = Dynamics(scene_of(document))
    v = np.zeros(dynamics.n)
    v[0] = 5.0
    wrench = dynamics.internal_wrench(np.zeros(dynamics.n), v)
    expected = -2.0 * RHO * 2 * INERTIA * 5.0 * (LENGTH - wrench.s)
    np.testing.assert_allclose(wrench.after[1:, 0], expected[1:], atol=1e-12 * abs(expected[0]))
