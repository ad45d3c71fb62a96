"""How far a unit of a coordinate moves the tip: known for any function, whatever its zeros."""

import numpy as np
import pytest
from numpy.polynomial import Legendre
from scenes import rod, rod_document, scene_of

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.bases import ElementBasis, base, get_basis, register
from soft_sim_ros.core.compile.scene import build_chain, compile_scene
from soft_sim_ros.core.compile.weights import absolute_moments, weights
from soft_sim_ros.core.quadrature import gauss, scattered
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import numerics

X = np.linspace(0.0, 1.0, 200_001)
LENGTH = 0.6


class Cosine(ElementBasis):
    """cos(k π x)."""

    kind = "cosine"

    def values(self, order, t):
        return np.cos(np.outer(0.5 * np.pi * (1.0 + t), np.arange(order + 1)))


class Waves(ElementBasis):
    """1 and sin(2^k π x), far faster than their number says."""

    kind = "waves"

    def values(self, order, t):
        waves = np.sin(np.outer(0.5 * np.pi * (1.0 + t), 2.0 ** np.arange(1, order + 1)))
        return np.concatenate([np.ones((len(t), 1)), waves], axis=1)


class Samples(ElementBasis):
    """1 and powers of the product of t − tₖ over the twelve points of a Gauss rule."""

    kind = "samples"

    def values(self, order, t):
        product = Legendre.basis(12)(t)
        return np.stack([product**k for k in range(order + 1)], axis=1)


USERS = (Cosine(), Waves(), Samples())
CASES = [
    *[("legendre", order) for order in (0, 1, 3, 6, 9, 12, 17, 24, 37, 50)],
    *[(kind, order) for kind in ("chebyshev", "monomial") for order in (0, 5, 12, 50)],
    *[("cosine", order) for order in (0, 12, 50)],
    *[("waves", order) for order in (1, 4, 8)],
    *[("samples", order) for order in (1, 3)],
]


@pytest.fixture(scope="module", autouse=True)
def users():
    known, kinds = dict(base._BASES), list(numerics.BASES)
    for basis in USERS:
        register(basis)
    yield
    base._BASES.clear()
    base._BASES.update(known)
    numerics.BASES[:] = kinds


def integral(values):
    """Return ∫ over X (m,) by the trapezoidal rule, exact to 1e-5 for |φ|."""
    return 0.5 * (values[1:] + values[:-1]).sum(axis=0) / (len(X) - 1)


@pytest.mark.parametrize(
    "kind", ["legendre", "chebyshev", "monomial", "cosine", "waves", "samples"]
)
def test_the_size_of_a_function_is_the_integral_of_its_absolute_value(kind):
    basis = get_basis(kind)
    for order in [o for k, o in CASES if k == kind][-1:]:
        exact = np.abs(basis.values(order, 2.0 * X - 1.0))
        found = absolute_moments(lambda x, o=order: basis.values(o, 2.0 * x - 1.0), order)
        np.testing.assert_allclose(found[0], integral(exact), rtol=5e-3)
        np.testing.assert_allclose(found[1], integral(exact * X[:, None]), rtol=5e-3)


@pytest.mark.parametrize(("kind", "order"), CASES)
def test_no_function_weighs_nothing_whatever_its_zeros(kind, order):
    """|φ| ≥ φ² / max |φ|, and the lever of bending is 1 − x."""
    chain = build_chain(
        scene_of(rod_document(strains=["bend_y", "stretch"], order=order, kind=kind, nodes=60))
    )
    found = weights(chain).reshape(2, -1)
    x, w = gauss(800)
    phi = get_basis(kind).values(order, 2.0 * x - 1.0)
    largest = np.abs(phi).max(axis=0)
    least = (w[:, None] * phi**2).T / largest[:, None]
    assert (found[0] >= 0.99 * LENGTH * least @ (1.0 - x)).all()
    assert (found[1] >= 0.99 * least.sum(axis=1)).all()
    assert (found[0] <= 1.01 * LENGTH * 0.5 * largest).all()


def test_a_column_buckles_at_every_order():
    """Loaded by 1.5 times Euler's load and pushed a little, it bends the same way at all orders."""
    load = np.zeros(6)
    euler = np.pi**2 / 4 * 1e6 * np.pi * 0.03**4 / 4 / LENGTH**2
    load[3], load[5] = -1.5 * euler, 1e-3 * euler
    tips = []
    for order in (8, 11, 12, 13):
        dynamics = rod(strains=["bend_y"], order=order, nodes=50)
        tips.append(dynamics.node_poses(equilibrium(dynamics, tip=load))[-1][:3, 3])
    assert tips[0][2] > 0.3 * LENGTH
    np.testing.assert_allclose(tips[1:], tips[:1] * np.ones((3, 1)), atol=2e-7 * LENGTH)


@pytest.mark.parametrize("order", [3, 12, 30])
def test_integrals_of_functions_that_are_no_polynomials_are_exact(order):
    """Of cosines, ∫₀¹ cos² kπx dx = 1/2 and ∫₀¹ cos kπx dx = 0 for k > 0."""
    document = rod_document(strains=["bend_y"], order=order, kind="cosine", nodes=100)
    document["actuators"] = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"}]
    dynamics = Dynamics(compile_scene(scene_of(document)))
    half = np.full(order + 1, 0.5)
    half[0] = 1.0
    law = 1e6 * np.pi * 0.03**4 / 4 * LENGTH * np.diag(half)
    np.testing.assert_allclose(dynamics.stiffness_matrix(), law, atol=1e-11 * law[0, 0])
    gain = dynamics.effort_matrix(np.zeros(dynamics.n))[:, 0]
    np.testing.assert_allclose(gain, LENGTH * np.eye(order + 1)[0], atol=1e-11)


def test_scattered_places_are_zeros_of_no_wave():
    places = scattered(2.0, 5.0, 101)
    assert places[0] == 2.0 and places[-1] == 5.0 and (np.diff(places) > 0.0).all()
    x = (places - 2.0) / 3.0
    for k in range(1, 500):
        assert np.abs(np.sin(k * np.pi * x)).max() > 0.9


def test_a_reference_shape_is_seen_between_even_places():
    """A curvature 60 sin(100 π s/L) vanishes at 101 evenly spaced places, and wants many nodes."""
    wave = {"curvature": [0.0, {"expression": f"60*sin(100*pi*s/{LENGTH})"}, 0.0]}
    straight = build_chain(scene_of(rod_document(order=3)))
    wavy = build_chain(scene_of(rod_document(order=3, section={"reference": wave})))
    turn = 60.0 * LENGTH
    # whether the rod is cut into many elements or one has many nodes
    segments = [
        sum(element.nodes - 1 for element in chain.rods["rod"].elements)
        for chain in (wavy, straight)
    ]
    assert segments[0] >= 3.0 * 2.0 / np.pi * turn
    assert segments[1] < 10
