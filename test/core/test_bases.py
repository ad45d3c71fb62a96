"""Strain bases: their spaces, and the example of docs/extending.md."""

import re
from pathlib import Path

import numpy as np
import pytest
from scenes import rod, rod_document, scene_of

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.bases import ElementBasis, base, get_basis
from soft_sim_ros.core.quadrature import gauss, lobatto
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import numerics

POLYNOMIAL = ["legendre", "chebyshev", "monomial"]


def test_legendre_functions_are_orthogonal():
    x, w = gauss(12)
    phi = get_basis("legendre").values(8, 2 * x - 1)
    gram = phi.T @ (w[:, None] * phi)
    np.testing.assert_allclose(gram, np.diag(1 / (2 * np.arange(9) + 1)), atol=1e-15)


@pytest.mark.parametrize("kind", POLYNOMIAL)
def test_polynomial_bases_span_all_polynomials_of_their_order(kind):
    t = np.linspace(-1, 1, 50)
    phi = get_basis(kind).values(4, t)
    for power in range(5):
        left = t**power - phi @ np.linalg.lstsq(phi, t**power, rcond=None)[0]
        assert np.abs(left).max() < 1e-13
    assert np.abs(t**5 - phi @ np.linalg.lstsq(phi, t**5, rcond=None)[0]).max() > 1e-3


def test_hats_are_one_at_their_end_and_add_up_to_one():
    ends = np.array([0.0, 0.1, 0.4, 0.5])
    hats = get_basis("linear")
    np.testing.assert_allclose(hats.values(ends, ends), np.eye(4))
    np.testing.assert_allclose(hats.values(ends, np.linspace(0, 0.5, 33)).sum(axis=1), 1.0)


@pytest.mark.parametrize("kind", POLYNOMIAL)
def test_polynomial_bases_of_one_order_give_the_same_motion(kind):
    load = np.array([0.05, 0.1, 0.2, 0.0, 2.0, 1.0])
    tips = [
        (d := rod(kind=k, order=4)).node_poses(equilibrium(d, tip=load))[-1]
        for k in ("legendre", kind)
    ]
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-9)


@pytest.mark.parametrize(("kind", "expected"), [("constant", 2.0), ("linear", 2.0)])
def test_element_bases_converge_at_their_order(kind, expected):
    """The tip converges with order 2: constant strain superconverges there."""
    load = np.array([0, 0, 0, 0, 3.0, 0])

    def tip(**options):
        d = rod(strains=["bend_z"], **options)
        return d.node_poses(equilibrium(d, tip=load))[-1][:3, 3]

    exact = tip(order=12, nodes=60)
    counts = np.array([4, 8, 16])
    errors = [np.linalg.norm(tip(kind=kind, elements=m, nodes=8) - exact) for m in counts]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope > expected - 0.2, errors


@pytest.mark.parametrize("count", range(2, 12))
def test_quadrature_rules_are_exact_to_their_degree(count):
    for rule, degree in ((gauss, 2 * count - 1), (lobatto, 2 * count - 3)):
        x, w = rule(count)
        for power in range(degree + 1):
            assert w @ x**power == pytest.approx(1 / (power + 1), rel=1e-13)
        assert abs(w @ x ** (degree + 1) - 1 / (degree + 2)) > 1e-15
    assert lobatto(count)[0][0] == 0.0 and lobatto(count)[0][-1] == 1.0


def test_the_basis_of_the_documentation_works(monkeypatch):
    monkeypatch.setattr(numerics, "BASES", numerics.BASES.copy())
    monkeypatch.setattr(base, "BASES", numerics.BASES)
    text = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert code
    with pytest.raises(SceneError, match="kind"):
        scene_of(rod_document(kind="cosine", order=6, strains=["bend_z"]))
    exec(code.group(1), {})
    assert isinstance(get_basis("cosine"), ElementBasis)
    dynamics = Dynamics(scene_of(rod_document(kind="cosine", order=6, strains=["bend_z"])))
    stiffness = 1e6 * np.pi * 0.03**4 / 4
    moment = np.pi * stiffness / 0.6
    q = equilibrium(dynamics, tip=np.array([0, 0, moment, 0, 0, 0]), tip_follows=True)
    np.testing.assert_allclose(dynamics.node_poses(q)[-1][:2, 3], [0, 2 * 0.6 / np.pi], atol=1e-9)
