"""Rest in a fluid: shapes in a current, buoyancy, ends without pressure, frequencies, stability."""

import numpy as np
import pytest
from scenes import rod_document, scene_of
from scipy.integrate import quad, solve_bvp, solve_ivp
from waters import WATER

from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.modes import complex_modes, modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene import Rod

G, LENGTH, RADIUS, YOUNG = 9.81, 0.5, 0.01, 1e6


def bent_in(current, drag, along, buoyant):
    """Place of the tip of an inextensible cantilever in the x-z plane, and the force at its base.

    θ is the angle of its tangent (cos θ, sin θ); force n and moment m in world axes, all per
    length: n′ = −f, m′ = −t × n − μ with Munk's moment μ = −ρ_f A (u·t)(u·n).
    """
    d, stiff = 2.0 * RADIUS, YOUNG * np.pi * RADIUS**4 / 4

    def force(theta):
        t = np.array([np.cos(theta), np.sin(theta)])
        normal = np.array([-t[1], t[0]])
        across, friction = current @ normal, 500.0 * np.pi * d * along
        push = (500.0 * d * drag - friction) * np.abs(across) * across * normal
        push += friction * np.linalg.norm(current) * current[:, None]
        return push + np.array([np.zeros_like(theta), np.full_like(theta, buoyant)])

    def rates(s, y):
        _, _, theta, m, nx, nz = y
        fx, fz = force(theta)
        cos, sin = np.cos(theta), np.sin(theta)
        munk = -1000.0 * np.pi * RADIUS**2 * (current @ [cos, sin]) * (current @ [-sin, cos])
        return np.array([cos, sin, m / stiff, -(cos * nz - sin * nx) - munk, -fx, -fz])

    def ends(a, b):
        return np.array([a[0], a[1], a[2], b[3], b[4], b[5]])

    s = np.linspace(0.0, LENGTH, 101)
    start = np.zeros((6, 101))
    start[0] = s
    found = solve_bvp(rates, ends, s, start, tol=1e-10, max_nodes=50000)
    assert found.success
    return found.y[:2, -1], found.y[4:, 0]


def cantilever(**rest):
    document = rod_document(
        length=LENGTH, radius=RADIUS, strains=["bend_y"], order=8,
        material={"young_modulus": YOUNG, "shear_modulus": 4e5, "density": 1150.0},
    )  # fmt: skip
    return document | {"gravity": [0, 0, -G]} | rest


def test_a_cantilever_in_a_current_has_the_shape_of_its_boundary_value_problem():
    current, drag, along = np.array([0.3, 0.6]), 1.2, 0.03
    fluid = WATER | {
        "current": [0.3, 0.0, 0.6], "drag_normal": drag, "drag_tangential": along,
    }  # fmt: skip
    dynamics = Dynamics(scene_of(cantilever(fluid=fluid)))
    q = equilibrium(dynamics)
    tip, base = bent_in(current, drag, along, (1000.0 - 1150.0) * np.pi * RADIUS**2 * G)
    found = dynamics.node_poses(q)[-1, :3, 3]
    assert np.abs(found[[0, 2]] - tip).max() < 1e-6 * LENGTH
    assert tip[1] > 0.2 * LENGTH
    held = dynamics.internal_wrench(q).after[0]
    np.testing.assert_allclose(held[[3, 5]], base, rtol=1e-6)
    # and the arm that moves comes to rest there
    swinging = Simulation(scene_of(cantilever(fluid=fluid, initial={"state": "equilibrium"})))
    swinging.advance(50)
    assert np.abs((swinging.q - q) * dynamics.model.weight).max() < 1e-9


def tapered(**rest):
    """A stiff tapered rod that points up and aside, clamped."""
    document = rod_document(
        length=LENGTH, radius=[0.03, 0.008], order=4,
        material={"young_modulus": 1e12, "shear_modulus": 4e11, "density": 700.0},
    )  # fmt: skip
    document["base"] = {"position": [0.1, 0.2, -3.0], "rpy": [0.0, -0.6, 0.4]}
    return document | {"gravity": [0, 0, -G], "fluid": WATER | {"surface": 1.5}} | rest


def reaction(document):
    """Return the wrench on a clamped rod at its base, along world axes."""
    dynamics = Dynamics(scene_of(document))
    turn = dynamics.node_poses(np.zeros(dynamics.n))[0, :3, :3]
    wrench = dynamics.internal_wrench(np.zeros(dynamics.n)).before[0]
    return -turn @ wrench[:3], -turn @ wrench[3:], turn[:, 0]


def radius(s):
    return 0.03 + (0.008 - 0.03) * s / LENGTH


def test_buoyancy_of_a_tapered_rod_is_the_weight_of_what_it_displaces():
    moment, force, axis = reaction(tapered())
    lift = (1000.0 - 700.0) * G * np.pi
    volume = lift * quad(lambda s: radius(s) ** 2, 0.0, LENGTH, epsabs=1e-14)[0]
    arm = lift * quad(lambda s: s * radius(s) ** 2, 0.0, LENGTH, epsabs=1e-14)[0]
    np.testing.assert_allclose(force, [0, 0, -volume], atol=1e-10 * volume)
    np.testing.assert_allclose(moment, -np.cross(axis, [0, 0, arm]), atol=1e-10 * arm)


@pytest.mark.parametrize("dry", [["end"], ["start"], ["start", "end"]])
def test_an_end_without_pressure_lacks_what_the_water_presses_with_on_it(dry):
    """Against the pressure on the wetted surface, summed up over rings of the cone."""
    document = tapered()
    document["bodies"][0]["fluid"] = {"dry_ends": dry}
    _, force, axis = reaction(document)
    up = np.array([0.0, 0.0, 1.0])
    begin = np.array([0.1, 0.2, -3.0])
    slope = (0.008 - 0.03) / LENGTH
    side = np.cross(up, axis) / np.linalg.norm(np.cross(up, axis))
    other = np.cross(axis, side)

    def pressure(x):
        return 1000.0 * G * (1.5 - x[2])

    angles = 2.0 * np.pi * (np.arange(16) + 0.5) / 16
    x, w = np.polynomial.legendre.leggauss(12)
    water = np.zeros(3)
    for s, ds in zip(LENGTH * (1 + x) / 2, LENGTH * w / 2, strict=True):
        for angle in angles:
            out = np.cos(angle) * side + np.sin(angle) * other
            place = begin + s * axis + radius(s) * out
            # of a cone: outwards, and forwards as it gets thinner
            water -= pressure(place) * (out - slope * axis) * radius(s) * np.pi / 8 * ds
    if "start" not in dry:
        water += pressure(begin) * np.pi * radius(0.0) ** 2 * axis
    if "end" not in dry:
        tip = begin + LENGTH * axis
        water -= pressure(tip) * np.pi * radius(LENGTH) ** 2 * axis
    weight = 700.0 * G * np.pi * quad(lambda s: radius(s) ** 2, 0.0, LENGTH)[0]
    np.testing.assert_allclose(force, weight * up - water, atol=1e-9 * np.abs(water).max())


def test_two_rods_end_to_end_have_the_buoyancy_of_one():
    """What one end presses with, the other takes back; a step is a ring of what is left."""
    one = tapered()
    section = one["bodies"][0]["sections"][0]
    halves = [
        {"rod": f"half{i}", "sections": [section | {"length": LENGTH / 2, "cross_section": {
            "shape": "circle", "radius": pair}}]}
        for i, pair in enumerate(([0.03, 0.019], [0.019, 0.008]))
    ]  # fmt: skip
    two = one | {"bodies": halves, "numerics": {"basis": {"order": 4}}}
    for found, expected in zip(reaction(two), reaction(one), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("added", [1.0, 0.6])
def test_frequencies_in_water_fall_by_the_root_of_the_masses(added):
    """√(ρ/(ρ + B ρ_f)), of every mode of a beam whose sections have no rotary inertia."""
    document = rod_document(
        length=LENGTH, radius=RADIUS, strains=["bend_z"], order=6, material={"density": 1200.0}
    )
    document["bodies"][0]["model"] = "euler_bernoulli"
    dry = Dynamics(scene_of(document))
    wet = Dynamics(scene_of(document | {"fluid": WATER | {"added_mass": added}}))
    ratio = modes(wet, np.zeros(wet.n))[0] / modes(dry, np.zeros(dry.n))[0]
    np.testing.assert_allclose(ratio, np.sqrt(1200.0 / (1200.0 + added * 1000.0)), rtol=1e-9)


def test_small_swings_in_a_current_are_damped_by_it():
    """About rest in a flow u across: drag ½ρdC(u² + 2uv + …), so a rate of ρdCu per velocity."""
    u, drag = 1e-3, 1.3
    document = rod_document(
        length=LENGTH, radius=RADIUS, strains=["bend_z"], order=6, material={"density": 1200.0}
    )
    document["bodies"][0]["model"] = "euler_bernoulli"
    fluid = WATER | {"current": [0.0, u, 0.0], "drag_normal": drag}
    dynamics = Dynamics(scene_of(document | {"fluid": fluid}))
    q = equilibrium(dynamics, check=False)
    mass = (1200.0 + 1000.0) * np.pi * RADIUS**2
    expected = -0.5 * 1000.0 * 2 * RADIUS * drag * u / mass
    found = complex_modes(dynamics, q).values
    np.testing.assert_allclose(found.real[:3], expected, rtol=1e-4)
    flow = np.linalg.eigvals(linearise(dynamics, q).A)
    slowest = flow[np.argsort(np.abs(flow))[:4]]
    np.testing.assert_allclose(slowest.real, expected, rtol=1e-3)


def test_a_buoyant_rod_stands_on_its_foot_up_to_the_length_at_which_weight_would_buckle_it():
    """Greenhill's (ρ_f − ρ) g A L³/EI = 7.837, upside down: a light rod clamped at the top."""
    area, stiff = np.pi * RADIUS**2, YOUNG * np.pi * RADIUS**4 / 4
    for factor, stands in ((0.98, True), (1.02, False)):
        lift = 7.8373 * stiff / LENGTH**3 / (area * G) * factor
        document = cantilever(fluid={"density": 800.0 + lift})
        document["materials"]["soft"]["density"] = 800.0
        document["base"] = {"rpy": [0.0, np.pi / 2, 0.0]}
        dynamics = Dynamics(scene_of(document))
        zero = np.zeros(dynamics.n)
        stiffness = dynamics.tangents(zero, zero, zero)[0]
        assert (np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0] > 0.0) == stands


def test_what_the_fluid_does_not_touch_is_as_dry_as_without_it():
    document = rod_document(order=2, gravity=(0, 0, -G))
    dry = Dynamics(scene_of(document))
    for where in ("rod", "section"):
        wet = document | {"fluid": WATER | {"current": [0.1, 0.2, 0.3]}}
        body = document["bodies"][0]
        section = body["sections"][0]
        own = body | {"fluid": "none"} if where == "rod" else body | {
            "sections": [section | {"fluid": "none"}]}  # fmt: skip
        dynamics = Dynamics(scene_of(wet | {"bodies": [own]}))
        assert isinstance(dynamics.compiled.scene.bodies[0], Rod)
        assert len(dynamics.model.fluid.node) == 0
        state = np.random.default_rng(1).normal(size=(3, dry.n)) * 0.1
        assert (dynamics.inverse_dynamics(*state) == dry.inverse_dynamics(*state)).all()


@pytest.mark.parametrize(("model", "apart"), [("string", 2e-6), ("cable", 2e-4)])
def test_a_cable_in_a_current_hangs_as_its_own_equation_says(model, apart):
    """T′ = w cos θ, T θ′ = ½ρ_f d C (u cos θ)² − w sin θ from the weight at its end upwards."""
    length, radius, drag, u, weight = 1.0, 0.005, 1.2, 0.5, 0.05 * G
    wet, push = 1000.0 * np.pi * radius**2 * G, 0.5 * 1000.0 * 2 * radius * drag

    def rate(s, y):
        _, _, tension, theta = y
        across = u * np.cos(theta)
        turn = (push * abs(across) * across - wet * np.sin(theta)) / tension
        return [np.sin(theta), np.cos(theta), wet * np.cos(theta), turn]

    own = solve_ivp(rate, (0.0, length), [0, 0, weight, 0], rtol=1e-11, atol=1e-12).y[:2, -1]
    document = rod_document(
        length=length, radius=radius, order=5,
        strains=["bend_y", "stretch"] if model == "cable" else ["bend_y"],
        material={"density": 2000.0, "young_modulus": 1e8, "shear_modulus": 4e7},
    )  # fmt: skip
    document["bodies"][0]["model"] = model
    document["bodies"].append({"rigid_body": "weight", "mass": weight / G})
    document |= {"base": {"rpy": [0.0, np.pi / 2, 0.0]}, "gravity": [0, 0, -G]}
    fluid = {"current": [u, 0, 0], "drag_normal": drag, "drag_tangential": 0.0, "added_mass": 0.0}
    dynamics = Dynamics(scene_of(document | {"fluid": WATER | fluid}))
    tip = dynamics.node_poses(equilibrium(dynamics, check=False))[-1, :3, 3]
    np.testing.assert_allclose(tip, [own[0], 0.0, -own[1]], atol=apart)


def test_a_cantilever_along_an_ideal_flow_diverges_at_the_quarter_wave():
    """EI w‴ = −ρ_f A U² w′ by Munk's moment: U L √(ρ_f A/EI) = π/2. Friction holds it longer."""
    stiff, mass = YOUNG * np.pi * RADIUS**4 / 4, 1000.0 * np.pi * RADIUS**2
    critical = 0.5 * np.pi / LENGTH * np.sqrt(stiff / mass)

    def least(speed, friction):
        fluid = WATER | {"drag_normal": 0.0, "drag_tangential": friction, "current": [speed, 0, 0]}
        document = cantilever(fluid=fluid, gravity=[0, 0, 0])
        document["materials"]["soft"]["density"] = 1000.0
        dynamics = Dynamics(scene_of(document))
        zero = np.zeros(dynamics.n)
        stiffness = dynamics.tangents(zero, zero, zero)[0]
        return np.linalg.eigvals(np.linalg.solve(dynamics.stiffness_matrix(), stiffness)).real.min()

    assert least(0.9999 * critical, 0.0) > 0.0 > least(1.0001 * critical, 0.0)
    assert least(1.0001 * critical, 0.03) > 0.0


def test_a_flooded_tube_displaces_its_wall_and_carries_the_water_inside():
    document = rod_document(length=LENGTH, strains=["bend_z"], order=6, gravity=(0, 0, -G))
    tube = {"shape": "annulus", "outer": 0.02, "inner": 0.015}
    document["bodies"][0] |= {"model": "euler_bernoulli"}
    document["bodies"][0]["sections"][0]["cross_section"] = tube
    wall, bore, outer = (np.pi * r for r in (0.02**2 - 0.015**2, 0.015**2, 0.02**2))
    dry = Dynamics(scene_of(document))
    zero = np.zeros(dry.n)
    for flooded, displaced, carried in ((False, outer, outer), (True, wall, outer + bore)):
        wet = Dynamics(scene_of(document | {"fluid": WATER | {"flooded": flooded}}))
        force = wet.internal_wrench(zero).after[0, 5]
        assert force == pytest.approx((displaced - wall) * 1000.0 * G * LENGTH, abs=1e-9)
        ratio = modes(wet, zero)[0] / modes(dry, zero)[0]
        np.testing.assert_allclose(ratio, np.sqrt(wall / (wall + carried)), rtol=1e-9)
