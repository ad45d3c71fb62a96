"""Bodies that move in a fluid, against closed forms and equations integrated by scipy."""

import numpy as np
import pytest
from scenes import rod_document, scene_of
from scipy.integrate import solve_ivp
from waters import WATER, body, floating, simulation

from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene import load_scene
from soft_sim_ros.scene.fluid import ellipsoid

G = 9.81
STIFF = {"young_modulus": 1e9, "shear_modulus": 4e8}


def rod_in_water(density, radius=0.01, **rest):
    document = rod_document(
        radius=radius, strains=["bend_y", "stretch"], order=2, material=STIFF | {"density": density}
    )
    return floating(document["bodies"], materials=document["materials"], **rest)


def test_a_horizontal_rod_sinks_as_its_own_equation_says():
    """Its speed at last is √(2 (ρ − ρ_f) g A / (ρ_f C d)): 0.23672 m/s."""
    rho, fluid, d, drag = 1200.0, 1000.0, 0.02, 1.1
    area = np.pi * d**2 / 4
    sinking = simulation(rod_in_water(rho, gravity=[0, 0, -G]), 2e-3)

    def rate(t, v):
        push = (rho - fluid) * area * G - 0.5 * fluid * d * drag * np.abs(v) * v
        return push / ((rho + fluid) * area)

    own = solve_ivp(rate, (0.0, 0.1), [0.0], rtol=1e-12, atol=1e-14).y[0, -1]
    sinking.advance(50)
    assert -sinking.v[5] == pytest.approx(own, rel=1e-8)
    sinking.advance(1200)
    assert -sinking.v[5] == pytest.approx(0.23672, rel=2e-5)
    end = np.sqrt(2.0 * (rho - fluid) * G * area / (fluid * drag * d))
    assert -sinking.v[5] == pytest.approx(end, rel=2e-8)
    ledger = sinking.ledger()
    assert abs(ledger[6]) < 1e-9 * ledger[5] and ledger[4] == 0.0


def test_a_rod_as_dense_as_the_fluid_stays_where_it_is():
    """Upside down, tapered, turned: weight and buoyancy cancel at every node."""
    document = rod_in_water(1000.0, radius=[0.02, 0.005], gravity=[3.0, -2.0, -9.0])
    document["base"] = {"position": [0.1, -0.2, 0.3], "rpy": [0.4, -0.7, 1.9]}
    at_rest = simulation(document, 5e-3)
    at_rest.advance(400)
    weight = 1000.0 * np.pi * 0.01**2 * 0.6 * G
    assert np.abs(at_rest.v * at_rest.model.weight).max() < 1e-13 * weight
    assert np.abs(at_rest.q * at_rest.model.weight).max() < 1e-12


def test_a_sphere_slows_down_as_morison_says():
    """v₀/(1 + k v₀ t), k = ½ρ_f C A/(m + ½ρ_f V): nothing keeps its momentum up."""
    radius, mass, drag, v0 = 0.1, 3.0, 0.5, 2.0
    document = floating([body(mass, [0.01] * 3, radius=radius, drag=drag)])
    document["initial"] = {"velocities": {"float": [0, 0, 0, v0, 0, 0]}}
    moving = simulation(document, 2e-3)
    k = 0.5 * 1000.0 * drag * np.pi * radius**2 / (mass + 0.5 * 1000.0 * 4 / 3 * np.pi * radius**3)
    for _ in range(3):
        moving.advance(200)
        t = moving.time
        assert moving.v[3] == pytest.approx(v0 / (1.0 + k * v0 * t), rel=1e-9)
        assert moving.q[3] == pytest.approx(np.log1p(k * v0 * t) / k, rel=1e-9)


def test_a_small_sphere_slows_down_as_stokes_says():
    mass, viscous, v0 = 0.5, 3.0, 1.0
    document = floating([body(mass, [0.01] * 3, volume=0.0, viscous=viscous)])
    document["initial"] = {"velocities": {"float": [0, 0, 0, 0, v0, 0]}}
    moving = simulation(document, 2e-3)
    moving.advance(100)
    assert moving.v[4] == pytest.approx(v0 * np.exp(-viscous / mass * 0.2), rel=1e-9)


def kirchhoff(mass, inertia, v, w, end):
    """Velocity, spin (3,) and orientation (3, 3) at ``end`` s of a body in an ideal fluid."""

    def rate(t, y):
        v, w, turn = y[:3], y[3:6], y[6:].reshape(3, 3)
        push, spin = mass * v, inertia * w
        wx = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        dv = np.cross(push, w) / mass
        dw = (np.cross(spin, w) + np.cross(push, v)) / inertia
        return np.concatenate([dv, dw, (turn @ wx).ravel()])

    start = np.concatenate([v, w, np.eye(3).ravel()])
    y = solve_ivp(rate, (0.0, end), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    return y[:3], y[3:6], y[6:].reshape(3, 3)


def test_a_free_ellipsoid_moves_by_kirchhoff_s_equations():
    axes, mass, own = np.array([0.2, 0.1, 0.06]), 2.0, np.array([0.03, 0.05, 0.06])
    _, _, added, turned = ellipsoid(axes)
    v, w = np.array([1.0, 0.3, -0.2]), np.array([0.5, -1.0, 2.0])
    document = floating([body(mass, own, semi_axes=axes.tolist())])
    document["initial"] = {"velocities": {"float": [*w, *v]}}
    moving = simulation(document, 1e-3, newton_tolerance=1e-13)
    moving.advance(1000)
    found = Dynamics(moving.compiled)
    twist = found.node_twists(moving.q, moving.v)[-1]
    speed, spin, turn = kirchhoff(mass + 1000.0 * added, own + 1000.0 * turned, v, w, 1.0)
    np.testing.assert_allclose(twist[3:], speed, atol=1e-7)
    np.testing.assert_allclose(twist[:3], spin, atol=1e-7)
    np.testing.assert_allclose(found.node_poses(moving.q)[-1, :3, :3], turn, atol=1e-7)
    assert np.abs(twist - np.concatenate([w, v])).max() > 0.5
    energy = moving.ledger()
    assert energy[:3].sum() == pytest.approx(
        0.5 * v @ ((mass + 1000.0 * added) * v) + 0.5 * w @ ((own + 1000.0 * turned) * w), rel=1e-7
    )


def test_a_spheroid_turns_broadside_at_the_rate_of_munk_s_moment():
    """Yaw grows by cosh λt, λ² = u² M_x (M_y − M_x)/(M_y I_z); a sphere keeps its course."""
    axes, mass, own, u, yaw = np.array([0.2, 0.08, 0.08]), 5.0, 0.05, 1.0, 1e-7
    _, _, added, turned = ellipsoid(axes)
    m_x, m_y, i_z = mass + 1e3 * added[0], mass + 1e3 * added[1], own + 1e3 * turned[2]
    rate = u * np.sqrt(m_x * (m_y - m_x) / (m_y * i_z))
    steady = 3.0 / rate
    for semi, grows in ((axes, np.cosh(3.0)), (np.full(3, 0.1), 1.0)):
        document = floating([body(mass, [own] * 3, semi_axes=semi.tolist())])
        document["initial"] = {"velocities": {"float": [0, 0, 0, u, yaw, 0]}}
        moving = simulation(document, round(steady / 400, 9))
        moving.advance(400)
        twist = Dynamics(moving.compiled).node_twists(moving.q, moving.v)[-1]
        assert twist[4] == pytest.approx(yaw * grows, rel=1e-5)


def test_what_is_as_dense_as_the_fluid_moves_with_a_current_that_changes():
    """u̇ pushes it as buoyancy does, and through its added mass: v = u, whatever the drag."""
    density = 1000.0
    mass = density * 4 / 3 * np.pi * 0.2 * 0.1 * 0.06
    fluid = WATER | {"current": {"x": "0.4*sin(3*t)", "z": "0.2*t**2"}}
    hull = body(mass, [0.01] * 3, semi_axes=[0.2, 0.1, 0.06], drag=1.0)
    document = floating([hull], fluid=fluid)
    document["initial"] = {"positions": {"float": [0.3, 0.2, -0.4, 0, 0, 0]}}
    moving = simulation(document, 2e-3)
    moving.advance(300)
    t = moving.time
    turned = [0.4 * np.sin(3 * t), 0.0, 0.2 * t**2]
    np.testing.assert_allclose(moving.v[3:], turned, atol=1e-9)
    way = [0.4 / 3 * (1 - np.cos(3 * t)), 0.0, t**3 / 15]
    np.testing.assert_allclose(moving.q[3:], way, atol=1e-9)
    np.testing.assert_allclose(moving.q[:3], [0.3, 0.2, -0.4], atol=1e-9)
    assert abs(moving.ledger()[6]) < 1e-8 * abs(moving.ledger()[4])


def arm(**rest):
    document = rod_document(
        length=0.4, radius=0.01, order=2, strains=["torsion", "bend_y", "bend_z", "stretch"],
        material={"density": 1100.0, "viscosity": 1e3},
    )  # fmt: skip
    return document | {"gravity": [0.5, -1.0, -9.0]} | rest


def test_an_arm_towed_through_still_water_is_an_arm_in_a_current_the_other_way():
    """Galileo: strains agree to round-off, drag loses what the current would not give."""
    rail = {"joint": "rail", "kind": "prismatic", "axis": [0.6, 0.0, 0.8], "driven": "0.5*t"}
    towed = arm(fluid=WATER | {"lift": [0.1, 0, 0]})
    towed["bodies"] = [rail, *towed["bodies"]]
    held = arm(fluid=WATER | {"lift": [0.1, 0, 0], "current": [-0.3, 0.0, -0.4]})
    one, other = (simulation(d, 2e-3, newton_tolerance=1e-13) for d in (towed, held))
    for both in (one, other):
        both.advance(150)
    assert np.abs(other.q * other.model.weight).max() > 0.1
    np.testing.assert_allclose(one.q[1:], other.q, atol=1e-10 * np.abs(other.q).max())
    first, second = one.ledger(), other.ledger()
    assert first[5] == pytest.approx(second[5], rel=1e-9)
    assert abs(first[6]) < 1e-6 * first[5] and abs(second[6]) < 1e-6 * second[5]
    assert second[4] > 0.0


def test_a_current_from_a_table_is_that_of_its_formula():
    """Cubics between 41 rows."""
    times = np.linspace(0.0, 0.4, 41)
    rows = np.column_stack([times, 0.3 * (1 - np.cos(5 * times))])
    ends = []
    for course in ("0.3*(1 - cos(5*t))", {"table": rows.tolist()}):
        swept = simulation(arm(fluid=WATER | {"current": {"y": course}}), 2e-3)
        swept.advance(190)
        ends.append(swept.q * swept.model.weight)
    assert np.abs(ends[0] - ends[1]).max() < 3e-5
    still = simulation(arm(fluid=WATER), 2e-3)
    still.advance(190)
    assert np.abs(ends[0] - still.q * still.model.weight).max() > 1e-2


@pytest.mark.parametrize(("integrator", "order"), [("sdirk2", 2), ("sdirk4", 4)])
def test_the_ledger_closes_in_a_current_that_changes_by_the_order_of_the_method(integrator, order):
    current = {"x": "0.3*sin(9*t)", "z": "0.2*t"}
    document = arm(fluid=WATER | {"current": current, "lift": [0.2, 0.1, 0.0], "surface": 1.0})
    document["bodies"][0]["fluid"] = {"dry_ends": ["end"]}
    document["gravity"] = [0, 0, 0]
    residuals = []
    for step in (4e-3, 2e-3):
        swept = simulation(document, step, integrator=integrator)
        swept.advance(round(0.2 / step))
        work, lost, residual = swept.ledger()[4:]
        residuals.append(abs(residual) / (abs(work) + lost))
    assert abs(work) > 1e-4
    assert residuals[1] < 1.2 * residuals[0] / 2**order
    assert residuals[1] < {2: 2e-4, 4: 2e-6}[order]


@pytest.mark.parametrize("seed", range(6))
def test_in_still_water_energy_only_falls(seed):
    """Whatever the arm, its coefficients and how it is let go; nothing comes from nowhere."""
    rng = np.random.default_rng(seed)
    density = rng.uniform(500.0, 2000.0)
    document = arm(gravity=(rng.normal(size=3) * 5).tolist())
    document["materials"]["soft"] |= {"density": density, "viscosity": 0.0}
    document["bodies"] += [
        body(0.1, [1e-4] * 3, semi_axes=rng.uniform(0.02, 0.06, 3).tolist(), drag=rng.uniform(0, 2),
             rotary_drag=rng.uniform(0, 1e-3), lift=rng.normal(size=3).tolist())
    ]  # fmt: skip
    document["fluid"] = {
        "density": float(rng.uniform(1.0, 1500.0)),
        "drag_normal": rng.uniform(0.0, 2.0, 2).tolist(),
        "drag_tangential": float(rng.uniform(0.0, 0.1)),
        "viscous_normal": float(rng.choice([0.0, rng.uniform(0.0, 1.0)])),
        "lift": rng.normal(size=3).tolist(),
        "added_mass": rng.uniform(0.0, 2.0, 2).tolist(),
        "drag_law": str(rng.choice(["split", "whole"])),
    }
    strains = {"bend_y": float(rng.normal()), "bend_z": float(rng.normal())}
    document["initial"] = {"strains": {"rod/s": strains}}
    falling = simulation(document, 1e-3, integrator="energy_midpoint")
    ledgers = [falling.ledger()]
    for _ in range(20):
        falling.advance(10)
        ledgers.append(falling.ledger())
    ledgers = np.array(ledgers)
    stored, lost = ledgers[:, :3].sum(axis=1), ledgers[:, 5]
    assert (ledgers[:, 4] == 0.0).all()
    assert (np.diff(lost) > 0.0).all()
    assert (np.diff(stored) < 1e-9 * np.ptp(ledgers[:, 0])).all()
    assert lost[-1] > 1e-3 * np.ptp(ledgers[:, 0])


def test_a_run_in_water_has_the_same_bits_when_it_is_cut_and_taken_up_again():
    document = arm(fluid=WATER | {"current": {"x": "0.3*sin(9*t)"}})
    one, other = simulation(document, 2e-3), simulation(document, 2e-3)
    one.advance(60)
    other.advance(25)
    kept = other.state()
    third = Simulation(scene_of(document | {"numerics": document["numerics"] | {
        "step": 2e-3, "integrator": "sdirk4"}}))  # fmt: skip
    third.restore(kept)
    third.advance(35)
    assert (third.q == one.q).all() and (third.ledger() == one.ledger()).all()


def test_the_packaged_fish_swims_ahead_and_turns_where_it_is_steered():
    """Nothing pushes it but the water: what its motor gives is stored or lost."""
    ways = []
    for steer in (0.0, 0.03, -0.03):
        fish = Simulation(load_scene("swimmer"))
        fish.set_efforts(np.array([steer]))
        fish.advance(1200)
        ways.append(fish.q[:6].copy())
        work, loads, lost, residual = fish.ledger()[3:]
        assert abs(residual) < 1e-4 * lost
        assert 0.9 * (work + loads) < lost < work + loads
    straight, left, right = ways
    assert straight[3] < -0.7 and abs(straight[4]) < 0.01
    assert left[4] > 0.2 and right[4] < -0.2  # m aside
