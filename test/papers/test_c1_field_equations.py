"""C (1.9) and (1.20): a discrete solution, put into the equations of the continuum."""

import numpy as np
import pytest
from scenes import ALL, rod, rod_document, scene_of
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import field
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError

GRAVITY = (1.0, 2.0, -9.8)
LOADS = [
    {"point": "tip", "body": "rod", "force": [0.3, 0.5, -0.4], "moment": [0.02, 0.03, 0.05]},
    {"distributed": "wind", "body": "rod", "force": [0.5, 1.0, 0.3], "moment": [0.01, 0.0, 0.02]},
    {"distributed": "jet", "body": "rod", "force": [0.5, -1.0, 0.3], "moment": [0.05, 0.02, 0.01],
     "frame": "body"},
]  # fmt: skip
ACTUATORS = [
    {"moment": "bend", "rod": "rod", "section": "s", "strain": "bend_y"},
    {"tendon": "pull", "rod": "rod", "offset": {"from": [0.02, 0.01], "to": [0.01, -0.01]}},
]
EFFORTS = np.array([0.05, 2.0])
CURVED = {"reference": {"curvature": [0.5, [0.0, 2.0], -1.0]}}


def statics(**options):
    """Return the fields of an equilibrium with every load and actuator."""
    dynamics = rod(gravity=GRAVITY, loads=LOADS, actuators=ACTUATORS, section=CURVED, **options)
    return field.fields(dynamics, equilibrium(dynamics, efforts=EFFORTS), efforts=EFFORTS)


def motion(basis, step=0.002, time=0.1):
    """Return the fields of a viscous rod with a curved shape that falls, and is hit by loads."""
    document = rod_document(
        gravity=GRAVITY,
        loads=LOADS,
        actuators=ACTUATORS,
        section=CURVED,
        material={"viscosity": 3e3},
        numerics={"basis": basis, "integrator": "sdirk4", "step": step},
    )
    simulation = Simulation(scene_of(document))
    simulation.set_efforts(EFFORTS)
    simulation.advance(round(time / step))
    dynamics, (q, v) = simulation.dynamics, (simulation.q.copy(), simulation.v.copy())
    a = dynamics.forward_dynamics(q, v, EFFORTS, time)
    return field.fields(dynamics, q, v, a, efforts=EFFORTS, time=time)


def size(parts, of):
    """Return the root mean square of a quantity (N, 6) of each part."""
    length = sum(part.weights.sum() for part in parts)
    return np.sqrt(sum(part.weights @ of(part) ** 2 for part in parts) / length)


def slope(sizes, count):
    """Return the exponent of an error that falls with the number of elements."""
    return -np.polyfit(np.log(count), np.log(sizes), 1)[0]


def test_balance_of_an_equilibrium_falls_exponentially_with_the_order_of_the_basis():
    sizes = [field.norms(statics(order=p, nodes=60)).balance.max() for p in (2, 4, 6, 8, 10)]
    assert np.all(np.diff(np.log(sizes)) < -1.0)
    # the largest term of the balance, for scale
    largest = size(statics(order=8, nodes=60), lambda f: f.load).max()
    assert sizes[-1] < 1e-3 * largest


@pytest.mark.parametrize("order", [1, 2, 3])
def test_balance_of_an_equilibrium_falls_like_the_slope_of_the_strains(order):
    """ξ is right to h^(p+1), so Λ′ to h^p."""
    count = np.array([4, 8, 16])
    sizes = [field.norms(statics(order=order, elements=n)).balance.max() for n in count]
    assert slope(sizes, count) == pytest.approx(order, abs=0.35)


def test_kinematics_of_a_motion_fall_with_the_fourth_power_of_the_segment():
    """Whatever the strains are, (1.9) is met to the order of the Magnus step."""
    rng = np.random.default_rng(3)
    count = np.array([4, 8, 16])
    state = rng.normal(size=(3, 6, 2)) * [[2.0], [4.0], [4.0], [0.2], [0.2], [0.2]]
    errors = []
    for n in count:
        dynamics = rod(order=1, elements=int(n), nodes=6)
        # the same linear strains on every mesh
        q, v, a = (
            np.concatenate(
                [
                    np.stack([c[:, 0] + c[:, 1] * (2 * k + 1 - n) / n, c[:, 1] / n], axis=1).ravel()
                    for k in range(n)
                ]
            )
            for c in state
        )
        found = field.norms(field.fields(dynamics, q, v, a))
        errors.append([found.pose.max(), found.twist.max(), found.acceleration.max()])
    for column in np.array(errors).T:
        assert slope(column, count) > 3.7


def test_balance_of_a_moving_rod_falls_exponentially_with_the_order_of_the_basis():
    """A motion in space, with loads, actuators, viscosity and a curved reference shape."""
    sizes = [field.norms(motion({"order": p, "nodes": 30})).balance.max() for p in (3, 5, 7)]
    assert np.all(np.diff(np.log(sizes)) < -1.2)


@pytest.fixture(scope="module")
def moved():
    return motion({"order": 8, "nodes": 44})


def test_every_term_of_the_equations_counts(moved):
    """A flipped sign leaves twice its term: each is far larger than what is left."""
    left = field.norms(moved)
    kinematics = {
        "ξ": lambda f: f.strain,
        "η′": lambda f: f.slope @ f.twist,
        "ad_ξ η": lambda f: field.bracket(f.strain, f.twist),
        "ξ̇": lambda f: f.strain_rate,
        "η̇′": lambda f: f.slope @ f.acceleration,
        "ad_ξ̇ η": lambda f: field.bracket(f.strain_rate, f.twist),
        "ad_ξ η̇": lambda f: field.bracket(f.strain, f.acceleration),
        "ξ̈": lambda f: f.strain_acceleration,
    }
    worst = max(row.max() for row in left[:3])
    for name, term in kinematics.items():
        assert size(moved, term).max() > 100.0 * worst, name
    balance = {
        "𝓜 η̇": lambda f: f.inertia * f.acceleration,
        "ad_ηᵀ 𝓜 η": lambda f: field.cobracket(f.twist, f.inertia * f.twist),
        "Λ′": lambda f: f.slope @ f.wrench,
        "ad_ξᵀ Λ": lambda f: field.cobracket(f.strain, f.wrench),
        "F": lambda f: f.load,
    }
    for name, term in balance.items():
        assert np.any(size(moved, term) > 20.0 * left.balance), name


def test_flipped_signs_do_not_converge(moved):
    """The misprint of C (1.18), (1.19), +F for a load F, and each sign of (1.20) turned."""
    left = sum(field.norms(moved).balance ** 2) ** 0.5

    def turned(term):
        flipped = [field.residuals(f).balance + 2.0 * term(f) for f in moved]
        total = sum(part.weights @ row**2 for part, row in zip(moved, flipped, strict=True))
        return np.sqrt(sum(total) / sum(part.weights.sum() for part in moved))

    for term in (
        lambda f: f.load,
        lambda f: f.slope @ f.wrench,
        lambda f: -field.cobracket(f.strain, f.wrench),
        lambda f: -f.inertia * f.acceleration,
        lambda f: field.cobracket(f.twist, f.inertia * f.twist),
    ):
        assert turned(term) > 10.0 * left


def test_fixed_strains_carry_reactions():
    """An inextensible, shear-stiff rod: their wrenches come from the balance, the rest from ξ."""
    sizes = []
    for order in (3, 5, 7):
        dynamics = rod(gravity=GRAVITY, loads=LOADS, strains=ALL[:3], order=order, nodes=50)
        parts = field.fields(dynamics, equilibrium(dynamics))
        sizes.append(field.norms(parts).balance.max())
        assert np.abs(parts[0].wrench[:, 3:]).max() > 1.0
    assert np.all(np.diff(np.log(sizes)) < -1.0)


def test_an_independent_solution_satisfies_the_same_functions():
    """The rod as a boundary value problem in world axes, by scipy: nothing discrete of ours."""
    dynamics = rod(gravity=GRAVITY, order=1)
    section = dynamics.compiled.scene.bodies[0].sections[0]
    stiffness, length = section.stiffness(np.array(0.5)), section.length
    mass, *moments = section.inertia(np.array(0.5))
    weight = mass * np.array(GRAVITY)

    def strains(y):
        turn = Rotation.from_quat(y[3:7].T)
        m, n = turn.apply(y[7:10].T, inverse=True), turn.apply(y[10:13].T, inverse=True)
        return turn, m / stiffness[:3], n / stiffness[3:] + [1.0, 0.0, 0.0]

    def rates(s, y):
        turn, k, g = strains(y)
        out = np.zeros_like(y)
        slope = turn.apply(g)
        out[:3] = slope.T
        x, w = y[3:6].T, y[6]
        out[3:6] = 0.5 * (w[:, None] * k + np.cross(x, k)).T
        out[6] = -0.5 * np.einsum("ij,ij->i", x, k)
        out[7:10] = -np.cross(slope, y[10:13].T).T
        out[10:13] = -weight[:, None]
        return out

    def ends(a, b):
        return np.concatenate([a[:7] - [0, 0, 0, 0, 0, 0, 1], b[7:]])

    s = np.linspace(0, length, 30)
    start = np.zeros((13, 30))
    start[0], start[6] = s, 1.0
    found = solve_bvp(rates, ends, s, start, tol=1e-10, max_nodes=100000)
    assert found.success
    s, h = np.linspace(0.1, 0.5, 9) * length, 1e-4

    def at(s):
        y = found.sol(s)
        turn, k, g = strains(y)
        pose = np.tile(np.eye(4), (len(s), 1, 1))
        pose[:, :3, :3], pose[:, :3, 3] = turn.as_matrix(), y[:3].T
        strain = np.concatenate([k, g], axis=1)
        return pose, strain, stiffness * (strain - [0, 0, 0, 1, 0, 0])

    (pose, strain, wrench), ahead, behind = at(s), at(s + h), at(s - h)
    pose_slope, wrench_slope = ((ahead[i] - behind[i]) / (2 * h) for i in (0, 2))
    zero = np.zeros_like(strain)
    load = np.concatenate([zero[:, :3], np.einsum("kji,j->ki", pose[:, :3, :3], weight)], axis=1)
    left = field.pose_residual(pose, pose_slope, strain)
    assert np.abs(left).max() < 1e-6
    inertia = np.tile([*moments, mass, mass, mass], (len(s), 1))
    left = field.balance_residual(strain, wrench, wrench_slope, inertia, zero, zero, load)
    assert np.abs(left).max() < 1e-5 * np.abs(load).max()


def test_the_functions_are_those_of_rigid_motion():
    """η̇ and 𝓜 η̇ − ad_ηᵀ 𝓜 η of a free top: Euler's equations, with a hand-made torque."""
    rng = np.random.default_rng(1)
    twist, acceleration, strain = rng.normal(size=(3, 1, 6))
    inertia = np.array([[0.3, 0.5, 0.7, 2.0, 2.0, 2.0]])
    zero = np.zeros((1, 6))
    left = field.balance_residual(strain, zero, zero, inertia, twist, acceleration, zero)[0]
    spin, velocity = twist[0, :3], twist[0, 3:]
    moment = inertia[0, :3] * acceleration[0, :3] + np.cross(spin, inertia[0, :3] * spin)
    force = 2.0 * (acceleration[0, 3:] + np.cross(spin, velocity))
    np.testing.assert_allclose(left, np.concatenate([moment, force]), atol=1e-14)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"material": {"maxwell": {"ratio": 1.0, "time": 0.1}}}, "materials.soft.maxwell"),
        ({"actuators": [ACTUATORS[1] | {"friction": 0.1}]}, "actuators[0].friction"),
    ],
)
def test_what_has_a_memory_is_refused(change, key):
    dynamics = rod(order=1, **change)
    with pytest.raises(SceneError) as caught:
        field.fields(dynamics, np.zeros(dynamics.n))
    assert caught.value.key_path == key


def test_chambers_and_rayleighs_drag_belong_to_the_balance():
    """A pressure that bends, and a rod that falls through something like air."""
    sizes = []
    for order in (3, 5, 7):
        chamber = {"chamber": "c", "rod": "rod", "offset": [0.01, 0.01], "area": 2e-4}
        document = rod_document(
            gravity=GRAVITY,
            actuators=[chamber],
            material={"viscosity": 3e3, "rayleigh": {"mass": 20.0}},
            numerics={
                "basis": {"order": order, "nodes": 30}, "integrator": "sdirk4", "step": 0.002
            },
        )  # fmt: skip
        simulation = Simulation(scene_of(document))
        simulation.set_efforts([5e4])
        simulation.advance(40)
        q, v = simulation.q.copy(), simulation.v.copy()
        a = simulation.dynamics.forward_dynamics(q, v, np.array([5e4]))
        parts = field.fields(simulation.dynamics, q, v, a, efforts=np.array([5e4]))
        sizes.append(field.norms(parts).balance.max())
    assert np.all(np.diff(np.log(sizes)) < -1.0)
