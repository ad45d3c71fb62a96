"""A driven joint does what it is told, and the arm feels nothing but that."""

import numpy as np
import pytest
from forests import forest_document, place, rod, section
from scenes import scene_of

from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import scipy_adapter
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0, "viscosity": 3e3}}


def carried(joint, bodies=None, **rest):
    """A rod, or other bodies, on a driven joint."""
    bodies = [rod("rod", 0.3)] if bodies is None else bodies
    return scene_of(forest_document([joint, *bodies], **({"materials": SLACK} | rest)))


def rail(course, axis=(0, 1, 0)):
    return {"joint": "rail", "kind": "prismatic", "axis": list(axis), "driven": course}


EXACT = {"newton_tolerance": 1e-15}


@pytest.mark.parametrize(
    ("integrator", "more", "apart"),
    [
        ("sdirk2", EXACT, 1e-11),
        ("sdirk4", EXACT, 1e-11),
        ("implicit_midpoint", EXACT, 1e-11),
        ("generalized_alpha", EXACT, 1e-11),
        ("adaptive", {"options": {"error": 1e-9}}, 1e-7),
    ],
)
def test_a_base_that_accelerates_is_a_tilted_gravity(integrator, more, apart):
    """To round-off: whoever rides along cannot tell one from the other."""
    numerics = {"step": 1e-3, "integrator": integrator, "basis": {"order": 2}} | more
    push = np.array([0.5, -3.0, 2.0])
    axis = push / np.linalg.norm(push)
    course = f"0.5*{float(np.linalg.norm(push))!r}*t**2"
    one = Simulation(carried(rail(course, axis), numerics=numerics))
    gravity = np.array([1.0, -2.0, -9.0]) - push
    document = forest_document([rod("rod", 0.3)], materials=SLACK, numerics=numerics)
    other = Simulation(scene_of(document | {"gravity": gravity.tolist()}))
    for simulation in (one, other):
        simulation.advance(200)
    assert np.abs(other.q).max() > 0.5
    np.testing.assert_allclose(one.q[1:], other.q, atol=apart * np.abs(other.q).max())
    assert one.q[0] == pytest.approx(0.5 * np.linalg.norm(push) * 0.2**2, rel=1e-14)
    assert one.v[0] == pytest.approx(np.linalg.norm(push) * 0.2, rel=1e-14)


def test_a_rod_carried_at_constant_velocity_keeps_its_shape():
    simulation = Simulation(carried(rail("0.1 + 2*t"), gravity=[0, 0, 0]))
    simulation.advance(500)
    assert simulation.q[0] == pytest.approx(1.1)
    assert np.abs(simulation.q[1:] * simulation.model.weight[1:]).max() < 1e-12


def shaken(length, radius, young, density, tau, omega):
    """Tip over base, (cosh b + cos b)/(1 + cosh b cos b), b⁴ = ρA ω² L⁴/(EI (1 + iωτ))."""
    stiff = young * (1 + 1j * omega * tau) * np.pi * radius**4 / 4
    b = (density * np.pi * radius**2 * omega**2 / stiff) ** 0.25 * length
    return (np.cosh(b) + np.cos(b)) / (1.0 + np.cosh(b) * np.cos(b))


def test_a_shaken_cantilever_sways_as_the_kelvin_voigt_beam():
    length, radius, young, density, tau, hertz, a = 0.5, 0.01, 5e6, 1000.0, 0.03, 1.0, 1e-5
    omega = 2.0 * np.pi * hertz
    gain = shaken(length, radius, young, density, tau, omega)
    material = {"young_modulus": young, "poisson_ratio": 0.5, "density": density}
    beam = {
        "rod": "rod",
        "model": "euler_bernoulli",
        "strains": ["bend_z"],
        "sections": [section(length, radius)],
    }
    scene = carried(
        rail(f"{a!r}*sin(2*pi*{hertz!r}*t)*tanh(t)**3"),
        [beam],
        gravity=[0, 0, 0],
        materials={"soft": material | {"viscosity": tau * young / 3}},
        numerics={"integrator": "sdirk4", "step": 4e-3, "basis": {"order": 6}} | EXACT,
    )
    simulation = Simulation(scene)
    tips = simulation.tips()
    simulation.advance(12500)
    times, way = [], []
    for _ in range(250):
        simulation.advance(1)
        times.append(simulation.time)
        way.append(tips.poses()[0, 1])
    waves = np.exp(1j * omega * np.array(times))
    basis = np.stack([waves.real, waves.imag], axis=1)
    found = np.linalg.lstsq(basis, np.array(way), rcond=None)[0]
    assert abs(gain - 1.0) > 0.5
    # Im(gain a e^{iωt}) = a (Im gain cos + Re gain sin)
    np.testing.assert_allclose(found / a, [gain.imag, gain.real], atol=1e-6 * abs(gain))


@pytest.mark.parametrize("integrator", ["sdirk4", "adaptive"])
def test_driven_motion_is_that_of_an_integrator_of_others(integrator):
    """A tree on a driven universal joint and a driven wrist against scipy's Radau."""
    courses = {"first": "0.4*sin(7*t)", "second": {"table": [[0, 0], [0.1, 0.3], [0.2, 0]]}}
    shoulder = {"joint": "shoulder", "kind": "universal", "axes": [[0, 1, 0], [0, 0, 1]],
                "driven": courses}  # fmt: skip
    wrist = {"joint": "wrist", "kind": "revolute", "axis": [0, 0, 1], "parent": place("rod", 0.2),
             "driven": "1 - cos(9*t)"}  # fmt: skip
    bodies = [rod("rod", 0.3), wrist, rod("side", 0.15)]
    numerics = {"step": 1e-3, "integrator": integrator, "basis": {"order": 1}}
    if integrator == "adaptive":
        numerics["options"] = {"error": 1e-8}
    scene = carried(shoulder, bodies, numerics=numerics)
    simulation = Simulation(scene)
    start = simulation.q.copy(), simulation.v.copy()
    simulation.advance(150)
    q, v = scipy_adapter.solve(Dynamics(scene), np.array([0.0, 0.15]), *start, rtol=1e-9)
    weight = Dynamics(scene).model.weight
    assert np.abs(simulation.q - start[0]).max() > 0.1
    assert np.abs((simulation.q - q[-1]) * weight).max() < 2e-6
    assert np.abs((simulation.v - v[-1]) * weight).max() < 2e-4


def test_the_work_of_drives_closes_the_ledger():
    joint = rail("0.05*(1 - cos(20*t))")
    simulation = Simulation(carried(joint, numerics={"step": 5e-4, "integrator": "sdirk4",
                                                     "basis": {"order": 2}}))  # fmt: skip
    simulation.advance(400)
    work, lost, residual = simulation.ledger()[4:]
    assert abs(work) > 0.01
    assert lost > 1e-3
    assert abs(residual) < 1e-6 * (abs(work) + lost)


def test_what_a_drive_gives_is_what_newton_asks_for():
    """Force on the rail = rate of the momentum along it, less weight; by differences."""
    dynamics = Dynamics(carried(rail("0.1*sin(5*t)"), materials={"soft": SLACK["soft"]}))
    rng = np.random.default_rng(3)
    time, h = 0.3, 1e-4
    q, v = 0.1 * rng.normal(size=(2, dynamics.n)) / dynamics.model.weight
    told = dynamics.guided(time)
    q[0], v[0] = told[0][0], told[1][0]
    a = dynamics.forward_dynamics(q, v, time=time)
    assert a[0] == told[2][0]

    def pushed(t):
        return dynamics.momentum(q + t * v, v + t * a)[4]

    rate = (8 * (pushed(h) - pushed(-h)) - (pushed(2 * h) - pushed(-2 * h))) / (12 * h)
    weight = -2.0 * dynamics.model.inertia[:, 0].sum()
    force = dynamics.drive_forces(q, v, time=time)
    assert force[0] == pytest.approx(rate - weight, rel=1e-7)


def test_an_arm_on_a_turning_table_rests_where_the_centrifugal_force_holds_it():
    """A rigid pendulum on a turning hub: tan α = ω² (r + l sin α) / g."""
    omega, r, length, g = 5.0, 0.2, 0.3, 9.81
    table = {"joint": "table", "kind": "revolute", "axis": [0, 0, 1], "driven": f"{omega}*t"}
    down = {"position": [r, 0, 0], "rpy": [0, np.pi / 2, 0]}
    hinge = {"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0], "offset": down}
    bob = {"rigid_body": "bob", "mass": 0.4, "com": {"position": [length, 0, 0]}}
    scene = scene_of(forest_document([table, hinge, bob], gravity=[0, 0, -g], numerics={}))
    dynamics = Dynamics(scene)
    q = equilibrium(dynamics, np.array([0.0, -0.5]), time=0.7)
    alpha = -q[1]
    assert 0.3 < alpha < 1.3
    assert np.tan(alpha) == pytest.approx(omega**2 * (r + length * np.sin(alpha)) / g, rel=1e-9)
    # small swings: Ω² = g/(l cos α) … − ω² cos² α …, of the effective potential
    stiff = (
        g * np.cos(alpha) / length
        + omega**2 * (r + length * np.sin(alpha)) * np.sin(alpha) / length
    )
    stiff -= omega**2 * np.cos(alpha) ** 2
    swing = abs(complex_modes(dynamics, q, time=0.7).values[0])
    assert swing == pytest.approx(np.sqrt(stiff), rel=1e-6)


def test_a_free_joint_that_is_driven_carries_the_arm():
    """A moving base: the same as an arm on the joints that make that motion up."""
    course = {"x": "0.1*t**2", "z": "0.2*t", "rz": "sin(3*t)"}
    base = {"joint": "base", "kind": "free", "driven": course}
    apart = [
        {"joint": "x", "kind": "prismatic", "axis": [1, 0, 0], "driven": course["x"]},
        {"joint": "z", "kind": "prismatic", "axis": [0, 0, 1], "driven": course["z"]},
        {"joint": "rz", "kind": "revolute", "axis": [0, 0, 1], "driven": course["rz"]},
    ]
    one = Simulation(carried(base))
    other = Simulation(carried(apart[0], [*apart[1:], rod("rod", 0.3)]))
    for simulation in (one, other):
        simulation.advance(200)
    np.testing.assert_allclose(one.q[6:], other.q[3:], atol=1e-8)
    np.testing.assert_allclose(one.tips().poses(), other.tips().poses(), atol=1e-9)


@pytest.mark.parametrize(
    ("course", "says"),
    [
        ("sin(x)", "'x' is not among t, pi"),
        ("sqrt(t)", "a rate and an acceleration at t = 0"),
        ("1/t", "a number at every time"),
        ({"table": [[0, 1]]}, "at least two rows"),
        ({"table": [[0, 1], [0, 2]]}, "times rising"),
        ({"tables": [[0, 1], [0, 2]]}, "formula"),
    ],
)
def test_courses_that_cannot_be_followed_are_refused(course, says):
    with pytest.raises(SceneError, match="driven") as error:
        Simulation(carried(rail(course)))
    assert says in str(error.value)


def test_what_would_have_no_effect_on_a_driven_joint_is_refused():
    joint = {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1], "driven": "t"}
    motor = {"joint_torque": "motor", "joint": "hinge"}
    with pytest.raises(SceneError, match="not driven"):
        carried(joint, actuators=[motor])
    with pytest.raises(SceneError, match="initial"):
        carried(joint, initial={"positions": {"hinge": 1.0}})
    with pytest.raises(SceneError, match="another integrator"):
        Simulation(carried(joint, numerics={"integrator": "energy_midpoint"}))


def test_a_driven_joint_is_where_it_is_told_at_every_step():
    simulation = Simulation(carried(rail({"table": [[0.0, 0.0], [0.05, 0.1], [0.1, -0.1]]})))
    spline = simulation.scene.bodies[0].driven[0]
    assert spline.switches == (0.0, 0.1)
    seen = {}
    for step in range(1, 121):
        simulation.advance(1)
        seen[step] = simulation.q[0]
    assert seen[50] == pytest.approx(0.1, abs=1e-15)
    assert seen[100] == seen[120] == pytest.approx(-0.1, abs=1e-15)
    rates = np.diff(list(seen.values())) / 1e-3
    dynamics = simulation.dynamics
    most = max(abs(dynamics.guided(t)[2][0]) for t in np.linspace(0.0, 0.1, 201))
    assert np.abs(np.diff(rates)).max() < 1.01e-3 * most  # no jumps of the rate


def test_a_reset_arm_is_carried_on_from_where_its_drive_is_now():
    simulation = Simulation(carried(rail("0.3*t + 0.1*t**2")))
    simulation.advance(100)
    simulation.reset()
    assert simulation.q[0] == pytest.approx(0.3 * 0.1 + 0.1 * 0.1**2)
    assert simulation.v[0] == pytest.approx(0.3 + 0.2 * 0.1)
    assert not simulation.q[1:].any()
    assert simulation.ledger()[-1] == pytest.approx(0.0, abs=1e-15)


def test_a_state_of_a_driven_arm_goes_on_with_the_same_bits():
    one, other = (Simulation(carried(rail("0.1*sin(9*t)"))) for _ in range(2))
    one.advance(50)
    other.restore(one.state())
    for simulation in (one, other):
        simulation.advance(70)
    np.testing.assert_array_equal(one.q, other.q)
    np.testing.assert_array_equal(one.ledger(), other.ledger())
