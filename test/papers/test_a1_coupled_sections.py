"""A-1: section laws in which strains are coupled: any symmetric H (6, 6), along any curve."""

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from scenes import ALL, SOFT, random_state, rod_document, scene_of

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import field
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

LENGTH, RADIUS = 0.6, 0.03
AREA = np.pi * RADIUS**2
CURVED = {"curvature": [1.0, [0.0, -2.0], {"expression": "3.0 * cos(6.0 * s)"}]}
LOAD = np.array([0.05, 0.02, -0.1, 0.5, -1.0, 0.8])


def given(law):
    """Return the keys of a section for a stiffness matrix (6, 6) or, of two, a taper of it."""
    start, end = np.broadcast_to(law, (2, 6, 6))
    pair = {(i, j): [start[i, j], end[i, j]] for i in range(6) for j in range(i, 6)}
    return {
        "stiffness": {name: pair[i, i] for i, name in enumerate(ALL)},
        "coupling": {
            name: {other: pair[i, j] for j, other in enumerate(ALL) if i < j and any(pair[i, j])}
            for i, name in enumerate(ALL[:-1])
        },
    }


def arm(law, section=None, **options):
    return Dynamics(scene_of(rod_document(section=given(law) | (section or {}), **options)))


def plain_law():
    """A strip's law in its principal axes: soft about y, stiff about z."""
    e, g = SOFT["young_modulus"], SOFT["shear_modulus"]
    about_y, about_z = 2e-7, 9e-7
    return np.diag([g * 3e-7, e * about_y, e * about_z, e * AREA, 0.8 * g * AREA, 0.9 * g * AREA])


def random_law(seed):
    """A symmetric positive definite law whose couplings are as large as its diagonal allows."""
    rng = np.random.default_rng(seed)
    size = np.sqrt(np.diag(plain_law()))
    mixed = rng.normal(size=(6, 6))
    whole = mixed @ mixed.T + 3.0 * np.eye(6)
    return whole / np.sqrt(np.outer(np.diag(whole), np.diag(whole))) * np.outer(size, size)


def test_a_fully_coupled_tapering_law_along_a_curve_is_that_of_the_cosserat_equations():
    start, end = random_law(1), 0.6 * random_law(2)
    dynamics = arm([start, end], {"reference": CURVED}, order=13, nodes=80, gravity=(1, -2, -9.81))
    pose = dynamics.node_poses(equilibrium(dynamics, tip=LOAD))[-1]
    options = {
        "density_force": SOFT["density"] * AREA * np.array([1.0, -2.0, -9.81]),
        "tip_force": LOAD[3:], "tip_moment": LOAD[:3],
    }  # fmt: skip

    def rest(s):
        return np.array([1.0, -2.0 * s / LENGTH, 3.0 * np.cos(6.0 * s), 1.0, 0, 0])

    def law(s):
        return start + s / LENGTH * (end - start)

    position, turn = solve_rod(LENGTH, law, rest, **options)
    np.testing.assert_allclose(pose[:3, 3], position, atol=2e-7)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=2e-6)
    # any one of the couplings turned round would be seen a thousand times over
    flipped = np.outer([1, 1, -1, 1, 1, 1], [1, 1, -1, 1, 1, 1])
    other, _ = solve_rod(LENGTH, lambda s: law(s) * flipped, rest, **options)
    assert np.abs(other - position).max() > 2e-3


def test_turned_section_axes_are_coupled_bending():
    """The same strip in axes turned about the backbone: the same motion to round-off."""
    angle = 0.7
    turn = se3.exp(np.array([angle, 0, 0, 0, 0, 0]))
    ad = se3.Ad(turn)  # of strains in the turned axes to those in the principal ones
    alike = {"inertia_per_length": [4e-4, 2e-4, 2e-4]}
    runs = []
    for law, pose in ((plain_law(), np.eye(4)), (ad.T @ plain_law() @ ad, turn)):
        section = given(law) | alike
        document = rod_document(
            section=section,
            order=3,
            gravity=(1.0, -4.0, -6.0),
            numerics={"step": 0.002, "newton_tolerance": 1e-11},
        )
        offset = {"rpy": [angle if pose[2, 1] else 0.0, 0.0, 0.0]}
        document["bodies"].insert(0, {"joint": "clamp", "kind": "fixed", "offset": offset})
        simulation = Simulation(scene_of(document))
        for _ in range(4):
            simulation.advance(25)
        runs.append(simulation.dynamics.node_poses(simulation.q)[-1] @ se3.inverse(pose))
    assert np.abs(runs[0][:3, 3] - [LENGTH, 0, 0]).max() > 0.05
    np.testing.assert_allclose(runs[1], runs[0], atol=1e-10)


def test_a_line_beside_the_centre_of_stiffness():
    """H moved to a parallel line, as a section whose centre of mass lies off its shear centre."""
    aside = se3.exp(np.array([0.3, 0, 0, 0, 0.012, -0.02]))
    ad = se3.Ad(aside)  # ξ at the old line = Ad ξ at the new one, which goes through ``aside``
    tips = []
    for law, pose in ((plain_law(), np.eye(4)), (ad.T @ plain_law() @ ad, aside)):
        stretched = np.linalg.solve(se3.Ad(pose), [0, 0, 0, 1.0, 0, 0])
        reference = {"curvature": stretched[:3], "stretch": stretched[3], "shear": stretched[4:]}
        document = rod_document(section=given(law) | {"reference": reference}, order=6, nodes=20)
        quaternion = [np.sin(0.15), 0, 0, np.cos(0.15)] if pose[2, 1] else [0, 0, 0, 1]
        offset = {"position": pose[:3, 3], "quaternion": quaternion}
        document["bodies"].insert(0, {"joint": "clamp", "kind": "fixed", "offset": offset})
        back = se3.inverse(pose)
        offset = {"position": back[:3, 3], "quaternion": [-quaternion[0], 0, 0, quaternion[3]]}
        document["bodies"].append({"joint": "tool", "kind": "fixed", "offset": offset})
        dynamics = Dynamics(scene_of(document))
        q = equilibrium(dynamics, tip=np.array([0.02, 0.01, 0.03, 0.2, -0.3, 0.2]))
        tips.append(dynamics.node_poses(q)[-1])
    assert np.abs(tips[0][:3, 3] - [LENGTH, 0, 0]).max() > 0.05
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-9)


def test_coupled_forces_have_an_energy_and_exact_tangents():
    material = {"rayleigh": {"stiffness": 0.02}, "maxwell": {"ratio": 0.4, "time": 0.1}}
    dynamics = arm(random_law(3), {"reference": CURVED}, order=2, material=material)
    q, v, a = random_state(dynamics, 4)
    whole = dynamics.stiffness_matrix()
    assert np.abs(whole - np.diag(np.diag(whole))).max() > 0.3 * np.abs(whole).max() ** 0.5
    np.testing.assert_array_equal(whole, whole.T)
    np.testing.assert_allclose(dynamics.damping_matrix(), 0.02 * whole, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(dynamics.branch_matrix(), 0.4 * whole, rtol=1e-12, atol=1e-18)
    energy = dynamics.energies(q, v)[1]
    assert energy == pytest.approx(0.5 * q @ whole @ q, rel=1e-13)
    found = dynamics.tangents(q, v, a)[0]
    column, h = np.zeros_like(found), 1e-6 / dynamics.model.weight
    for j, step in enumerate(np.diag(h)):
        plus, minus = (dynamics.inverse_dynamics(q + x, v, a) for x in (step, -step))
        column[:, j] = (plus - minus) / (2 * h[j])
    np.testing.assert_allclose(found, column, atol=1e-6 * np.abs(found).max())


def test_rayleighs_beta_acts_on_a_given_stiffness():
    """Without couplings too: damping is β times the stiffness that is there."""
    section = {"stiffness": {"bend_y": 3.0}, "damping": {"bend_z": 0.5}}
    material = {"rayleigh": {"stiffness": 0.1}, "viscosity": 0.0}
    part = scene_of(rod_document(section=section, material=material)).bodies[0].sections[0]
    x = np.array(0.3)
    expected = 0.1 * part.stiffness(x)
    expected[2] = 0.5
    np.testing.assert_allclose(part.damping(x), expected, rtol=1e-12)


def test_the_field_equations_hold_with_couplings():
    """C (1.20): what is left falls with the order of the basis."""
    left = []
    for order in (3, 5, 7):
        dynamics = arm(random_law(5), order=order, nodes=30, gravity=(0.1, -0.2, -0.9))
        parts = field.fields(dynamics, equilibrium(dynamics, tip=0.1 * LOAD))
        left.append(np.linalg.norm(field.norms(parts).balance))
    assert left[0] > 4 * left[1] > 16 * left[2], left


def bad(section, **rod):
    document = rod_document(section=section)
    document["bodies"][0] |= rod
    return document


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (bad({"coupling": {"bend": {}}}), "coupling.*did you mean bend_"),
        (bad({"coupling": {"bend_y": {"bend_y": 1.0}}}), "coupling.bend_y.*expected a known key"),
        (bad({"coupling": {"bend_y": {"bend_z": 0.1}, "bend_z": {"bend_y": 0.1}}}),
         "every pair once: it stands under bend_y too"),
        (bad({"coupling": {"bend_y": {"bend_z": 100.0}}}),
         "a stiffness matrix that is positive definite .it is not at s = 0 m"),
        (bad({"coupling": {"bend_y": {"bend_z": [0.0, 100.0]}}}), "positive definite .* s = 0.6 m"),
        (bad({"coupling": {"bend_y": {"stretch": "x"}}}), "coupling.bend_y.stretch = x"),
        (bad({"coupling": {"bend_y": {"bend_z": 0.0}}}, model="string", strains=["bend_y"]),
         "a string has no bending stiffness"),
        (bad({"coupling": {"torsion": {"stretch": 1.0}}}) | {"materials": {"soft": {
            "law": {"kind": "neo_hookean", "c10": 1e5}, "density": 1e3}}},
         "the law of the material says how stiff it is"),
    ],
)  # fmt: skip
def test_bad_couplings_are_refused(document, words):
    with pytest.raises(SceneError, match=words):
        scene_of(document)
