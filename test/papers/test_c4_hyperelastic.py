"""C-4: hyperelastic sections against closed forms, quadrature and an independent BVP."""

from __future__ import annotations

import numpy as np
import pytest
from differences import central_difference
from scenes import random_state, rod_document, scene_of
from scipy.integrate import quad, solve_bvp
from scipy.optimize import brentq, root

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import Diverged, SceneError, StaticsFailed
from soft_sim_ros.scene import register_law
from soft_sim_ros.scene.law import Rivlin

NEO = {"kind": "neo_hookean", "c10": 1e5}
MOONEY = {"kind": "mooney_rivlin", "c10": 6e4, "c01": 4e4}
YEOH = {"kind": "yeoh", "c10": 1e5, "c20": -4e3, "c30": 3e2}
STRETCHES = np.concatenate([np.linspace(0.1, 0.95, 18), [1.0], np.linspace(1.05, 4.0, 60)])
TABLE = {
    "kind": "table",
    "stretch": STRETCHES,
    "stress": 2e5 * (STRETCHES - STRETCHES**-2),
}
LAWS = {"neo": NEO, "mooney": MOONEY, "yeoh": YEOH, "table": TABLE}
RADIUS, LENGTH = 0.02, 0.3
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4


def document(law, **options):
    """Return the document of a rod of hyperelastic material along x."""
    extra = options.pop("extra", {})
    result = rod_document(**({"length": LENGTH, "radius": RADIUS, "order": 2} | options))
    result["materials"]["soft"] = {"law": law, "density": 1000.0} | extra
    return result


def rubber(law, **options):
    """Return the dynamics of such a rod."""
    return Dynamics(scene_of(document(law, **options)))


def invariants(stretch, shear=0.0):
    """Return I₁ − 3, I₂ − 3 from the deformation gradient of a fibre, column by column."""
    width = 1.0 / np.sqrt(stretch)
    gradient = np.array([[stretch, 0.0, 0.0], [width * shear, width, 0.0], [0.0, 0.0, width]])
    left = gradient @ gradient.T
    first = np.trace(left)
    return first - 3.0, 0.5 * (first**2 - np.trace(left @ left)) - 3.0


def energy_of(law):
    """Return w(λ, γ) of a law of Rivlin's series, from its definition."""

    def energy(stretch, shear=0.0):
        first, second = invariants(stretch, shear)
        return (
            law["c10"] * first
            + law.get("c01", 0.0) * second
            + law.get("c20", 0.0) * first**2
            + law.get("c30", 0.0) * first**3
        )

    return energy


def derivative(function, x, size=1e-3):
    """Return a sixth-order difference quotient."""
    offsets, weights = np.array([1, 2, 3]), np.array([45, -9, 1]) / 60.0
    pairs = [function(x + size * o) - function(x - size * o) for o in offsets]
    return float(np.dot(weights, pairs)) / size


def coordinate(dynamics, name):
    """Return the index of the constant part of a strain."""
    return next(
        i for i, label in enumerate(dynamics.compiled.coordinate_names) if f"{name}/0" in label
    )


def uniform(dynamics, **strains):
    """Return q of strains (offsets from the reference) that are constant along the rod."""
    q = np.zeros(dynamics.n)
    for name, value in strains.items():
        q[coordinate(dynamics, name)] = value
    return q


# -- a potential, and its exact derivatives ------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seed", range(2))
def test_force_and_tangent_are_the_derivatives_of_one_energy(name, seed):
    section = {
        "cross_section": {"shape": "ellipse", "semi_axis_y": [0.03, 0.025], "semi_axis_z": 0.02},
        "reference": {"curvature": [1.0, [0.0, 2.0], -1.0]},
    }
    dynamics = rubber(LAWS[name], section=section, length=0.6, extra={"viscosity": 300.0})
    q, v, a = random_state(dynamics, seed)
    zero = np.zeros(dynamics.n)
    force, stiffness = dynamics.elastic_force(q), dynamics.stiffness_matrix(q)
    units = np.sqrt(np.diag(stiffness))
    size = 1e-4 / dynamics.model.weight

    def energy(x):
        return np.array([dynamics.energies(x, zero)[1]])

    error = (force - central_difference(energy, q, size)[0]) / units
    assert np.max(np.abs(error)) < 1e-9 * np.max(np.abs(force) / units)
    for function, exact in (
        (dynamics.elastic_force, stiffness),
        (lambda x: dynamics.inverse_dynamics(x, v, a), dynamics.tangents(q, v, a)[0]),
    ):
        error = (exact - central_difference(function, q, size)) / np.outer(units, units)
        assert np.max(np.abs(error)) < 1e-7
    assert np.max(np.abs(stiffness - stiffness.T) / np.outer(units, units)) < 1e-14


@pytest.mark.parametrize("name", LAWS)
def test_small_strains_see_the_linear_law_with_a_young_modulus_of_three_shear_moduli(name):
    law = LAWS[name]
    dynamics = rubber(law)
    shear = 2.0 * (law["c10"] + law.get("c01", 0.0)) if "c10" in law else 2e5
    moduli = {"young_modulus": 3.0 * shear, "shear_modulus": shear}
    linear = Dynamics(
        scene_of(rod_document(length=LENGTH, radius=RADIUS, order=2, material=moduli))
    )
    exact = 1e-12 if "c10" in law else 0.02  # a table of 5 % steps knows its slope that well
    scale = np.sqrt(np.diag(linear.stiffness_matrix()))
    difference = (dynamics.stiffness_matrix() - linear.stiffness_matrix()) / np.outer(scale, scale)
    assert np.abs(difference).max() < exact


@pytest.mark.parametrize(("strain", "order"), [("stretch", 1), ("bend_y", 2)])
@pytest.mark.parametrize("law", [NEO, MOONEY, YEOH])
def test_departure_from_the_linear_law_vanishes_with_its_order(strain, order, law):
    # first order under stretch; bending, which is odd, departs with its square
    dynamics = rubber(law, strains=["bend_y", "bend_z", "stretch"])
    at = coordinate(dynamics, strain)
    rigid = dynamics.stiffness_matrix()[at, at]
    lever = 1.0 if strain == "stretch" else RADIUS
    amounts = np.array([0.04, 0.02, 0.01])
    excess = [
        abs(dynamics.elastic_force(uniform(dynamics, **{strain: x / lever}))[at])
        / (rigid * x / lever) - 1.0
        for x in amounts
    ]  # fmt: skip
    slope = np.polyfit(np.log(amounts), np.log(np.abs(excess)), 1)[0]
    assert slope == pytest.approx(order, abs=0.1)


# -- closed forms ----------------------------------------------------------------------------------


@pytest.mark.parametrize("force", [-200.0, 40.0, 200.0])
@pytest.mark.parametrize("law", [NEO, MOONEY, YEOH])
def test_pulled_rod_stretches_until_its_stress_balances(law, force):
    dynamics = rubber(law, strains=["stretch"], order=0)
    q = equilibrium(dynamics, tip=np.array([0, 0, 0, force, 0, 0]))
    energy = energy_of(law)
    stretch = brentq(lambda x: AREA * derivative(energy, x, 1e-3 * x) - force, 0.4, 6.0, xtol=1e-12)
    assert 1.0 + q[0] == pytest.approx(stretch, abs=1e-7)
    assert abs(stretch - 1.0 - force / (6.0 * (law["c10"] + law.get("c01", 0.0)) * AREA)) > 1e-3


@pytest.mark.parametrize("law", [NEO, MOONEY])
def test_stretched_and_twisted_cylinder_obeys_rivlin(law):
    # Rivlin 1949: torque and axial force of an incompressible cylinder, stretched by λ and twisted
    # by K per reference length
    dynamics = rubber(law, strains=["torsion", "stretch"], order=0)
    c10, c01 = law["c10"], law.get("c01", 0.0)
    polar = np.pi * RADIUS**4 / 2
    for stretch, twist in ((1.0, 30.0), (1.6, 20.0), (0.7, -40.0)):
        force = dynamics.elastic_force(uniform(dynamics, torsion=twist, stretch=stretch - 1.0))
        torque = 2.0 * polar * twist * (c10 / stretch + c01 / stretch**2)
        pull = 2.0 * AREA * (stretch - stretch**-2) * (c10 + c01 / stretch)
        pull -= polar * twist**2 * (c10 / stretch**2 + 2.0 * c01 / stretch**3)
        np.testing.assert_allclose(force / LENGTH, [torque, pull], rtol=1e-12)


def test_twisted_rubber_gets_longer():
    # Poynting's effect, to lowest order ε = (K R)²/12 for a neo-Hookean cylinder without pull
    dynamics = rubber(NEO, strains=["torsion", "stretch"], order=0)
    for torque in (0.1, 0.2):
        q = equilibrium(dynamics, tip=np.array([torque, 0, 0, 0, 0, 0]))
        assert q[1] == pytest.approx((q[0] * RADIUS) ** 2 / 12.0, rel=3.0 * q[1])


@pytest.mark.parametrize("law", [NEO, MOONEY, YEOH])
def test_stretched_rod_bends_with_its_tangent_modulus_and_its_thinner_section(law):
    dynamics = rubber(law, strains=["bend_y", "stretch"], order=0)
    energy = energy_of(law)
    for stretch in (0.7, 1.0, 1.8):
        slope = derivative(lambda x: derivative(energy, x), stretch)
        matrix = dynamics.stiffness_matrix(uniform(dynamics, stretch=stretch - 1.0)) / LENGTH
        assert matrix[0, 0] == pytest.approx(slope * INERTIA / stretch, rel=1e-6)
        assert matrix[1, 1] == pytest.approx(slope * AREA, rel=1e-6)
        assert abs(matrix[0, 1]) < 1e-12 * np.sqrt(matrix[0, 0] * matrix[1, 1])


SHAPES = [
    ({"shape": "circle", "radius": 0.02}, lambda y: 2.0 * np.sqrt(max(0.02**2 - y * y, 0.0)), 0.02),
    (
        {"shape": "annulus", "outer": 0.02, "inner": 0.012},
        lambda y: (
            2.0 * np.sqrt(max(0.02**2 - y * y, 0.0)) - 2.0 * np.sqrt(max(0.012**2 - y * y, 0.0))
        ),
        0.02,
    ),
    ({"shape": "rectangle", "width_y": 0.05, "width_z": 0.03}, lambda y: 0.03, 0.025),
    (
        {"shape": "ellipse", "semi_axis_y": 0.03, "semi_axis_z": 0.01},
        lambda y: 0.02 * np.sqrt(max(1.0 - (y / 0.03) ** 2, 0.0)),
        0.03,
    ),
]


@pytest.mark.parametrize(("shape", "chord", "half"), SHAPES, ids=lambda x: str(x)[:20])
def test_moment_and_curvature_agree_with_the_integral_over_the_section(shape, chord, half):
    # pure bending about z at 50 % strain of the outer fibre
    dynamics = rubber(YEOH, strains=["bend_z"], order=0, section={"cross_section": shape})
    curvature = 0.5 / half
    energy = energy_of(YEOH)
    marks = [-0.012, 0.012] if shape["shape"] == "annulus" else None
    moment, _ = quad(
        lambda y: -y * derivative(energy, 1.0 - y * curvature) * chord(y),
        -half, half, points=marks, epsrel=1e-10, limit=200,
    )  # fmt: skip
    force = dynamics.elastic_force(np.array([curvature]))[0] / LENGTH
    linear = dynamics.stiffness_matrix()[0, 0] * curvature / LENGTH
    # the rule over the section is exact to degree 15; what is left is the tail of 1/λ² at 0.5
    assert force == pytest.approx(moment, rel=1e-6)
    assert abs(force / linear - 1.0) > 0.02


def test_stiffening_and_softening_in_bending_have_their_sign():
    ratios = {}
    for name, law in (("yeoh", YEOH | {"c20": 5e4}), ("soft", YEOH | {"c20": -4e4, "c30": 8e3})):
        dynamics = rubber(law, strains=["bend_z"], order=0)
        force = dynamics.elastic_force(np.array([15.0]))[0]
        ratios[name] = force / (dynamics.stiffness_matrix()[0, 0] * 15.0)
    assert ratios["yeoh"] > 1.05 and ratios["soft"] < 1.0


# -- an independent boundary-value problem ---------------------------------------------------------


def test_heavy_load_on_a_cantilever_agrees_with_an_independent_bvp():
    # planar extensible rod without shear; unknowns x, z, θ, M along s; the section law is inverted
    # by root finding on its own chord-wise quadrature
    law, load = MOONEY, np.array([6.0, -8.0])  # N along x, z at the tip
    dynamics = rubber(law, strains=["bend_y", "stretch"], order=7, nodes=24)
    q = equilibrium(dynamics, tip=np.array([0, 0, 0, load[0], 0, load[1]]))
    tip = dynamics.node_poses(q)[-1, :3, 3]

    angle = np.pi * np.arange(1, 41) / 41
    z, width = RADIUS * np.cos(angle), np.pi / 41 * 2.0 * (RADIUS * np.sin(angle)) ** 2

    def stress(stretch):
        return 2.0 * (stretch - stretch**-2) * (law["c10"] + law["c01"] / stretch)

    def section(strain):
        curvature, g = strain
        p = width * stress(g + z * curvature / np.sqrt(g))
        return np.array([
            np.sum(p * z) / np.sqrt(g), np.sum(p * (1.0 - 0.5 * z * curvature * g**-1.5))
        ])  # fmt: skip

    stiffness = 6e5 * np.array([INERTIA, AREA])

    def strain(moment, pull):
        goal = np.array([moment, pull])
        start = goal / stiffness + [0.0, 1.0]
        found = root(lambda e: (section(e) - goal) / stiffness, start, tol=1e-13)
        return found.x

    def rates(_, y):
        out = np.zeros_like(y)
        for i, (_, _, turn, moment) in enumerate(y.T):
            # rotation about +y by θ takes x to (cos θ, −sin θ) in (x, z)
            along = np.array([np.cos(turn), -np.sin(turn)])
            curvature, g = strain(moment, load @ along)
            across = np.array([np.sin(turn), np.cos(turn)])
            out[:, i] = [*(g * along), curvature, g * (load @ across)]
        return out

    def ends(a, b):
        return np.array([a[0], a[1], a[2], b[3]])

    s = np.linspace(0.0, LENGTH, 15)
    guess = np.array([s, -0.3 * s, 1.0 + 0 * s, 2.0 * (1.0 - s / LENGTH)])
    solution = solve_bvp(rates, ends, s, guess, tol=1e-6, max_nodes=400)
    assert solution.success
    np.testing.assert_allclose(tip[[0, 2]], solution.y[:2, -1], atol=2e-6 * LENGTH)

    other = document(law, strains=["bend_y", "stretch"], order=7, nodes=24)
    other["materials"]["soft"] = {"young_modulus": 6e5, "shear_modulus": 2e5, "density": 1000.0}
    linear = Dynamics(scene_of(other))
    q = equilibrium(linear, tip=np.array([0, 0, 0, load[0], 0, load[1]]))
    assert np.linalg.norm(linear.node_poses(q)[-1, :3, 3] - tip) > 5e-3 * LENGTH


# -- user-given laws -------------------------------------------------------------------------------


@pytest.mark.parametrize("given", ["stress", "energy"])
def test_registered_function_gives_the_forces_of_the_law_it_is(given):
    functions = {
        "stress": lambda x: 2.0 * (x - x**-2) * (6e4 + 4e4 / x),
        "energy": lambda x: 6e4 * (x**2 + 2.0 / x - 3.0) + 4e4 * (2.0 * x + x**-2 - 3.0),
    }
    register_law("mine", **{given: functions[given]})
    law = {"kind": "registered", "name": "mine", "stretch": [0.4, 2.5]}
    strains = ["bend_y", "bend_z", "stretch"]
    mine, known = rubber(law, strains=strains), rubber(MOONEY, strains=strains)
    q = uniform(mine, bend_y=10.0, bend_z=-5.0, stretch=0.3)
    size = np.sqrt(np.diag(known.stiffness_matrix()))
    force = known.elastic_force(q)
    error = np.max(np.abs(mine.elastic_force(q) - force) / size)
    assert error < 1e-7 * np.max(np.abs(force) / size)
    zero = np.zeros(mine.n)
    assert mine.energies(q, zero)[1] == pytest.approx(known.energies(q, zero)[1], rel=1e-7)


def test_measured_points_are_met():
    dynamics = rubber(TABLE, strains=["stretch"], order=0)
    for stretch, stress in zip(STRETCHES[2:-2:7], TABLE["stress"][2:-2:7], strict=True):
        force = dynamics.elastic_force(np.array([stretch - 1.0]))[0] / LENGTH
        assert force == pytest.approx(stress * AREA, rel=1e-12, abs=1e-9)


# -- motion, and where it ends ---------------------------------------------------------------------


def test_energy_is_conserved_by_a_swinging_rubber_band():
    drifts = []
    for step in (2e-3, 1e-3):
        scene = document(YEOH, strains=["bend_y", "stretch"], gravity=(9.0, 0.0, -9.81))
        scene["numerics"] |= {"step": step, "integrator": "implicit_midpoint"}
        scene["numerics"]["newton_tolerance"] = 1e-10  # so that only the method is seen
        simulation = Simulation(scene_of(scene))
        worst = 0.0
        for _ in range(20):
            simulation.advance(round(0.02 / step))
            ledger = simulation.ledger()
            worst = max(worst, abs(ledger[-1]) / ledger[0])
        drifts.append(worst)
    assert drifts[1] < 2e-3 and 3.0 < drifts[0] / drifts[1] < 5.5


def test_crushing_is_refused_by_name():
    with pytest.raises(StaticsFailed, match="beyond where the law"):
        equilibrium(rubber(NEO, strains=["stretch"], order=0), tip=np.array([0, 0, 0, -2e5, 0, 0]))


def test_leaving_a_measured_range_ends_the_motion_by_name():
    table = {"kind": "table", "stretch": [0.7, 0.9, 1.0, 1.1, 1.3],
             "stress": [-3e5, -7e4, 0.0, 6e4, 1.5e5]}  # fmt: skip
    scene = document(table, strains=["stretch"], order=0)
    scene["loads"] = [{"point": "pull", "body": "rod", "force": [400.0, 0.0, 0.0]}]
    simulation = Simulation(scene_of(scene))
    with pytest.raises(Diverged, match="beyond where the law"):
        simulation.advance(1000)
    assert -0.3 <= simulation.q[0] <= 0.3


def test_pull_beyond_the_largest_stress_of_a_softening_law_is_refused():
    # C (1.35) leaves 𝒦 open; where σ(λ) has a maximum no larger dead load can be carried
    law = {"kind": "yeoh", "c10": 1e5, "c20": -1e4, "c30": 0.0}
    stretch = np.linspace(1.0, 2.0, 2001)
    energy = energy_of(law)
    peak = AREA * max(derivative(energy, x) for x in stretch)
    dynamics = rubber(law, strains=["stretch"], order=0)
    tip = np.array([0, 0, 0, 0.999 * peak, 0, 0])
    assert dynamics.n == len(equilibrium(dynamics, tip=tip))
    with pytest.raises(StaticsFailed) as caught:
        equilibrium(dynamics, tip=1.01 / 0.999 * tip)
    assert caught.value.load_factor == pytest.approx(1.0 / 1.01, abs=2e-3)


SOFTENING = [
    {"kind": "mooney_rivlin", "c10": 2e5, "c01": -5e4},
    {"kind": "yeoh", "c10": 1e5, "c20": -1e4, "c30": 0.0},
]


@pytest.mark.parametrize("law", [NEO, MOONEY, YEOH, *SOFTENING])
def test_a_law_ends_where_its_own_stress_stops_rising(law):
    rivlin = Rivlin(**{key: value for key, value in law.items() if key != "kind"})
    energy = energy_of(law)

    def stress(x):
        return derivative(energy, x, 1e-3 * x)

    for stretch in (0.4, 0.8, 1.0, 1.3, 2.0):
        assert rivlin.stress(stretch) == pytest.approx(stress(stretch), rel=1e-8, abs=1e-4)
        slope = derivative(stress, stretch, 1e-3 * stretch)
        assert rivlin.slope(stretch) == pytest.approx(slope, rel=1e-5)
    ends = rivlin.span
    assert (ends == (0.05, 20.0)) == (law not in SOFTENING)
    for end, limit, beyond in zip(ends, (0.05, 20.0), (0.998, 1.002), strict=True):
        if end != limit:  # found on a grid of 0.08 %
            assert derivative(stress, end, 1e-4 * end) > 0.0
            assert derivative(stress, beyond * end, 1e-4 * end) < 0.0


def test_twist_beyond_the_largest_shear_stress_of_a_softening_law_is_refused():
    # τ(γ) = 2 γ (c₁₀ + 2 c₂₀ γ²) has its maximum at γ² = c₁₀ / (6 |c₂₀|): beyond it the outer
    # fibres give way although the torque of the section still rises
    law = {"kind": "yeoh", "c10": 1e5, "c20": -1e4, "c30": 0.0}
    dynamics = rubber(law, strains=["torsion"], order=0, elements=8)
    outermost = np.hypot(*dynamics.model.fibres.points[:, :2].T).max()
    assert 0.95 * RADIUS < outermost < RADIUS
    peak = np.sqrt(1e5 / 6e4) / outermost
    shares = 0.995, 1.005
    before, beyond = (
        dynamics.elastic_force(np.full(dynamics.n, share * peak))[0] * 8 / LENGTH
        for share in shares
    )
    assert before < beyond
    q = equilibrium(dynamics, tip=np.array([before, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(q, shares[0] * peak, rtol=1e-9)
    with pytest.raises(StaticsFailed, match="sheared beyond where the law") as caught:
        equilibrium(dynamics, tip=np.array([beyond, 0, 0, 0, 0, 0]))
    assert caught.value.load_factor == pytest.approx(before / beyond, abs=0.01)
    # the shear modulus of a neo-Hookean solid is the same at any shear
    steady = rubber(NEO, strains=["torsion"], order=0, elements=8)
    torque = steady.elastic_force(np.full(steady.n, 2.0 * peak))[0] * 8 / LENGTH
    q = equilibrium(steady, tip=np.array([torque, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(q, 2.0 * peak, rtol=1e-9)


def test_outer_fibres_of_a_sharp_bend_are_watched():
    dynamics = rubber(NEO, strains=["bend_y"], order=0, length=0.05)
    # at a curvature of 1/R the inner fibre would vanish
    moment = dynamics.elastic_force(np.array([1.5 / RADIUS]))[0]
    with pytest.raises(StaticsFailed, match="beyond where the law"):
        equilibrium(dynamics, tip=np.array([0, moment, 0, 0, 0, 0]))


REFUSED = [
    ({"kind": "neo_hookean", "c10": -1.0}, "law.c10", "shear modulus"),
    ({"kind": "mooney_rivlin", "c10": 1e5, "c01": -2e5}, "law.c01", "shear modulus"),
    ({"kind": "yeoh", "c10": 1e5}, "law.c20", "finite number"),
    ({"kind": "ogden"}, "law.kind", "neo_hookean"),
    ({"kind": "neo_hookean", "c10": 1e5, "c01": 1.0}, "law.c01", "known key"),
    ({"kind": "registered", "name": "nobody", "stretch": [0.5, 2]}, "law.name", "register_law"),
    ({"kind": "table", "stretch": [0.5, 1, 2], "stress": [-1, 0]}, "law.stress", "3 stresses"),
    ({"kind": "table", "stretch": [0.5, 1, 2], "stress": [-1, 0, -1]}, "law.stress", "rise"),
    ({"kind": "table", "stretch": [0.5, 1, 2], "stress": [-2, -1, 1]}, "law.stress", "of 0"),
    ({"kind": "table", "stretch": [0.5, 0.9, 2], "stress": [-2, 0, 1]}, "law.stretch", "above 1"),
]


@pytest.mark.parametrize(("law", "key", "expected"), REFUSED)
def test_bad_laws_are_refused_by_key(law, key, expected):
    with pytest.raises(SceneError) as caught:
        rubber(law)
    assert caught.value.key_path == f"materials.soft.{key}"
    assert expected in caught.value.expected


def test_moduli_beside_a_law_are_refused():
    with pytest.raises(SceneError, match="the law gives the moduli"):
        rubber(NEO, extra={"young_modulus": 1e6})


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda x: 1e5 * (x - 1.0) * (1.6 - x), "rises with the stretch"),
        (lambda x: 1e5 * (x - 0.8), "without stress at rest"),
        (lambda x: np.where(x < 0.7, np.nan, x - 1.0), "finite values"),
        (lambda x: 1e5 * np.sign(x - 1.0) * np.abs(x - 1.0) ** 0.5, "smooth"),
        (lambda _: 3.0, "finite values"),
    ],
)
def test_registered_functions_that_are_no_law_are_refused(function, expected):
    register_law("bad", stress=function)
    with pytest.raises(SceneError, match=expected):
        rubber({"kind": "registered", "name": "bad", "stretch": [0.5, 2.0]})


def test_a_law_is_registered_by_stress_or_by_energy():
    with pytest.raises(ValueError, match="either"):
        register_law("both", stress=np.sin, energy=np.cos)
