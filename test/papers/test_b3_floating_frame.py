"""B-3: links in a floating frame, against (3.31)–(3.36) by themselves, and against rods."""

from dataclasses import replace

import by_hand
import numpy as np
import pytest
import scipy
import yaml
from floating_links import LENGTH, LINE, MATERIAL, RHO, SECOND, STRIP, E, document, link
from scenes import scene_of
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.link_modes import Modes, modes_of
from soft_sim_ros.core.compile.moments import concentrated
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene

ROOTS = np.array([1.8751040687, 4.6940911330])  # cos x cosh x = −1


def beam(root, x):
    """Return the clamped–free mode of Euler and Bernoulli and its slope, 1 at the tip."""
    ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
    z = root * x
    shape = np.cosh(z) - np.cos(z) - ratio * (np.sinh(z) - np.sin(z))
    slope = root * (np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z)))
    return 0.5 * shape, 0.5 * slope


# axis of displacement, root and sign at the tip, in the order of the link's coordinates: about y, z
SORTED = [(2, ROOTS[0], 1), (1, ROOTS[0], 1), (2, ROOTS[1], -1), (1, ROOTS[1], -1)]


def quadrature():
    x, w = np.polynomial.legendre.leggauss(40)
    return 0.5 * (x + 1.0) * LENGTH, 0.5 * w * LENGTH * LINE


def fields():
    """Return X (N, 3), Φ (N, 3, 4) of Euler and Bernoulli's beam, dm (N,)."""
    x, dm = quadrature()
    phi = np.zeros((len(x), 3, 4))
    for j, (axis, root, sign) in enumerate(SORTED):
        phi[:, axis, j] = sign * beam(root, x / LENGTH)[0]
    return np.stack([x, 0 * x, 0 * x], 1), phi, dm


def hats(r):
    return np.cross(np.eye(3), r[..., None, :]).swapaxes(-1, -2) * -1.0


@pytest.mark.parametrize("tip", ["free", "pinned"])
@pytest.mark.parametrize("strain", ["torsion", "bend_y", "bend_z", "stretch"])
def test_a_link_that_lacks_strains_gives_no_empty_matrix_to_scipy(strain, tip, monkeypatch):
    """Versions before 1.12 refuse them."""

    def with_size(function):
        def checked(*matrices):
            assert all(np.size(matrix) > 0 for matrix in matrices)
            return function(*matrices)

        return checked

    for name in ("null_space", "eigh"):
        monkeypatch.setattr(scipy.linalg, name, with_size(getattr(scipy.linalg, name)))
    more = {"tip": "pinned"} if tip == "pinned" else {}
    body = link(strains=[strain], modes=2, **more)
    modes = Modes(parse_scene(yaml.safe_dump(document([body]))).bodies[0])
    assert np.all(modes.frequencies > 0.0) and len(modes.frequencies) == 2


def test_modes_are_those_of_euler_and_bernoulli():
    modes = Modes(parse_scene(yaml.safe_dump(document([link()]))).bodies[0])
    expected = ROOTS.repeat(2) ** 2 * np.sqrt(E * SECOND / LINE) / LENGTH**2
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-7)
    x = np.linspace(0, LENGTH, 9)
    turn, shift = modes.fields(x)
    for j, (axis, root, sign) in enumerate(SORTED):
        shape, slope = beam(root, x / LENGTH)
        np.testing.assert_allclose(shift[:, axis, j], sign * shape, atol=1e-6)
        about = turn[:, 2, j] if axis == 1 else -turn[:, 1, j]
        np.testing.assert_allclose(about, sign * slope / LENGTH, atol=2e-5)


def test_modes_are_made_once_whatever_the_numerics_and_for_every_link_anew():
    """What is remembered belongs to one link, equals a new computation, and cannot be changed."""
    scene = parse_scene(yaml.safe_dump(document([link()])))
    body = scene.bodies[0]
    known = Dynamics(scene).compiled.chain.links[body.name].modes
    finer = replace(scene, numerics=replace(scene.numerics, step=1e-4))
    assert Dynamics(finer).compiled.chain.links[body.name].modes is known
    other = parse_scene(yaml.safe_dump(document([link()]))).bodies[0]
    assert modes_of(other) is not known
    fresh = Modes(body)
    for s in (np.linspace(0.0, LENGTH, 5), np.linspace(0.0, 0.5 * LENGTH, 5)):
        for _ in range(2):
            for one, two in zip(known.fields(s), fresh.fields(s), strict=True):
                np.testing.assert_array_equal(one, two)
                with pytest.raises(ValueError, match="read-only"):
                    one[...] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        known.stiffness[...] = 0.0


def test_modes_of_each_kind_can_be_asked_for():
    """Torsion: odd multiples of π/2 √(G/ρ)/L; its angle times the length is the coordinate."""
    body = link(strains=["torsion", "bend_y", "bend_z"], modes={"torsion": 2, "bend_z": 1})
    modes = Modes(parse_scene(yaml.safe_dump(document([body]))).bodies[0])
    twist = np.array([1.0, 3.0]) * np.pi / 2 * np.sqrt(E / 2.6 / RHO) / LENGTH
    bend = ROOTS[0] ** 2 * np.sqrt(E * SECOND / LINE) / LENGTH**2
    np.testing.assert_allclose(modes.frequencies, [bend, *twist], rtol=1e-3)
    turn, _ = modes.fields(np.array([LENGTH]))
    np.testing.assert_allclose(np.abs(turn[0, 0, 1:]), 1.0 / LENGTH, rtol=1e-6)


def test_a_held_tip_and_a_mass_there_change_the_modes():
    """Clamped–pinned: tan x = tanh x. Clamped with a heavy tip: √(3EI/(M + 33/140 m)L³)."""
    pinned, loaded = (
        Modes(parse_scene(yaml.safe_dump(document([link(strains=["bend_z"], **more)]))).bodies[0])
        for more in ({"tip": "pinned"}, {"tip_mass": 3.0})
    )
    unit = np.sqrt(E * SECOND / LINE) / LENGTH**2
    np.testing.assert_allclose(
        pinned.frequencies[:2] / unit, np.square([3.926602, 7.068583]), rtol=1e-6
    )
    rayleigh = np.sqrt(3 * E * SECOND / (3.0 + 33 / 140 * LINE * LENGTH) / LENGTH**3)
    assert loaded.frequencies[0] == pytest.approx(rayleigh, rel=1e-4)


def test_generalised_newton_euler_model_is_that_of_the_paper():
    """𝓙 of (3.31) and the bias of (3.33), misprints mended, at a bent and fast state."""
    scene = document([{"joint": "base", "kind": "free"}, link()])
    dynamics = Dynamics(scene_of(scene))
    rng = np.random.default_rng(1)
    omega, speed = rng.normal(size=(2, 3)) * 3.0
    q, rate = 0.2 * rng.normal(size=4), rng.normal(size=4)
    x, phi, dm = fields()
    r = x + phi @ q
    rotary = np.diag([2.0, 1.0, 1.0]) * RHO * SECOND * LENGTH  # of sections, in the frame
    hat, hat_phi = hats(r), np.stack([hats(phi[:, :, j]) for j in range(4)], 1)

    def integral(values):
        return np.tensordot(dm, values, 1)

    inertia = integral(hat.swapaxes(1, 2) @ hat) + rotary
    ms, a = integral(r), integral(phi)
    beta = integral(np.cross(r[:, :, None], phi, axis=1))
    m = integral(np.einsum("nca,ncb->nab", phi, phi))
    whole = np.block([
        [inertia, hats(ms), beta],
        [hats(ms).T, LINE * LENGTH * np.eye(3), a],
        [beta.T, a.T, m],
    ])  # fmt: skip
    state = np.concatenate([np.zeros(6), q])
    np.testing.assert_allclose(dynamics.mass_matrix(state), whole, atol=2e-6)

    j_r = integral(np.einsum("nba,nmbc->nmac", hats(x), hat_phi))  # J_re,α = ∫ X̂ᵀ Φ̂_α
    j_e = integral(np.einsum("nkba,nmbc->nkmac", hat_phi, hat_phi))  # J_ee,βα = ∫ Φ̂_βᵀ Φ̂_α
    lam = integral(np.cross(phi[:, :, :, None], phi[:, :, None, :], axis=1))  # λ_αβ = Φ_α × Φ_β
    turn = np.cross(omega, inertia @ omega)
    turn += 2.0 * np.einsum("mab,b,m->a", j_r, omega, rate)
    turn += 2.0 * np.einsum("kmab,b,k,m->a", j_e, omega, q, rate)
    shift = 2.0 * np.cross(omega, a @ rate) + np.cross(omega, np.cross(omega, ms))
    stiff = E * SECOND * ROOTS.repeat(2) ** 4 / LENGTH**3 * np.diag(m) / LINE / LENGTH
    modal = -np.einsum("mab,a,b->m", j_r, omega, omega)
    modal -= np.einsum("kmab,a,b,k->m", j_e, omega, omega, q)
    modal += -2.0 * np.einsum("cab,b,c->a", lam, rate, omega) + stiff * q
    found = dynamics.inverse_dynamics(state, np.concatenate([omega, speed, rate]), np.zeros(10))
    expected = np.concatenate([turn, shift, modal])
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    weight = Dynamics(scene_of(scene | {"gravity": [0.0, -4.0, -9.0]})).gravity_force(state)
    pull = -np.array([0.0, -4.0, -9.0])
    by_paper = np.concatenate([np.cross(ms, pull), LINE * LENGTH * pull, a.T @ pull])
    np.testing.assert_allclose(weight, by_paper, atol=1e-5)


def points(q, masses):
    """World positions of mass points of two hinged links and a payload: B (3.24)–(3.26)."""
    frame, origin, out, at = np.eye(3), np.zeros(3), [], 0
    for axis in ([0.0, 0.0, 1.0], [0.2, 1.0, -0.4]):
        axis = np.array(axis) / np.linalg.norm(axis)
        frame = frame @ Rotation.from_rotvec(q[at] * axis).as_matrix()
        own = q[at + 1 : at + 5]
        phi, turn = np.zeros((len(masses), 3)), np.zeros(3)
        for value, (direction, root, sign) in zip(own, SORTED, strict=True):
            phi[:, direction] += sign * value * beam(root, masses / LENGTH)[0]
            slope = sign * value * beam(root, 1.0)[1] / LENGTH
            turn += slope * (np.array([0, 0, 1.0]) if direction == 1 else np.array([0, -1.0, 0]))
        out.append(origin + (np.stack([masses, 0 * masses, 0 * masses], 1) + phi) @ frame.T)
        tip = np.array([LENGTH, 0, 0]) + phi[-1]
        origin, frame = origin + frame @ tip, frame @ Rotation.from_rotvec(turn).as_matrix()
        at += 5
    return np.concatenate([*out, origin[None] + (frame @ [0.1, 0.05, 0.0])[None]])


def test_chain_of_links_obeys_newton_point_by_point():
    """(3.34)–(3.36): two hinged links and a payload, as mass points whose motion is known."""
    payload = 0.3
    bodies = [
        {"joint": "one", "kind": "revolute", "axis": [0, 0, 1]}, link("first"),
        {"joint": "two", "kind": "revolute", "axis": [0.2, 1.0, -0.4]}, link("second"),
        {"rigid_body": "load", "mass": payload, "com": {"position": [0.1, 0.05, 0.0]}},
    ]  # fmt: skip
    gravity = np.array([0.5, -2.0, -9.0])
    dynamics = Dynamics(scene_of(document(bodies, gravity=gravity)))
    rng = np.random.default_rng(3)
    q, v, a = rng.normal(size=(3, 10)) * np.tile([1.0] + 4 * [0.1], 2)
    # Gauss–Lobatto by its definition: the extremes of a Legendre polynomial, and the ends
    inner = np.polynomial.legendre.Legendre.basis(11).deriv().roots()
    x = np.concatenate([[-1.0], np.sort(inner), [1.0]])
    w = 2.0 / (12 * 11 * np.polynomial.legendre.Legendre.basis(11)(x) ** 2)
    masses = 0.5 * (x + 1.0) * LENGTH
    dm = np.concatenate([np.tile(0.5 * w * LENGTH * LINE, 2), [payload]])
    times = by_hand.STEP * np.arange(-4, 5)
    past = np.array([points(q + v * t + 0.5 * a * t * t, masses) for t in times])
    push = dm[:, None] * (np.tensordot(by_hand.SECOND, past, 1) / by_hand.STEP**2 - gravity)
    expected = np.zeros(10)
    for j in range(10):
        unit = np.eye(10)[j]
        column = by_hand.rate_of(lambda t, unit=unit: points(q + t * unit, masses))
        expected[j] = np.sum(column * push)
    found = dynamics.inverse_dynamics(q, v, a) - dynamics.elastic_force(q)
    # rotary inertia of the sections turns with the frames; points have none
    slim = 3.0 * RHO * SECOND * LENGTH * np.abs(a).max() * 4
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max() + slim)


def test_tangents_are_derivatives():
    bodies = [
        {"joint": "b", "kind": "spherical"},
        link(strains=["torsion", "bend_y", "bend_z"], modes=5),
        {"rigid_body": "p", "mass": 1.0, "inertia": [1, 1, 1]},
    ]
    dynamics = Dynamics(scene_of(document(bodies, gravity=[1, 2, -9])))
    motion = np.random.default_rng(5).normal(size=(3, dynamics.n)) * ([1] * 3 + [0.2] * 5)
    for i, found in enumerate(dynamics.tangents(*motion)):
        for j in range(dynamics.n):

            def shifted(size, i=i, j=j):
                moved = [x.copy() for x in motion]
                moved[i][j] += size
                return dynamics.inverse_dynamics(*moved)

            scale = np.abs(found).max()
            np.testing.assert_allclose(found[:, j], by_hand.rate_of(shifted), atol=1e-7 * scale)


def tips(force, **kinds):
    """Static tip positions of a clamped link and of the rod it comes from under a tip force."""
    rod = {"rod": "link", "strains": ["bend_y", "bend_z"], "sections": [STRIP]}
    out = []
    for body in (link(), rod):
        load = {"point": "p", "body": "link", "force": [0.0, 0.0, force]}
        numerics = {"basis": {"order": 7}} if body is rod else {}
        dynamics = Dynamics(scene_of(document([body], loads=[load], numerics=numerics)))
        out.append(dynamics.node_poses(equilibrium(dynamics))[-1][:3, 3])
    return out


def test_link_and_rod_part_with_the_square_of_the_strain():
    """Deflection w: shortening w² is missing at once, sideways the error is w³."""
    unit = 3 * E * SECOND / LENGTH**2
    deflections = np.array([0.02, 0.04, 0.08])
    apart = []
    for share in deflections:
        floating, exact = tips(share * unit)
        apart.append(np.abs(floating - exact) / LENGTH)
    apart = np.array(apart)
    # axial: the exact beam comes back by 3/5 w²; sideways: modes are four, so 3 % of w are missing
    np.testing.assert_allclose(apart[:, 0], 0.6 * deflections**2, rtol=0.05)
    assert np.all(apart[:, 2] < 0.03 * deflections)


def test_small_motions_of_link_and_rod_agree():
    """Two hinged bodies with small strains, the second turned out of plane: the same swing."""
    ends = []
    for kind in ("link", "rod"):
        bodies = []
        for i, axis in enumerate(([0, 1, 0], [0, 0.6, 0.8])):
            bodies.append({"joint": f"j{i}", "kind": "revolute", "axis": axis})
            body = link(f"b{i}", modes=4)
            if kind == "rod":
                body = {"rod": f"b{i}", "strains": ["bend_y", "bend_z"], "sections": [STRIP]}
            bodies.append(body)
        basis = {"basis": {"order": 5}} if kind == "rod" else {}
        stiff = {"m": MATERIAL["m"] | {"young_modulus": 1e12, "shear_modulus": 4e11,
                                       "viscosity": 1e8}}  # fmt: skip
        simulation = Simulation(scene_of(document(
            bodies, materials=stiff, gravity=[0, 0, -9.81],
            initial={"positions": {"j1": 0.7}},
            numerics={"step": 0.002, "integrator": "sdirk4"} | basis,
        )))  # fmt: skip
        simulation.advance(250)
        ends.append(simulation.dynamics.node_poses(simulation.q)[-1])
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-3)
    assert np.linalg.norm(ends[0][:3, 3] - [2 * LENGTH, 0, 0]) > 0.5


def rotating_frequencies(body, spin):
    """Squared frequencies (rad²/s²) in the plane and across, of a blade turning about z."""
    bodies = [{"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]}, body]
    numerics = {"basis": {"order": 7}} if "rod" in body else {}
    dynamics = Dynamics(scene_of(document(bodies, numerics=numerics)))
    v = np.zeros(dynamics.n)
    v[0] = spin
    tangents = dynamics.tangents(np.zeros(dynamics.n), v, np.zeros(dynamics.n))
    values, shapes = eigh(0.5 * (tangents[0] + tangents[0].T)[1:, 1:], tangents[2][1:, 1:])
    tip = dynamics.tip_jacobian(np.zeros(dynamics.n))[:, 1:] @ shapes
    plane = np.abs(tip[4]) > np.abs(tip[5])
    return values[plane][0], values[~plane][0]


def test_floating_frame_lacks_centrifugal_stiffening():
    """Southwell: a blade gains 0.193 Ω² in the plane, 1.193 Ω² across; linear modes −Ω², 0."""
    rest = (ROOTS[0] / LENGTH) ** 4 * E * SECOND / LINE
    spin = 0.5 * np.sqrt(rest)
    blade = {"rod": "link", "strains": ["bend_y", "bend_z"], "sections": [STRIP]}
    for body, expected in ((blade, (0.193, 1.193)), (link(), (-1.0, 0.0))):
        gain = (np.array(rotating_frequencies(body, spin)) - rest) / spin**2
        np.testing.assert_allclose(gain, expected, atol=5e-3)


def test_sampled_frames_lie_on_the_deformed_link():
    initial = {"positions": {"link": [0.02] * 4}}
    simulation = Simulation(scene_of(document([link()], initial=initial)))
    poses = simulation.sampler(9).poses()
    nodes = simulation.compiled.chain.links["link"].rest[:, 0]
    for s, pose in zip(np.linspace(0, LENGTH, 9), poses, strict=True):
        expected, turn = np.array([s, 0.0, 0.0]), np.zeros(3)
        for axis, root, sign in SORTED:
            shape, slope = beam(root, s / LENGTH)
            expected[axis] += 0.02 * sign * shape
            turn[3 - axis] += (1 if axis == 1 else -1) * 0.02 * sign * slope / LENGTH
        # one exponential for shift and turn: θ² d/12 off, between nodes d apart
        apart = np.abs(nodes - s).min()
        assert np.abs(pose[:3] - expected).max() < 1.1 * turn @ turn * apart / 12 + 1e-6
        found = Rotation.from_quat(pose[3:]).as_rotvec()
        np.testing.assert_allclose(found, turn, atol=1e-5)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"modes": 0}, "modes = 0"),
        ({"modes": {"bend_z": 2, "torsion": 1}}, "modes.torsion = 1: expected a known key"),
        ({"modes": {"bend_z": 0}}, "1 to 30 modes in all"),
        ({"strains": ["torsion"], "rotary_inertia": False}, "torsion moves nothing but rotary"),
        ({"tip": "loose"}, "tip = loose: expected one of free, pinned"),
        ({"sections": [STRIP | {"reference": {"curvature": [0, 0, 1]}}]}, "link is straight"),
        ({"model": "string"}, "model = string: expected a known key"),
    ],
)  # fmt: skip
def test_bad_links_are_refused(more, message):
    with pytest.raises(SceneError, match=message):
        parse_scene(yaml.safe_dump(document([link() | more])))


# -- few masses for many -------------------------------------------------------------------


def test_concentrated_masses_of_a_uniform_bar_and_of_polynomials():
    """3/4 of a bar at 2/3 of its length; where no function has a mean, the rule of Gauss."""
    x, w = np.polynomial.legendre.leggauss(20)
    mass, at = concentrated(0.5 * (x[:, None] + 1.0), 0.5 * w, x)
    np.testing.assert_allclose([mass, at[:, 0]], [[0.75], [2 / 3]], rtol=1e-14)
    basis = [np.polynomial.legendre.Legendre.basis(i)(x) for i in (1, 2, 3)]
    mass, at = concentrated(np.stack(basis, axis=1), w, x)
    points, weights = np.polynomial.legendre.leggauss(4)
    np.testing.assert_allclose(at[:, 0], points, atol=1e-14)
    np.testing.assert_allclose(mass, weights, atol=1e-14)


@pytest.mark.parametrize(
    ("more", "most"),
    [
        ({"modes": {"bend_y": 5, "bend_z": 5}}, 6),
        ({"modes": {"torsion": 2, "bend_y": 2, "bend_z": 4}, "tip": "pinned",
          "strains": ["torsion", "bend_y", "bend_z"]}, 8),
        ({"modes": 12, "strains": ["torsion", "bend_y", "bend_z", "stretch"], "sections": [
            STRIP | {"cross_section": {"shape": "circle", "radius": [0.02, 0.004]}},
            STRIP | {"name": "t", "length": 0.5 * LENGTH,
                     "cross_section": {"shape": "rectangle", "width_y": 0.004, "width_z": 0.01}},
        ]}, 13),
    ],
)  # fmt: skip
def test_few_masses_have_all_integrals_of_the_modes(more, most):
    """Every integral of (3.31), (3.33), by a rule of 60 points a section, to round-off."""
    document_ = document([link(**more)])
    body = parse_scene(yaml.safe_dump(document_)).bodies[0]
    modes, dynamics = Modes(body), Dynamics(scene_of(document_))
    (own,) = dynamics.compiled.chain.links.values()
    lumps = dynamics.model.inertia
    assert len(own.nodes) - 2 <= most
    x, w = np.polynomial.legendre.leggauss(60)
    total = []
    for section, begin in zip(body.rod.sections, body.rod.boundaries, strict=False):
        s = 0.5 * (x + 1.0)
        density = section.inertia(s) * (0.5 * w * section.length)[:, None]
        total.append((begin + s * section.length, density))
    s, inertia = (np.concatenate(parts) for parts in zip(*total, strict=True))
    turn, shift = modes.fields(s)

    def table(fields, mass):
        """Return ∫ f fᵀ dm, 1 among the f, over the sizes of the f."""
        f = np.column_stack([np.ones(len(mass)), *fields])
        found = f.T @ (mass[:, None] * f)
        return found

    exact = table([s, shift.reshape(len(s), -1)], inertia[:, 0])
    few = table([own.rest[:, 0], own.shift.reshape(len(own.rest), -1)], lumps[own.nodes, 0])
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact))) + 1e-300
    assert np.abs((few - exact) / size).max() < 1e-10
    # rotary inertia: the Jacobian of the nodes at rest says how they turn
    turning = dynamics.jacobians(np.zeros(dynamics.n), np.zeros(dynamics.n))[0][:, :3]
    for axis in range(3):
        rotary = body.rotary_inertia
        exact = table([turn[:, axis] * rotary], inertia[:, 1 + axis])
        few = table([turning[:, axis]], lumps[:, 1 + axis])
        size = np.sqrt(np.outer(np.diag(exact), np.diag(exact))) + 1e-300
        assert np.abs((few - exact) / size).max() < 1e-10
    assert lumps.min() >= 0.0
