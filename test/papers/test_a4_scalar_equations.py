"""A §4: scalar equations by computer algebra, for any rotation sequence and reference curve."""

import subprocess
import sys
from itertools import product

import numpy as np
import pytest
from scenes import rod
from scipy.spatial.transform import Rotation

from soft_sim_ros.commands.derive import main
from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import field
from soft_sim_ros.errors import DeriveError, MissingExtra

sympy = pytest.importorskip("sympy")
from soft_sim_ros.derive import as_latex, as_python, derive, unknowns  # noqa: E402

SEQUENCES = ["".join(x) for x in product("xyz", repeat=3) if x[0] != x[1] and x[1] != x[2]]
GENERATORS = {
    axis: np.array([np.cross(e, row) for row in np.eye(3)]).T
    for axis, e in zip("xyz", np.eye(3), strict=True)
}


def vee(m):
    return np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / 2


def turn(axis, angle):
    return Rotation.from_rotvec(angle * np.eye(3)["xyz".index(axis)]).as_matrix()


def rotation_jet(sequence, angles, rates, accelerations):
    """Return R, Ṙ, R̈ (3, 3) of three turns by the product rule, from generators alone."""
    value, first, second = np.eye(3), np.zeros((3, 3)), np.zeros((3, 3))
    for axis, angle, rate, acceleration in zip(sequence, angles, rates, accelerations, strict=True):
        r, g = turn(axis, angle), GENERATORS[axis]
        r1 = rate * r @ g
        r2 = acceleration * r @ g + rate**2 * r @ g @ g
        second = second @ r + 2.0 * first @ r1 + value @ r2
        first = first @ r + value @ r1
        value = value @ r
    return value, first, second


def random_point(seed):
    rng = np.random.default_rng(seed)
    groups = {name: rng.normal(size=len(group)) for name, group in unknowns.GROUPS.items()}
    groups["inertia"] = rng.uniform(0.5, 2.0, size=4)
    return groups


def numerical_residual(sequence, xi0, g):
    """The field residual of C-1 at one point, its arguments by matrix calculus."""
    none = np.zeros(3)
    p, p_s, p_t, p_tt = (g[k][:3] for k in ("unknowns", "slopes", "rates", "accelerations"))
    angles, rates, seconds = (g[k][3:] for k in ("unknowns", "rates", "accelerations"))
    r, r_t, r_tt = rotation_jet(sequence, angles, rates, seconds)
    r_s = rotation_jet(sequence, angles, g["slopes"][3:], none)[1]
    k0, g0 = xi0[:3], xi0[3:]
    strain = np.concatenate([vee(r.T @ r_s) + r.T @ k0, r.T @ (p_s + g0 + np.cross(k0, p))])
    twist = np.concatenate([vee(r.T @ r_t), r.T @ p_t])
    acceleration = np.concatenate([vee(r.T @ r_tt + r_t.T @ r_t), r.T @ p_tt + r_t.T @ p_t])
    inertia = np.concatenate([g["inertia"][:3], [g["inertia"][3]] * 3])
    left = field.balance_residual(
        strain, g["wrench"], g["wrench_slope"], inertia, twist, acceleration, g["load"]
    )
    return left, (strain, twist, acceleration)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_six_equations_are_the_numerical_residual(sequence):
    derivation = derive(sequence, "general")
    assert len(derivation.equations) == 6
    function = derivation.function()
    names = [str(symbol) for symbol in unknowns.REFERENCE]
    for seed in range(3):
        g = random_point(seed)
        xi0 = np.random.default_rng(seed + 10).normal(size=6)
        expected, _ = numerical_residual(sequence, xi0, g)
        found = function(*g.values(), **dict(zip(names, xi0, strict=True)))
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("inverse", [True, False])
def test_item_7_needs_the_inverse_rotation(inverse):
    """e^c = Ad(D)⁻¹ Σ Aᵢ ωᵢ with (Ad(exp(−ψᵢρⁱ)) − 1) ω; as printed, exp(+ψᵢρⁱ), it fails."""
    g, xi0 = random_point(6), np.random.default_rng(7).normal(size=6)
    xi0[:3] *= 0.5
    p, angles, slopes = g["unknowns"][:3], g["unknowns"][3:], g["slopes"]
    shift = np.concatenate([np.zeros(3), p])
    carried = se3.Ad(se3.exp(shift))
    # item 6 for u: ∂u/∂σ = uᵢ′ + [ω, u]
    total = carried @ (np.concatenate([np.zeros(3), slopes[:3]]) + se3.ad(xi0) @ shift)
    for axis, angle, slope in zip("zyx", angles, slopes[3:], strict=True):
        screw = np.concatenate([np.eye(3)["xyz".index(axis)], np.zeros(3)])
        carried = carried @ se3.Ad(se3.exp(angle * screw))
        turned = se3.Ad(se3.exp((-angle if inverse else angle) * screw)) @ xi0
        total = total + carried @ (slope * screw + turned - xi0)
    found = np.linalg.solve(carried, total)
    strain = numerical_residual("zyx", xi0, g)[1][0]
    assert (np.abs(found - (strain - xi0)).max() < 1e-12) == inverse


def test_a_reference_given_as_functions_of_arc_length():
    """A helix-like curve whose curvature grows, and a stretch that does, too."""
    derivation = derive("xzy", "1/tau, 0, s*k, 1 + s, 0, 0")
    assert [str(p) for p in derivation.parameters] == ["k", "s", "tau"]
    g = random_point(4)
    found = derivation.function()(*g.values(), s=0.3, tau=2.0, k=1.5)
    xi0 = np.array([0.5, 0.0, 0.45, 1.3, 0.0, 0.0])
    expected, _ = numerical_residual("xzy", xi0, g)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_a_discrete_solution_satisfies_the_scalar_equations():
    """An equilibrium of the solver, in the paper's variables: what is left is that of C-1."""
    dynamics = rod(order=9, nodes=60, gravity=(1.0, 2.0, -9.8))
    (part,) = field.fields(dynamics, equilibrium(dynamics))
    shift = part.pose[:, :3, 3] - np.outer(part.s, [1.0, 0.0, 0.0])
    angles = Rotation.from_matrix(part.pose[:, :3, :3]).as_euler("ZYX")
    state = np.concatenate([shift, angles], axis=1)
    zero = np.zeros_like(state.T)
    inertia = np.stack([*part.inertia[:, :3].T, part.inertia[:, 3]])
    found = derive("zyx").function()(
        state.T,
        (part.slope @ state).T,
        zero,
        zero,
        part.wrench.T,
        (part.slope @ part.wrench).T,
        inertia,
        part.load.T,
    )
    expected = field.residuals(part).balance
    np.testing.assert_allclose(found.T, expected, atol=1e-5 * np.abs(part.load).max())


# The printed example: rotations zyx, straight reference, the moment about i₁

c1, c2, c3, s1, s2, s3 = sympy.symbols("c1 c2 c3 s1 s2 s3")
x_s, y_s, z_s, p1_s, p2_s, p3_s = unknowns.SLOPE
p1_t, p2_t, p3_t = unknowns.RATE[3:]
p1_tt, p2_tt, p3_tt = unknowns.ACCELERATION[3:]
t1, t2, t3, t4, t5, t6 = (*unknowns.WRENCH[3:], *unknowns.WRENCH[:3])  # its θ: forces first
I11, I22, I33, _ = unknowns.INERTIA  # ρ I
# term: (printed, as it should be)
PRINTED = {
    "z'": ((t3 * c2 * s3 - t2 * c2 * c3) * z_s, (t3 * c2 * s3 - t2 * c2 * c3) * z_s),
    "y'": (
        (t3 * (c1 * c3 + s1 * s2) + t2 * (c1 * s3 - c3 * s1 * s2)) * y_s,
        (t3 * (c1 * c3 + s1 * s2 * s3) + t2 * (c1 * s3 - c3 * s1 * s2)) * y_s,
    ),
    "x'": (
        t3 * (c1 * s2 - c3 * s1) - t2 * (c1 * c3 * s2 + s1 * s3) * x_s,
        (t3 * (c1 * s2 * s3 - c3 * s1) - t2 * (c1 * c3 * s2 + s1 * s3)) * x_s,
    ),
    "rate": (
        I11 * (p3_tt - p2_t**2 * c2 - p1_tt * s2),
        -I11 * (p3_tt - p1_t * p2_t * c2 - p1_tt * s2),
    ),
    "gyroscopic": (
        (I22 - I33) * (p2_t**2 * c2 * (s3**2 - c3**2) + p2_t**2 - p1_t**2 * c2**2 * c3 * s3),
        -(I22 - I33) * (p1_t * p2_t * c2 * (s3**2 - c3**2) + (p2_t**2 - p1_t**2 * c2**2) * c3 * s3),
    ),
    "force": (
        -t2 * (c1 * s2 + s1 * s3) + t3 * (c1 * s2 - c3 * s1),
        -t2 * (c1 * s2 * c3 + s1 * s3) + t3 * (c1 * s2 * s3 - c3 * s1),
    ),
    "moment": (
        t5 * (p2_s - c2 * p1_s) + t6 * (p2_s + c2 * p1_s),
        t5 * (s3 * p2_s - c2 * c3 * p1_s) + t6 * (c3 * p2_s + c2 * s3 * p1_s),
    ),
    "slope": (unknowns.WRENCH_SLOPE[0], unknowns.WRENCH_SLOPE[0]),
}


def derived_terms():
    """Return the terms of our first equation under the names of PRINTED, as −T₄ + … = 0."""
    angles = dict(zip(("psi1", "psi2", "psi3"), unknowns.VALUE[3:], strict=True))
    short = {}
    for i, angle in enumerate(angles.values()):
        short[sympy.cos(angle)], short[sympy.sin(angle)] = (c1, c2, c3)[i], (s1, s2, s3)[i]
    whole = -derive("zyx").equations[0].xreplace(short) - unknowns.LOAD[0]
    rest = {name: sympy.Integer(0) for name in PRINTED}
    for term in sympy.Add.make_args(sympy.expand(whole)):
        if term.has(x_s, y_s, z_s):
            name = next(n for n, s in (("x'", x_s), ("y'", y_s), ("z'", z_s)) if term.has(s))
        elif term.has(I11) and not term.has(I22, I33):
            name = "rate"
        elif term.has(I22, I33):
            name = "gyroscopic"
        elif term.has(t5, t6):
            name = "moment"
        elif term.has(t2, t3):
            name = "force"
        else:
            name = "slope"
        rest[name] += term
    return rest


def squares_resolved(expression):
    """Return an expression reduced by s² + c² = 1."""
    for s, c in ((s1, c1), (s2, c2), (s3, c3)):
        expression = sympy.expand(expression).subs(s**2, 1 - c**2)
    return sympy.expand(expression)


@pytest.mark.parametrize("term", PRINTED)
def test_the_printed_example_term_by_term(term):
    """Ours is the corrected term; what is printed differs except where docs/theory.md says so."""
    printed, corrected = PRINTED[term]
    ours = derived_terms()[term]
    assert squares_resolved(ours - corrected) == 0
    right = {"z'", "slope"}
    assert (squares_resolved(ours - printed) == 0) == (term in right)


def test_a_planar_motion_gives_the_classical_beam():
    """ψ about z only: Γ + dM/dσ + T = 0 and its kin of A §3, for a straight line."""
    derivation = derive("zyx")
    planar = {v: 0 for v in unknowns.VALUE + unknowns.SLOPE + unknowns.RATE}
    planar |= dict.fromkeys(unknowns.ACCELERATION, 0)
    moment, force_x, force_y = (derivation.equations[i].subs(planar) for i in (2, 3, 4))
    w, f = unknowns.WRENCH_SLOPE, unknowns.LOAD
    assert sympy.expand(moment + w[2] + unknowns.WRENCH[4] + f[2]) == 0
    assert sympy.expand(force_x + w[3] + f[3]) == 0
    assert sympy.expand(force_y + w[4] + f[4]) == 0


# What comes out


@pytest.mark.parametrize("reference", ["straight", "0, 0, 1/R"])
def test_the_numpy_module_needs_numpy_only_and_gives_the_same_numbers(tmp_path, reference):
    derivation = derive("zxz", reference)
    source = as_python(derivation)
    assert "sympy" not in source
    names: dict = {}
    exec(compile(source, "derived.py", "exec"), names)
    g = random_point(3)
    extra = {"R": 0.7} if derivation.parameters else {}
    expected = derivation.function()(*g.values(), **extra)
    np.testing.assert_allclose(names["residual"](**g, **extra), expected, atol=1e-12)
    many = {name: np.stack([row, row], axis=1) for name, row in g.items()}
    assert names["residual"](**many, **extra).shape == (6, 2)


def test_latex_balances_and_uses_the_papers_letters():
    text = as_latex(derive("zyx"))
    assert text.count("0 &=") == 6 and r"\begin{align}" in text
    assert text.count("{") == text.count("}")
    for piece in (r"\ddot{\psi}_{3}", r"\dot{\psi}_{1}", r"\psi_{2}'", "c_{1}", "s_{3}", "M_{x}'"):
        assert piece in text


def test_the_verb_writes_files(tmp_path, capsys):
    latex, python = tmp_path / "rod.tex", tmp_path / "rod.py"
    arguments = ["--rotations", "xyz", "--latex", str(latex), "--python", str(python)]
    assert main(arguments) == 0
    assert capsys.readouterr().out.split() == [str(latex), str(python)]
    assert "rotations xyz" in latex.read_text() and "def residual(" in python.read_text()
    assert main([]) == 0
    assert capsys.readouterr().out.count(": 0 = ") == 6


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"rotations": "zzx"}, "rotations"),
        ({"rotations": "zy"}, "rotations"),
        ({"rotations": "abc"}, "rotations"),
        ({"reference": "1, 2"}, "reference"),
        ({"reference": "1, 2, (("}, "reference"),
        ({"reference": "0, 0, psi1"}, "reference"),
        ({"reference": "0, 0, a.__class__"}, "reference"),
    ],
)
def test_bad_input_is_named(options, key, capsys):
    with pytest.raises(DeriveError) as caught:
        derive(**options)
    assert caught.value.key == key and str(caught.value).startswith(f"{key} = ")
    assert main([f"--{key}", options[key]]) == 2
    assert capsys.readouterr().err.startswith(f"error: {key} = ")


def test_without_sympy_the_extra_is_named(environment):
    code = (
        "import sys; sys.modules['sympy'] = None\n"
        "from soft_sim_ros.__main__ import main; sys.exit(main(['derive']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "soft_sim_ros[derive]" in done.stderr
    assert "sympy" in str(MissingExtra("x", "sympy", "derive"))
