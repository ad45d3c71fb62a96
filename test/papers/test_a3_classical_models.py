"""A-3: classical models as choices of one key; what a model forbids is a reaction."""

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from scenes import SOFT, rod_document, scene_of
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve
from scipy.special import jn_zeros

from soft_sim_ros.core.analysis.modes import modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError, StaticsFailed
from soft_sim_ros.scene import load_scene

E, G, RHO = SOFT["young_modulus"], SOFT["shear_modulus"], SOFT["density"]
STRING = {"length": 2.0, "radius": 0.002, "gravity": (0, 0, -9.81), "order": 7, "elements": 4}
STRING["nodes"] = 70
LINE = RHO * np.pi * STRING["radius"] ** 2  # kg/m
WEIGHT = LINE * 9.81  # N/m


def document_of(model, **options):
    order = options.pop("order", 8)
    document = rod_document(order=order, **options)
    document["bodies"][0]["model"] = model
    del document["bodies"][0]["strains"]
    document["numerics"]["basis"]["order"] = order
    return document


def model_of(model, **options):
    return Dynamics(scene_of(document_of(model, **options)))


# -- strings and cables --------------------------------------------------------------------


def catenary(s, length, force, stiffness=np.inf):
    """Position (N, 3) and tension (N,) of a string hung at the origin, pulled by a tip force.

    The tension has the direction of the string, n(s) = F − w (ℓ − s) e_z, so r = ∫ n/|n| + n/EA.
    """
    side = np.hypot(force[0], force[1])
    along = np.array([force[0], force[1]]) / side

    def parts(s):
        v = force[2] - WEIGHT * (length - s)
        x = side / WEIGHT * np.arcsinh(v / side) + side * s / stiffness
        z = np.hypot(side, v) / WEIGHT + v**2 / (2 * WEIGHT * stiffness)
        return x, z, np.hypot(side, v)

    (x, z, tension), (x0, z0, _) = parts(s), parts(0.0)
    return np.column_stack([np.outer(x - x0, along), z - z0]), tension


@pytest.mark.parametrize("force", [(0.12, 0.0, 0.03), (-0.05, 0.08, 0.3), (0.02, 0.02, -0.1)])
def test_an_inextensible_string_hangs_in_a_catenary(force):
    dynamics = model_of("string", **STRING)
    tip = np.array([0, 0, 0, *force])
    q = equilibrium(dynamics, tip=tip)
    wrench = dynamics.internal_wrench(q, tip=tip)
    exact, tension = catenary(wrench.s, STRING["length"], force)
    np.testing.assert_allclose(dynamics.node_poses(q)[:, :3, 3], exact, atol=1e-8)
    # its tension is a multiplier: no law speaks of it; shear and moments vanish by balance alone
    np.testing.assert_allclose(wrench.after[1:-1, 3], tension[1:-1], rtol=1e-8)
    other = np.delete(wrench.after[1:], 3, axis=1)
    np.testing.assert_allclose(other, 0.0, atol=1e-6 * tension.max())


def test_a_string_between_two_points_is_the_catenary_of_its_span():
    """√(ℓ² − h²) = 2a sinh(d/2a); the force at the far end that holds it there is found first."""
    length, across, up = STRING["length"], 1.6, 0.4
    dynamics = model_of("string", **STRING)
    memory = {"q": None}

    def tip(force):
        load = np.array([0, 0, 0, force[0], 0, force[1]])
        memory["q"] = equilibrium(dynamics, memory["q"], tip=load)
        return dynamics.node_poses(memory["q"])[:, :3, 3]

    force = fsolve(lambda f: tip(f)[-1, [0, 2]] - [across, up], [0.1, 0.1], xtol=1e-11, epsfcn=1e-8)
    a = brentq(lambda a: 2 * a * np.sinh(across / (2 * a)) - np.sqrt(length**2 - up**2), 0.1, 9)
    middle = across / 2 - a * np.arctanh(up / length)
    x, _, z = tip(force).T
    expected = a * (np.cosh((x - middle) / a) - np.cosh(middle / a))
    np.testing.assert_allclose(z, expected, atol=1e-8)
    assert force[0] == pytest.approx(WEIGHT * a, rel=1e-7)
    assert z.min() < -0.2


@pytest.mark.parametrize("young", [2e5, 1e7])
def test_a_cable_hangs_in_an_elastic_catenary(young):
    material = {"young_modulus": young, "shear_modulus": young / 3}
    dynamics = model_of("cable", **STRING, material=material)
    force = (0.12, 0.05, 0.08)
    tip = np.array([0, 0, 0, *force])
    q = equilibrium(dynamics, tip=tip)
    wrench = dynamics.internal_wrench(q, tip=tip)
    stiffness = young * np.pi * STRING["radius"] ** 2
    exact, tension = catenary(wrench.s, STRING["length"], force, stiffness)
    np.testing.assert_allclose(dynamics.node_poses(q)[:, :3, 3], exact, atol=2e-8)
    np.testing.assert_allclose(wrench.after[1:-1, 3], tension[1:-1], rtol=1e-7)


def test_a_hanging_string_swings_at_the_zeros_of_bessels_function():
    """Daniel Bernoulli: ω_n = ½ j₀ₙ √(g/ℓ), alike in both planes; segments of fourth order."""
    dynamics = model_of("string", **STRING | {"gravity": (9.81, 0, 0)})
    omega = modes(dynamics, np.zeros(dynamics.n))[0][:8]
    expected = np.repeat(jn_zeros(0, 4) / 2 * np.sqrt(9.81 / STRING["length"]), 2)
    np.testing.assert_allclose(omega[:4], expected[:4], rtol=1e-7)
    np.testing.assert_allclose(omega, expected, rtol=5e-6)


def test_a_string_falls_without_gaining_or_losing_energy():
    numerics = {"step": 5e-4, "integrator": "implicit_midpoint"}
    options = STRING | {"order": 4, "nodes": 16, "elements": 1}
    document = document_of("string", **options)
    document["numerics"] |= numerics
    document["initial"] = {"strains": {"rod/s": {"bend_y": 0.5, "bend_z": -0.7}}}
    simulation = Simulation(scene_of(document))
    simulation.advance(800)
    ledger = simulation.ledger()
    kinetic, elastic, residual = ledger[0], ledger[1], ledger[-1]
    assert elastic == 0.0 and kinetic > 0.3 * LINE * STRING["length"] * 9.81
    assert abs(residual) < 1e-3 * kinetic


@pytest.mark.parametrize("force", [(0.0, 0.0, 0.3), (0.3, 0.1, 0.5)])
def test_a_string_turns_until_it_is_pulled_not_pushed(force):
    """Held at the origin and pulled up harder than its weight, it stands above, in tension."""
    dynamics = model_of("string", **STRING | {"order": 4, "nodes": 12})
    tip = np.array([0, 0, 0, *force])
    q = equilibrium(dynamics, tip=tip)
    assert dynamics.node_poses(q)[-1, 2, 3] > 0.3
    assert dynamics.internal_wrench(q, tip=tip).before[1:, 3].min() > 0.0


def test_a_line_at_the_end_of_a_pole_hangs_and_bends_it_by_its_weight():
    """A stiff pole, a string, a weight: the pole carries both, the string only what is below."""
    document = document_of("kirchhoff", gravity=(0, 0, -9.81), order=4)
    line = document_of("string", length=0.4, radius=0.002)["bodies"][0] | {"rod": "line"}
    document["bodies"] += [line, {"rigid_body": "fish", "mass": 0.02}]
    document["initial"] = {"state": "equilibrium"}
    dynamics = (simulation := Simulation(scene_of(document))).dynamics
    wrench, poses = dynamics.internal_wrench(simulation.q), dynamics.node_poses(simulation.q)
    pole, rope = (dynamics.compiled.chain.rods[name] for name in ("rod", "line"))
    hung = (0.02 + LINE * 0.4) * 9.81
    assert wrench.after[rope.first_node, 3] == pytest.approx(hung, rel=1e-9)
    carried = poses[pole.last_node, :3, :3] @ wrench.before[pole.last_node, 3:]
    np.testing.assert_allclose(carried, [0, 0, -hung], atol=1e-9)
    below = poses[rope.first_node, :3, 3] - poses[-1, :3, 3]
    np.testing.assert_allclose(below, [0, 0, 0.4], atol=1e-9)


def test_a_string_that_nothing_pulls_has_no_shape_and_says_so():
    dynamics = model_of("string", **STRING | {"gravity": (0, 0, 0)})
    with pytest.raises(StaticsFailed, match="strings and cables need weight"):
        equilibrium(dynamics)


# -- beams ---------------------------------------------------------------------------------

LENGTH, RADIUS = 0.6, 0.03
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
STIFF = np.array([2 * G * INERTIA, E * INERTIA, E * INERTIA, E * AREA, G * AREA, G * AREA])
FIXED = {
    "cosserat": [],
    "timoshenko": [3],
    "kirchhoff": [4, 5],
    "inextensible": [3, 4, 5],
    "euler_bernoulli": [3, 4, 5],
}


@pytest.mark.parametrize("model", FIXED)
def test_a_beam_of_a_model_bends_as_one_with_those_stiffnesses_infinite(model):
    """And carries N, T₁, T₂ = Rᵀ (F + f (ℓ − s)), by a law or as reactions."""
    section = {"shear_correction": 1.0, "reference": {"curvature": [1.0, -0.5, 2.0]}}
    dynamics = model_of(model, order=9, nodes=80, section=section, gravity=(2.0, 1.0, -9.81))
    tip = np.array([0.1, -0.05, 0.1, 0.6, -1.0, 0.8])
    q = equilibrium(dynamics, tip=tip)
    stiffness = STIFF.copy()
    stiffness[FIXED[model]] = np.inf
    rest, load = np.array([1.0, -0.5, 2.0, 1.0, 0, 0]), RHO * AREA * np.array([2.0, 1.0, -9.81])
    position, turn = solve_rod(
        LENGTH, stiffness, lambda s: rest, density_force=load, tip_force=tip[3:], tip_moment=tip[:3]
    )
    poses = dynamics.node_poses(q)
    np.testing.assert_allclose(poses[-1, :3, 3], position, atol=1e-7)
    np.testing.assert_allclose(poses[-1, :3, :3], turn, atol=1e-6)
    wrench = dynamics.internal_wrench(q, tip=tip)
    force = tip[3:] + np.outer(LENGTH - wrench.s, load)
    held = np.einsum("kji,kj->ki", poses[:, :3, :3], force)
    np.testing.assert_allclose(wrench.before[:, 3:], held, atol=1e-10)


def test_models_differ():
    """Else the test above could not tell them apart."""
    tips = [
        (d := model_of(m)).node_poses(equilibrium(d, tip=np.array([0, 0, 0, 30.0, 0, 3.0])))[-1]
        for m in ("cosserat", "timoshenko", "kirchhoff", "inextensible")
    ]
    for i, one in enumerate(tips):
        assert all(np.abs(one - other).max() > 1e-5 for other in tips[:i])


def test_the_plane_beam_obeys_the_three_equations_of_the_paper():
    """Γ + M′ + αT = 0, F + N′ − (α/ν) T = 0, P + T′ + (α/ν) N = 0 in the moving frame."""
    dynamics = model_of("kirchhoff", order=12, nodes=60, gravity=(0, -9.81, 0))
    tip = np.array([0, 0, 0.1, 2.0, 1.0, 0])
    q = equilibrium(dynamics, tip=tip)
    s, wrench, _ = dynamics.internal_wrench(q, tip=tip)
    turn = dynamics.node_poses(q)[:, :2, :2]
    load = np.einsum("kji,j->ki", turn, [0, -9.81 * RHO * AREA])
    fits = [np.polynomial.Legendre.fit(s, x, 14) for x in wrench[:, [2, 3, 4]].T]
    moment, axial, shear = (f(s) for f in fits)
    rates = [f.deriv()(s) for f in fits]
    alpha, bend = 1 + axial / STIFF[3], moment / STIFF[2]  # α and α/ν by the section law
    scale = np.abs(load).max()
    np.testing.assert_allclose(rates[0] + alpha * shear, 0.0, atol=1e-6 * scale)
    np.testing.assert_allclose(load[:, 0] + rates[1] - bend * shear, 0.0, atol=1e-5 * scale)
    np.testing.assert_allclose(load[:, 1] + rates[2] + bend * axial, 0.0, atol=1e-5 * scale)


def transverse_frequencies(length, radius, count, shear=True, rotary=True):
    """ω of a straight cantilever in one plane: roots of det of the transfer matrix."""
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4

    def condition(omega):
        # (w, θ, M, V)′ with w′ = θ + V/kGA, θ′ = M/EI, M′ = −V − ρI ω² θ, V′ = −ρA ω² w
        a = np.zeros((4, 4))
        a[0, 1], a[0, 3] = 1.0, shear / (G * area)
        a[1, 2] = 1 / (E * inertia)
        a[2, 1], a[2, 3] = -rotary * RHO * inertia * omega**2, -1.0
        a[3, 0] = -RHO * area * omega**2
        return np.linalg.det(expm(a * length)[2:, 2:])

    roots, step = [], 1.5 * np.sqrt(E * inertia / (RHO * area)) / length**2
    low = step
    while len(roots) < count:
        if condition(low) * condition(low + step) < 0:
            roots.append(brentq(condition, low, low + step, xtol=1e-13 * low, rtol=1e-14))
        low += step
    return np.array(roots)


@pytest.mark.parametrize(
    ("model", "shear", "rotary"),
    [
        ("timoshenko", True, True),
        ("inextensible", False, True),
        ("euler_bernoulli", False, False),
    ],
)
def test_transverse_frequencies_are_those_of_the_model(model, shear, rotary):
    """Timoshenko: shear and rotary inertia; Rayleigh: rotary inertia only; Euler–Bernoulli."""
    section = {"shear_correction": 1.0}
    dynamics = model_of(model, order=12, nodes=40, section=section)
    omega, shapes = modes(dynamics, np.zeros(dynamics.n))
    bends = [c for c, name in enumerate(dynamics.compiled.coordinate_names) if "bend_z" in name]
    plane = np.abs(shapes[bends]).max(axis=0) > 1e-6 * np.abs(shapes).max(axis=0)
    expected = transverse_frequencies(LENGTH, RADIUS, 4, shear, rotary)
    first = np.unique(omega[plane].round(6))[:4]
    np.testing.assert_allclose(first, expected, rtol=1e-7)


def test_timoshenko_tends_to_euler_bernoulli_with_the_square_of_slenderness():
    """Deflection under a small tip force: 1 + 3EI/(GA ℓ²); the frequency ratio falls alike."""
    lengths, excess, drop = np.array([0.3, 0.6, 1.2, 2.4]), [], []
    for length in lengths:
        tips, first = [], []
        for model in ("timoshenko", "euler_bernoulli"):
            dynamics = model_of(
                model, order=6, nodes=24, length=length, section={"shear_correction": 1.0}
            )
            force = 1e-5 * E * INERTIA / length**2
            q = equilibrium(dynamics, tip=np.array([0, 0, 0, 0, force, 0]))
            tips.append(dynamics.node_poses(q)[-1, 1, 3])
            first.append(modes(dynamics, np.zeros(dynamics.n))[0][0])
        excess.append(tips[0] / tips[1] - 1)
        drop.append(1 - first[0] / first[1])
    np.testing.assert_allclose(excess, 3 * E * INERTIA / (G * AREA * lengths**2), rtol=1e-4)
    slope = np.polyfit(np.log(lengths[1:]), np.log(drop[1:]), 1)[0]
    assert slope == pytest.approx(-2.0, abs=0.05)


# -- scenes --------------------------------------------------------------------------------


def test_the_scene_of_this_row_is_a_catenary():
    simulation = Simulation(load_scene("catenary"))
    weight = 1200.0 * np.pi * 0.004**2 * 9.81
    force, length = np.array([0.8, 0.5]), 2.0
    v = force[1] - weight * length
    x = force[0] / weight * (np.arcsinh(force[1] / force[0]) - np.arcsinh(v / force[0]))
    z = (np.hypot(*force) - np.hypot(force[0], v)) / weight
    tip = simulation.sampler(2).poses()[-1]
    np.testing.assert_allclose(tip[:3], [x, 0, 2.0 + z], atol=1e-5)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"model": "beam"}, "one of cosserat, timoshenko"),
        ({"model": "string", "strains": ["stretch"]}, "one of bend_y, bend_z"),
    ],
)
def test_wrong_models_are_refused(change, words):
    document = rod_document()
    document["bodies"][0] |= change
    with pytest.raises(SceneError, match=words):
        scene_of(document)


def test_a_string_takes_no_moments_and_no_law_of_bending():
    load = {"point": "p", "body": "rod", "moment": [0, 1, 0]}
    with pytest.raises(SceneError, match="a string carries no moment"):
        scene_of(document_of("string", loads=[load]))
    actuator = {"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"}
    with pytest.raises(SceneError, match="stretch"):
        scene_of(document_of("cable", actuators=[actuator]))
    with pytest.raises(SceneError, match="a material without a law"):
        document = document_of("string")
        document["materials"]["soft"] = {"law": {"kind": "neo_hookean", "c10": 1e5}, "density": 1e3}
        scene_of(document)
