"""C-2: strain bases, the selection matrix B_a, orthogonality, a basis of one's own."""

import re
from pathlib import Path

import numpy as np
import pytest
from scenes import ALL, rod, rod_document, scene_of, zoo_document
from scipy.special import roots_chebyt

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.bases import base, get_basis
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.core.compile.shape import selection_matrix, shape_matrix, strain
from soft_sim_ros.core.quadrature import gauss
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import NoSuchPlace, SceneError
from soft_sim_ros.scene import load_scene, numerics

PLANAR = ["bend_z", "stretch", "shear_y"]


def compiled_rod(**options):
    return compile_scene(scene_of(rod_document(**options)))


def test_the_selection_matrix_picks_strains_and_drops_the_others():
    b = selection_matrix(PLANAR)
    np.testing.assert_array_equal(b.T @ b, np.eye(3))
    np.testing.assert_array_equal(b @ b.T, np.diag([0, 0, 1, 1, 1, 0]))
    np.testing.assert_array_equal(selection_matrix(ALL), np.eye(6))
    with pytest.raises(NoSuchPlace, match="'bend': expected one of the strains"):
        selection_matrix(["bend"])


@pytest.mark.parametrize("kind", ["legendre", "chebyshev", "monomial"])
def test_the_shape_matrix_is_the_kronecker_product_of_1_22(kind):
    compiled = compiled_rod(strains=PLANAR, order=3, kind=kind)
    s = np.linspace(0, 0.6, 9)
    phi = get_basis(kind).values(3, 2 * s / 0.6 - 1)
    expected = np.stack([np.kron(selection_matrix(PLANAR), row) for row in phi])
    np.testing.assert_allclose(shape_matrix(compiled, "rod", s), expected, atol=1e-15)


def gram(compiled, rod_name, length, points):
    x, w = gauss(points)
    phi = shape_matrix(compiled, rod_name, length * x)
    return np.einsum("p,pij,pik->jk", length * w, phi, phi)


def test_columns_of_legendre_shapes_are_mutually_orthogonal():
    """∫ φ_i φ_j dσ = 0 for i ≠ j, of the same strain or not: C's footnote 1."""
    matrix = gram(compiled_rod(order=6), "rod", 0.6, 12)
    norms = np.tile(0.6 / (2 * np.arange(7) + 1), 6)
    np.testing.assert_allclose(matrix, np.diag(norms), atol=1e-15)


def test_elements_keep_orthogonality():
    """The shapes of one element vanish on the others."""
    compiled = compiled_rod(order=2, elements=3, strains=PLANAR)
    x, w = gauss(6)
    s = np.concatenate([0.2 * (k + x) for k in range(3)])
    phi = shape_matrix(compiled, "rod", s)
    matrix = np.einsum("p,pij,pik->jk", np.tile(0.2 * w, 3), phi, phi)
    off = matrix - np.diag(np.diag(matrix))
    assert np.abs(off).max() < 1e-15 and np.diag(matrix).min() > 0.03


def test_chebyshev_is_orthogonal_with_its_own_weight_and_not_without():
    nodes, weights = roots_chebyt(20)
    phi = get_basis("chebyshev").values(6, nodes)
    matrix = phi.T @ (weights[:, None] * phi)
    np.testing.assert_allclose(matrix, np.diag([np.pi] + 6 * [np.pi / 2]), atol=1e-13)
    plain = gram(compiled_rod(order=6, kind="chebyshev", strains=["bend_z"]), "rod", 0.6, 12)
    assert np.abs(plain - np.diag(np.diag(plain))).max() > 0.1


def test_orthogonal_shapes_make_the_stiffness_of_a_uniform_rod_diagonal():
    dynamics = rod(order=5)
    matrix = dynamics.stiffness_matrix()
    np.testing.assert_array_equal(matrix, np.diag(np.diag(matrix)))
    monomial = rod(order=5, kind="monomial").stiffness_matrix()
    # that is comfort, not need: the same space, other coordinates, only worse conditioned
    assert np.linalg.cond(monomial[:6, :6]) > 1e4 * np.linalg.cond(matrix[:6, :6])


def test_strains_by_the_shape_matrix_are_those_the_arm_is_bent_by():
    """Integrating g′ = g ξ̂ with ξ = ξ₀ + Φ q leads from node to node."""
    dynamics = Dynamics(scene_of(zoo_document()))
    rng = np.random.default_rng(3)
    q = 0.1 * rng.normal(size=dynamics.n)
    poses = dynamics.node_poses(q)
    chain = dynamics.compiled.chain
    rod_map = chain.rods["one"]
    first = poses[rod_map.first_node]
    pose, steps = first.copy(), 4000
    length = rod_map.rod.length
    middles = length * (np.arange(steps) + 0.5) / steps
    for xi in strain(dynamics.compiled, "one", q, middles) * (length / steps):
        k, gamma = xi[:3], xi[3:]
        turn = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        move = np.eye(4)
        move[:3, :3] += turn + turn @ turn / 2
        move[:3, 3] = gamma + np.cross(k, gamma) / 2
        pose = pose @ move
    np.testing.assert_allclose(pose, poses[rod_map.last_node], atol=2e-4)
    # which is far from the reference shape
    straight = dynamics.node_poses(0 * q)
    assert np.abs(poses[rod_map.last_node] - straight[rod_map.last_node]).max() > 0.02


def test_shapes_shared_by_the_elements_of_a_section_join_without_a_jump():
    """Hats: continuous where elements meet, and together they are one."""
    compiled = compiled_rod(kind="linear", elements=3, strains=PLANAR)
    s = np.array([0.2 - 1e-9, 0.2, 0.2 + 1e-9, 0.33])
    phi = shape_matrix(compiled, "rod", s)
    np.testing.assert_allclose(phi[0], phi[1], atol=1e-7)
    np.testing.assert_allclose(phi[2], phi[1], atol=1e-7)
    expected = np.broadcast_to(selection_matrix(PLANAR).sum(axis=1), (4, 6))
    np.testing.assert_allclose(phi.sum(axis=2), expected, atol=1e-14)


def test_where_elements_meet_the_one_that_begins_counts():
    compiled = compile_scene(load_scene("soft_arm"))
    names = compiled.coordinate_names
    phi = shape_matrix(compiled, "arm", np.array([0.0, 0.2, 0.6]))
    used = [{names[c].split("/")[1] for c in np.flatnonzero(p.any(axis=0))} for p in phi]
    assert used == [{"proximal"}, {"middle"}, {"distal"}]


def test_places_outside_the_rod_are_refused():
    compiled = compiled_rod()
    with pytest.raises(NoSuchPlace, match="'arm': expected one of the rods rod"):
        shape_matrix(compiled, "arm", np.array([0.0]))
    with pytest.raises(NoSuchPlace, match=r"0.7: expected an arc length of rod in \[0, 0.6\] m"):
        strain(compiled, "rod", np.zeros(36), np.array([0.7]))


def test_the_ten_lines_of_the_documentation_make_a_basis(monkeypatch):
    """The very code block; orthogonal, and statics with it meet the closed form."""
    monkeypatch.setattr(numerics, "BASES", numerics.BASES.copy())
    monkeypatch.setattr(base, "BASES", numerics.BASES)
    monkeypatch.setattr(base, "_BASES", dict(base._BASES))
    page = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    lines = [line for line in blocks[0].splitlines() if line.strip() and '"""' not in line]
    assert len(lines) <= 10
    with pytest.raises(SceneError, match="kind"):
        scene_of(rod_document(kind="cosine"))
    exec(blocks[0], {})
    matrix = gram(compiled_rod(kind="cosine", order=4), "rod", 0.6, 30)
    np.testing.assert_allclose(matrix, np.diag(np.tile([0.6] + 4 * [0.3], 6)), atol=1e-13)
    # EI K = f (ℓ − s)²/2 under a small line load: cosines converge like k⁻², to the right value
    document = rod_document(kind="cosine", order=14, strains=["bend_z"], nodes=40)
    load = 1e-4
    document["loads"] = [{"distributed": "f", "body": "rod", "force": [0, load, 0]}]
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics)
    stiffness = 1e6 * np.pi * 0.03**4 / 4
    s = np.linspace(0, 0.6, 25)
    bend = strain(dynamics.compiled, "rod", q, s)[:, 2]
    np.testing.assert_allclose(
        bend, load * (0.6 - s) ** 2 / 2 / stiffness, atol=0.03 * load * 0.18 / stiffness
    )
    assert dynamics.node_poses(q)[-1, 1, 3] == pytest.approx(
        load * 0.6**4 / 8 / stiffness, rel=1e-4
    )
