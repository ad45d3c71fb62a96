"""SE(3) for any twist: identities that pin down every sign."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from soft_sim_ros.core.algebra import se3

number = st.floats(-3.0, 3.0, allow_subnormal=False)
vectors = st.tuples(number, number, number).map(np.array)
scales = st.sampled_from([0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-2, 0.1, 0.3, 1.0, 3.0, 20.0])
twists = st.tuples(vectors, vectors, scales).map(lambda x: np.concatenate([x[2] * x[0], x[1]]))
wrenches = st.tuples(vectors, vectors).map(np.concatenate)


@st.composite
def small_rotations(draw, largest):
    """Twists with a rotation angle in (0, largest], often very close to either end."""
    axis = draw(vectors.filter(lambda v: np.linalg.norm(v) > 0.1))
    gap = draw(st.sampled_from([0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0, 3.0]))
    angle = largest - gap if draw(st.booleans()) else min(gap, largest)
    return np.concatenate([angle * axis / np.linalg.norm(axis), draw(vectors)])


@given(twists)
def test_exp_is_the_matrix_exponential(x):
    expected = expm(se3.hat(x))
    np.testing.assert_allclose(se3.exp(x), expected, atol=1e-12 * (1 + np.abs(expected).max()))


@given(small_rotations(np.pi))
def test_log_undoes_exp_up_to_a_half_turn(x):
    g = se3.exp(x)
    y = se3.log(g)
    np.testing.assert_allclose(se3.exp(y), g, atol=1e-11)
    assert np.linalg.norm(y[:3]) <= np.pi + 1e-12
    if np.linalg.norm(x[:3]) < np.pi - 1e-6:
        np.testing.assert_allclose(y, x, atol=1e-8)


@given(twists)
def test_rotation_part_stays_orthonormal(x):
    r = se3.exp(x)[:3, :3]
    np.testing.assert_allclose(r.T @ r, np.eye(3), atol=5e-14)


@given(twists, twists)
def test_ad_is_the_lie_bracket(x, y):
    a, b = se3.hat(x), se3.hat(y)
    np.testing.assert_allclose(
        se3.hat(se3.ad(x) @ y), a @ b - b @ a, atol=1e-12 * (1 + np.abs(a @ b).max())
    )


@given(twists)
def test_adjoint_of_exp_is_exp_of_ad(x):
    expected = expm(se3.ad(x))
    np.testing.assert_allclose(
        se3.Ad(se3.exp(x)), expected, atol=1e-11 * (1 + np.abs(expected).max())
    )


@given(twists, wrenches, twists)
def test_coad_is_dual_to_ad_so_power_does_not_depend_on_the_frame(x, wrench, y):
    # B (3.6): ad*_η Λ = (M × Ω + N × V; N × Ω)
    m, n = wrench[:3], wrench[3:]
    expected = np.concatenate([np.cross(m, x[:3]) + np.cross(n, x[3:]), np.cross(n, x[:3])])
    np.testing.assert_allclose(se3.coad(x) @ wrench, expected, atol=1e-9)
    np.testing.assert_allclose((se3.coad(x) @ wrench) @ y, wrench @ (se3.ad(x) @ y), atol=1e-7)


@given(twists, twists)
def test_right_tangent_is_the_body_twist_of_a_varied_exponential(x, dx):
    h = 1e-6 / (1 + np.linalg.norm(dx))
    change = se3.inverse(se3.exp(x - h * dx)) @ se3.exp(x + h * dx)
    quotient = se3.log(change) / (2 * h)
    exact = se3.right_tangent(x) @ dx
    np.testing.assert_allclose(quotient, exact, atol=2e-6 * (1 + np.abs(exact).max()))


@given(twists)
def test_left_tangent_is_the_right_one_seen_from_the_other_frame(x):
    np.testing.assert_allclose(
        se3.left_tangent(x),
        se3.Ad(se3.exp(x)) @ se3.right_tangent(x),
        atol=1e-9 * (1 + np.abs(x).max() ** 2),
    )


@given(twists, twists)
def test_inverse_and_adjoint_are_homomorphisms(x, y):
    g, h = se3.exp(x), se3.exp(y)
    np.testing.assert_allclose(se3.inverse(g) @ g, np.eye(4), atol=1e-11)
    product = se3.Ad(g) @ se3.Ad(h)
    np.testing.assert_allclose(se3.Ad(g @ h), product, atol=1e-11 * (1 + np.abs(product).max()))
