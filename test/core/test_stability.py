"""What is called stable stays and what is not leaves, under dead moments and loads that follow."""

import warnings

import numpy as np
import pytest
from scenes import rod, rod_document, scene_of
from scipy.special import jn_zeros

from soft_sim_ros.core.analysis.continuation import BIFURCATION, follow, switch
from soft_sim_ros.core.analysis.load_path import tip_wrench, whole_load
from soft_sim_ros.core.analysis.modes import complex_modes, modes
from soft_sim_ros.core.analysis.small_motion import all_decay, small_motions
from soft_sim_ros.core.analysis.stability import verdict
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import StaticsFailed, UndampedFlutter

LENGTH, E = 0.6, 1e6


def slender(slenderness, *, ratio=1.0, order=6, damping=0.0, **options):
    """Return a rod of length over radius, its EI in N·m² and its slowest frequency in rad/s.

    ``ratio`` of its widths, 1: round; ``damping`` ratio of the slowest mode, by its mass.
    """
    radius = LENGTH / slenderness
    section, area = {}, np.pi * radius**2
    inertia = 0.25 * area * radius**2
    if ratio > 1.0:
        area = 4.0 * ratio * radius**2
        inertia = area * radius**2 / 3.0
        shape = {"shape": "rectangle", "width_y": 2 * ratio * radius, "width_z": 2 * radius}
        section = {"cross_section": shape}
    omega = 1.8751040687**2 * np.sqrt(E * inertia / (1000.0 * area)) / LENGTH**2
    material = {"rayleigh": {"mass": float(2.0 * damping * omega)}} if damping else {}
    dynamics = rod(
        radius=radius, order=order, nodes=24, material=material, section=section, **options
    )
    return dynamics, E * inertia, omega


def judged(dynamics, q, tip, follows=False):
    zero = np.zeros(dynamics.n)
    residual = dynamics.residual(q, zero, zero, dynamics.forcing(tip=tip, tip_follows=follows))
    assert np.abs(residual / dynamics.model.weight).max() < 1e-9 * max(np.abs(tip).max(), 1e-300)
    return verdict(dynamics)


@pytest.mark.parametrize("slenderness", [20.0, 300.0, 1e4])
@pytest.mark.parametrize("twist", [1e-6, 1e-3, 0.3])
def test_a_twisted_column_is_unstable_beyond_eulers_load_at_any_slenderness(slenderness, twist):
    """Round: of two equal λ the twist makes a pair, whose real part is that of the column.

    With w = y + iz, EI w⁗ + P w″ − i M w‴ = … , and M enters the buckling load squared.
    """
    for damping in (0.0, 0.02):
        dynamics, stiff, omega = slender(slenderness, damping=damping, order=4)
        euler = 0.25 * np.pi**2 * stiff / LENGTH**2
        straight = np.zeros(dynamics.n)
        for share, unstable in ((0.8, 0), (1.5, 2)):
            tip = np.array([twist * stiff / LENGTH, 0, 0, -share * euler, 0, 0])
            q = equilibrium(dynamics, straight, tip=tip, stable=False)
            found = judged(dynamics, q, tip)
            growth = complex_modes(dynamics, q, tip=tip).growth
            assert (found.unstable > 0) == (growth > 0.0)
            if unstable:
                assert found.unstable >= 2 and found.refused and found.growth > 0.3 * omega
                with pytest.raises(StaticsFailed, match="loses stability") as failure:
                    equilibrium(dynamics, tip=tip, thorough=False)
                # strong twist pulls the buckling load down by M² / 4 EI
                assert share * failure.value.load_factor < 1.001
            elif damping and twist < 0.01:
                assert not found.unstable and growth < 0.0
                equilibrium(dynamics, tip=tip, thorough=False)


@pytest.mark.parametrize("slenderness", [20.0, 300.0, 1e4])
def test_a_twisted_strip_is_unstable_in_one_direction_at_any_slenderness(slenderness):
    dynamics, stiff, omega = slender(slenderness, ratio=1.3)
    euler = 0.25 * np.pi**2 * stiff / LENGTH**2
    for share in (0.9, 0.9999, 1.0001, 1.5):
        shorter = (np.pi / 2 / slenderness) ** 2 / 3.0  # the column is shorter when it buckles
        load = share * (1.0 + 2.0 * shorter)
        tip = np.array([0.01 * stiff / LENGTH, 0, 0, -load * euler, 0, 0])
        q = equilibrium(dynamics, tip=tip, stable=False)
        if slenderness > 100.0 or abs(share - 1.0) > 0.01:
            assert judged(dynamics, q, tip).unstable == int(share > 1.0)
    growth = complex_modes(dynamics, q, tip=tip).growth
    assert growth == pytest.approx(omega * np.sqrt(0.5), rel=0.1)


@pytest.mark.parametrize("slenderness", [300.0, 1e4])
def test_becks_column_flutters_beyond_its_load_and_that_is_said(slenderness):
    """P = 20.05 EI/L² without damping; λ are complex beyond, none is negative."""
    dynamics, stiff, _ = slender(slenderness, strains=["bend_z", "stretch", "shear_y"], order=8)
    for load, unstable in ((19.7, 0), (20.4, 2)):
        tip = np.array([0, 0, 0, -load * stiff / LENGTH**2, 0, 0])
        q = equilibrium(dynamics, tip=tip, tip_follows=True, stable=False)
        found = judged(dynamics, q, tip, follows=True)
        assert found.unstable == unstable
        assert (complex_modes(dynamics, q, tip=tip, tip_follows=True).growth > 0.0) == (
            unstable > 0
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            if not unstable:
                equilibrium(dynamics, tip=tip, tip_follows=True)
    assert found.flutters and found.undamped and not found.refused
    with pytest.warns(UndampedFlutter, match="a swing of .* Hz about it grows by"):
        equilibrium(dynamics, tip=tip, tip_follows=True)
    # a little damping has it refused: with mass damping the load is nearly the same
    damped = slender(slenderness, strains=["bend_z", "stretch", "shear_y"], order=8, damping=1e-3)[
        0
    ]
    with pytest.raises(StaticsFailed, match="it flutters, a swing of") as failure:
        equilibrium(damped, tip=tip, tip_follows=True, thorough=False)
    assert 20.4 * failure.value.load_factor == pytest.approx(20.05, rel=5e-3)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_zieglers_pendulum_flutters_at_his_load(scale):
    """Two equal links, masses 2m and m at their ends, springs c, a follower P: P l/c = 7/2 − √2."""
    spring = 0.3 * scale**2

    def link(name, mass):
        place = {"position": [scale, 0.0, 0.0]}
        return {
            "rigid_body": name,
            "mass": mass,
            "inertia": [1e-12 * mass * scale**2] * 3,
            "com": place,
        }

    hinge = {"kind": "revolute", "axis": [0.0, 0.0, 1.0], "stiffness": spring}
    document = {
        "name": "ziegler", "gravity": [0.0, 0.0, 0.0],
        "bodies": [
            {"joint": "a"} | hinge, link("one", 2.0),
            {"joint": "b", "offset": {"position": [scale, 0.0, 0.0]}} | hinge, link("two", 1.0),
        ],
    }  # fmt: skip
    dynamics = Dynamics(scene_of(document))
    critical = (3.5 - np.sqrt(2.0)) * spring / scale
    straight = np.zeros(dynamics.n)
    for share, unstable in ((0.999, 0), (1.001, 2), (1.5, 2)):
        tip = np.array([0, 0, 0, -share * critical, 0, 0])
        assert judged(dynamics, straight, tip, follows=True).unstable == unstable


@pytest.mark.parametrize("slenderness", [10.0, 100.0, 1e3, 1e4])
def test_slow_modes_are_right_at_any_slenderness(slenderness):
    dynamics, _, omega = slender(slenderness)
    straight = np.zeros(dynamics.n)
    found = modes(dynamics, straight)[0]
    assert found[:2] == pytest.approx([omega, omega], rel=20.0 / slenderness**2 + 1e-6)
    swinging = complex_modes(dynamics, straight)
    np.testing.assert_allclose(swinging.values[:4].imag, found[:4], rtol=1e-10)
    assert swinging.growth == 0.0


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_a_pushed_run_does_what_the_verdict_says(damping):
    """A column that its foot twists: pushed by 1e-7, the run grows as complex_modes say."""
    dynamics, stiff, omega = slender(100.0, damping=damping, order=4)
    tip = np.array([0.3 * stiff / LENGTH, 0, 0, -3.0 * stiff / LENGTH**2, 0, 0])
    q = equilibrium(dynamics, tip=tip, stable=False)
    growth = complex_modes(dynamics, q, tip=tip).growth
    assert judged(dynamics, q, tip).refused and growth > 0.1 * omega
    scene = dynamics.compiled.scene
    simulation = Simulation(scene)
    simulation.set_tip_wrench(tip)
    rng = np.random.default_rng(1)
    push = 1e-7 * rng.normal(size=dynamics.n) / dynamics.model.weight
    push[np.array([component > 2 for component in _components(dynamics)])] = 0.0
    simulation.set_state(q + push, np.zeros(dynamics.n))
    steps = int(np.log(1e2) / growth / (simulation.step_ns * 1e-9))
    simulation.advance(steps)
    before = np.linalg.norm((simulation.q - q) * dynamics.model.weight)
    simulation.advance(steps)
    after = np.linalg.norm((simulation.q - q) * dynamics.model.weight)
    measured = np.log(after / before) / (steps * simulation.step_ns * 1e-9)
    assert measured == pytest.approx(growth, rel=0.05)


def _components(dynamics):
    out = np.zeros(dynamics.n, dtype=int)
    for element in dynamics.compiled.chain.rods["rod"].elements:
        for component, first, count in element.columns:
            out[first : first + count] = component
    return out


def cone(order, length, tip):
    """Return an upright cone under its weight, and its buckling load over its weight.

    E I₀ (x/L)⁴ θ″ + … from the tip: θ = x^(−3/2) J₃(2 √(βx)), β = ρ g A₀ L²/3 E I₀ per length, so
    ρ g A₀ L³/E I₀ = 3/4 j₃₁² (Dinnik); as a column, 9/4 j² with J₋₁⸝₃(j) = 0.
    """
    foot = 0.05 * length
    document = rod_document(
        length=length, strains=["bend_y"], order=order, nodes=40, gravity=(0.0, 0.0, -9.81),
        base={"rpy": [0.0, -np.pi / 2, 0.0]},
        section={"cross_section": {"shape": "circle", "radius": [foot, tip * foot]}},
    )  # fmt: skip
    document["bodies"][0]["model"] = "euler_bernoulli"
    constant = 0.75 * jn_zeros(3, 1)[0] ** 2 if tip < 0.1 else 2.25 * 1.8663509**2
    weight = 1000.0 * 9.81 * length**3 * 4.0 / (E * foot**2)  # ρ g A₀ L³/E I₀
    return Dynamics(scene_of(document)), constant / weight


@pytest.mark.parametrize("order", [3, 5, 6, 7, 8, 11, 15])
@pytest.mark.parametrize(("length", "tip"), [(6e-4, 1e-6), (0.6, 1e-6), (100.0, 1e-6), (0.6, 1.0)])
def test_a_straight_column_bifurcates_whatever_its_taper_order_and_scale(order, length, tip):
    dynamics, critical = cone(order, length, tip)
    path = whole_load(dynamics)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 1.5 * critical))
    assert [point.kind for point in branch.special] == [BIFURCATION]
    assert branch.special[0].load == pytest.approx(critical, rel=2e-3)
    assert branch.unstable.tolist() == [int(x > branch.special[0].load) for x in branch.loads]


def test_the_branch_that_buckled_bifurcates_too_where_its_load_turns_round():
    """On it dλ/ds changes its sign at Euler's load, as at a limit, but no load pushes there."""
    dynamics, stiff, _ = slender(50.0, strains=["bend_y"], order=7)
    push = np.array([0, 0, 0, -stiff / LENGTH**2, 0, 0])
    path = tip_wrench(dynamics, push)
    straight = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 4.0))
    (point,) = straight.special
    buckled = switch(dynamics, path, point, within=(0.0, 3.0))
    back = follow(
        dynamics, path, buckled.q[-1], buckled.loads[-1], within=(0.0, 3.0), downwards=True
    )
    (again,) = back.special
    assert again.kind == BIFURCATION
    assert again.load == pytest.approx(np.pi**2 / 4, rel=1e-4)
    assert back.q[-1] == pytest.approx(-back.q[0], abs=1e-6 / dynamics.model.weight.min())


@pytest.mark.parametrize("seed", range(8))
def test_what_is_said_to_decay_without_shapes_does_not_grow_with_them(seed):
    """The short answer agrees with the long one on either side, and never calls growth decay."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 12))
    a, b, c = rng.normal(size=(3, n, n))
    stiffness = np.eye(n) + 0.2 * (seed % 4) * (a - a.T)
    damping, mass = 0.1 * (b @ b.T) + 0.01 * np.eye(n), c @ c.T + 0.1 * np.eye(n)
    scale = rng.uniform(0.1, 10.0, n)
    unit = np.outer(scale, scale)
    given = stiffness * unit, damping * unit, mass * unit, scale
    below = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    first = np.vstack([np.eye(n, 2 * n, n), below])
    grows = bool(np.linalg.eigvals(first).real.max() > 0.0)
    assert bool(small_motions(*given).growing.any()) == grows
    assert all_decay(*given) == (not grows)
    undamped = stiffness * unit, np.zeros((n, n)), mass * unit, scale
    assert not all_decay(*undamped)
