"""Branches of equilibria against the elastica, closed forms of hinges, and shooting (scipy)."""

import numpy as np
import pytest
from scenes import rod, rod_document, scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipe, ellipk, jv

from soft_sim_ros.core.analysis.continuation import BIFURCATION, LIMIT, follow, switch
from soft_sim_ros.core.analysis.load_path import one_effort, one_load, tip_wrench, whole_load
from soft_sim_ros.core.analysis.special_points import SpecialPoint
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import BadArgument, CommandError, NoBranch, StaticsFailed

LENGTH, RADIUS, E = 0.6, 0.03, 1e6
EI = E * np.pi * RADIUS**4 / 4
PUSH = np.array([0, 0, 0, -EI / LENGTH**2, 0, 0])  # then λ is F L²/EI
EULER = np.pi**2 / 4


def tip(dynamics, q):
    return dynamics.node_poses(q)[-1]


@pytest.fixture(scope="module")
def column():
    dynamics = rod(strains=["bend_z"], order=10, nodes=80)
    path = tip_wrench(dynamics, PUSH)
    return dynamics, path, follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 70.0))


def test_a_perfect_column_meets_eulers_loads_one_after_the_other(column):
    dynamics, _, branch = column
    assert branch.ended_by == "load" and branch.loads[-1] == 70.0
    assert [point.kind for point in branch.special] == [BIFURCATION] * 3
    found = np.array([point.load for point in branch.special])
    np.testing.assert_allclose(found, EULER * np.array([1, 9, 25]), rtol=5e-6)
    assert found[0] == pytest.approx(EULER, rel=1e-8)
    # every one of them costs the straight column one more direction
    expected = [int(np.sum(load > found)) for load in branch.loads]
    assert branch.unstable.tolist() == expected
    # it leaves along 1 − cos(πs/2L)
    shape = branch.special[0].directions[:, 0]
    poses = dynamics.node_poses(1e-6 * shape)[:, :3, 3]
    s = poses[:, 0]
    wave = 1 - np.cos(0.5 * np.pi * s / LENGTH)
    np.testing.assert_allclose(poses[:, 1] / poses[-1, 1], wave, atol=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_buckled_column_is_the_elastica(column, side):
    """With α the slope of the tip and k = sin α/2: F L²/EI = K², x/L = 2 E/K − 1, y/L = 2 k/K."""
    dynamics, path, straight = column
    point = straight.special[0]
    buckled = switch(
        dynamics, path, point, within=(0.0, 10.0), direction=side * point.directions[:, 0]
    )
    assert buckled.ended_by == "load" and not buckled.special and not buckled.unstable.any()
    sides = set()
    for load, q in zip(buckled.loads, buckled.q, strict=True):
        pose = tip(dynamics, q)
        k2 = np.sin(0.5 * np.arctan2(pose[1, 0], pose[0, 0])) ** 2
        assert load == pytest.approx(ellipk(k2) ** 2, rel=1e-6)
        assert pose[0, 3] / LENGTH == pytest.approx(2 * ellipe(k2) / ellipk(k2) - 1, abs=1e-7)
        assert abs(pose[1, 3]) / LENGTH == pytest.approx(2 * np.sqrt(k2) / ellipk(k2), abs=1e-7)
        sides.add(np.sign(pose[1, 3]))
    assert len(sides) == 1
    other = switch(
        dynamics, path, point, within=(0.0, 10.0), direction=-side * point.directions[:, 0]
    )
    np.testing.assert_allclose(other.q, -buckled.q, atol=1e-8)


def test_the_buckled_branch_knows_that_it_came_from_a_bifurcation(column):
    """Followed back it runs through the straight column to the other side: λ turns there, but no
    load could push it along, so it is no limit point."""
    dynamics, path, straight = column
    buckled = switch(dynamics, path, straight.special[0], within=(0.0, 3.0))
    back = follow(
        dynamics, path, buckled.q[-1], buckled.loads[-1], within=(0.0, 3.0), downwards=True
    )
    assert back.ended_by == "load" and back.loads[-1] == 3.0
    np.testing.assert_allclose(back.q[-1], -back.q[0], atol=1e-7)
    assert [point.kind for point in back.special] == [BIFURCATION]
    assert back.special[0].load == pytest.approx(EULER, rel=1e-6)


def test_a_round_column_buckles_in_every_direction_at_once():
    dynamics = rod(strains=["bend_y", "bend_z", "torsion"], order=6, nodes=30)
    path = tip_wrench(dynamics, PUSH)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 10.0))
    (point,) = branch.special
    assert point.kind == BIFURCATION and point.directions.shape[1] == 2
    assert point.load == pytest.approx(EULER, rel=1e-6)
    assert set(branch.unstable) == {0, 2}
    # any combination of the two is a branch, and all of them are the same elastica, turned
    slanted = switch(
        dynamics, path, point, within=(0.0, 5.0), direction=point.directions @ [0.6, 0.8]
    )
    pose = tip(dynamics, slanted.q[-1])
    k2 = 0.5 * (1 - pose[0, 0])
    assert slanted.loads[-1] == pytest.approx(ellipk(k2) ** 2, rel=1e-5)


def test_a_flat_column_buckles_about_either_axis():
    """In space, EI of the stiff axis is 4 times the other: Euler's loads of both, in order."""
    section = {"cross_section": {"shape": "rectangle", "width_y": 0.03, "width_z": 0.06}}
    dynamics = rod(strains=["bend_y", "bend_z"], order=8, nodes=60, section=section)
    weak = E * 0.06 * 0.03**3 / 12
    path = tip_wrench(dynamics, weak / EI * PUSH)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 40.0))
    assert [point.kind for point in branch.special] == [BIFURCATION] * 3
    found = np.array([point.load for point in branch.special])
    np.testing.assert_allclose(found, EULER * np.array([1, 4, 9]), rtol=2e-6)
    for point, strain in zip(branch.special, ("bend_z", "bend_y", "bend_z"), strict=True):
        lost = point.directions[:, 0]
        names = dynamics.compiled.coordinate_names
        others = [abs(x) for x, name in zip(lost, names, strict=True) if strain not in name]
        assert max(others) < 1e-6 * np.abs(lost).max()


def test_a_strip_on_edge_tips_over_at_prandtls_load():
    """Lateral buckling of a cantilever strip: J₋₁⸝₄(F L² / 2 √(EI GJ)) = 0, about 4.013."""
    width, height = 0.01, 0.06
    section = {"cross_section": {"shape": "rectangle", "width_y": width, "width_z": height}}
    dynamics = rod(strains=["torsion", "bend_z"], order=10, nodes=60, section=section)
    law = dynamics.compiled.scene.bodies[0].sections[0].stiffness(np.array([0.5]))
    torsion, bending = (float(np.ravel(law)[i]) for i in (0, 2))
    assert bending == pytest.approx(E * height * width**3 / 12, rel=1e-9)
    number = brentq(lambda x: jv(-0.25, x), 1.5, 2.5) * 2
    assert number == pytest.approx(4.0126, abs=1e-4)
    unit = np.sqrt(torsion * bending) / LENGTH**2
    path = tip_wrench(dynamics, np.array([0, 0, 0, 0, 0, -unit]))
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 6.0))
    assert [point.kind for point in branch.special] == [BIFURCATION]
    assert branch.special[0].load == pytest.approx(number, rel=1e-6)


def hinge(stiffness=2.0, arm=0.5):
    document = rod_document() | {
        "bodies": [
            {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1], "stiffness": stiffness},
            {"joint": "arm", "kind": "fixed", "offset": {"position": [arm, 0, 0]}},
            {"rigid_body": "bob", "mass": 0.1},
        ],
        "numerics": {},
    }
    return Dynamics(scene_of(document)), stiffness / arm


@pytest.mark.parametrize("slant", [0.02, 0.3])
def test_the_wrong_side_of_an_imperfect_hinge_snaps_at_its_limit_point(slant):
    """k θ = F a sin(θ + slant): a push that leans to +θ has equilibria at −θ, too, down to the
    limit dF/dθ = 0, that is tan(θ + slant) = θ; below that load the arm snaps over."""
    dynamics, unit = hinge()
    push = unit * np.array([0, 0, 0, -np.cos(slant), np.sin(slant), 0])
    path = tip_wrench(dynamics, push)

    def load(angle):
        return angle / np.sin(angle + slant)

    start = -2.0
    branch = follow(
        dynamics, path, np.array([start]), load(start), within=(0.0, 4.0), downwards=True
    )
    angle = brentq(lambda x: np.tan(x + slant) - x, -1.5, -slant - 1e-9)
    (point,) = branch.special
    assert point.kind == LIMIT
    assert point.q[0] == pytest.approx(angle, abs=1e-9)
    assert point.load == pytest.approx(load(angle), rel=1e-12)
    np.testing.assert_allclose(branch.loads, load(branch.q[:, 0]), rtol=1e-9)
    stable = branch.q[:, 0] < angle
    assert branch.unstable.tolist() == (~stable).astype(int).tolist()
    assert stable.any() and not stable.all()


def shoot(side, push, slope, curvature):
    """θ at the clamp of EI θ″ = fx sin θ − fy cos θ, integrated from the tip (θ = slope)."""

    def rates(_, y):
        return [y[1], (-push * np.sin(y[0]) - side * np.cos(y[0])) / LENGTH**2]

    ends = solve_ivp(rates, (0.0, LENGTH), [slope, -curvature], rtol=1e-11, atol=1e-12)
    return ends.y[0, -1]


@pytest.mark.parametrize("curvature", [0.0, 0.3])
def test_a_compressed_rod_pushed_across_snaps_through_at_two_limit_points(curvature):
    """A rod under F = 3.2 EI/L² is bistable: the side force against the slope of its tip is an S.

    Independent: shooting from the tip, for which the side force is a function of the tip's slope.
    """
    push = 3.2

    def side(slope):
        return brentq(lambda f: shoot(f, push, slope, curvature), -6.0, 6.0, xtol=1e-12)

    slopes = np.linspace(-1.3, 1.3, 14)
    level = np.array([side(x) for x in slopes])
    folds = []
    for s in (1.0, -1.0):  # the load falls to a least one, then rises to a largest one
        (i,) = [
            i
            for i in range(1, 13)
            if s * level[i] < s * level[i - 1] and s * level[i] < s * level[i + 1]
        ]
        bounds = (slopes[i - 1], slopes[i + 1])
        found = minimize_scalar(
            lambda x, s=s: s * side(x), bounds=bounds, method="bounded", options={"xatol": 1e-7}
        )
        folds.append(found.x)
    dynamics = rod(
        strains=["bend_z"],
        order=9,
        nodes=60,
        section={"reference": {"curvature": [0.0, 0.0, curvature]}},
    )
    across = np.array([0, 0, 0, 0, EI / LENGTH**2, 0])
    path = tip_wrench(dynamics, across, held=push * PUSH)
    start = equilibrium(dynamics, tip=push * PUSH + 1.0 * across)
    branch = follow(dynamics, path, start, 1.0, within=(-4.0, 1.0), downwards=True)
    assert branch.ended_by == "load" and branch.loads[-1] == -4.0
    assert [point.kind for point in branch.special] == [LIMIT, LIMIT]
    for point, slope in zip(branch.special, folds, strict=True):
        assert point.load == pytest.approx(side(slope), abs=1e-6)
        pose = tip(dynamics, point.q)
        assert np.arctan2(pose[1, 0], pose[0, 0]) == pytest.approx(slope, abs=1e-3)
    for load, q in zip(branch.loads, branch.q, strict=True):
        pose = tip(dynamics, q)
        assert load == pytest.approx(side(np.arctan2(pose[1, 0], pose[0, 0])), abs=2e-6)
    # stable, then one way down on either side, then stable on the other side
    changes = branch.unstable[np.flatnonzero(np.diff(branch.unstable, prepend=-1))]
    assert changes.tolist() == [0, 1, 0]
    assert [branch.unstable[p.after + 1] - branch.unstable[p.after] for p in branch.special] == [
        1,
        -1,
    ]


def test_every_path_of_loads_passes_the_equilibria_of_statics():
    document = rod_document(
        strains=["torsion", "bend_y", "bend_z", "stretch"],
        order=3,
        gravity=(0, 0, -9.81),
        loads=[
            {"point": "dead", "body": "rod", "force": [0.3, 1.0, 0.0]},
            {"point": "follower", "body": "rod", "s": 0.4, "force": [0, 0, -1.5], "frame": "body"},
        ],
        actuators=[{"tendon": "pull", "rod": "rod", "offset": [0.02, 0.0]}],
    )
    dynamics = Dynamics(scene_of(document))
    efforts = np.array([6.0])
    goal = equilibrium(dynamics, efforts=efforts)
    unloaded = [dict(load, schedule={"start": 1.0}) for load in document["loads"]]
    for path, end, start in (
        (whole_load(dynamics, efforts), 1.0, np.zeros(dynamics.n)),
        (one_effort(dynamics, "pull"), 6.0, equilibrium(dynamics)),
        *(
            (
                one_load(dynamics, name, efforts),
                1.0,
                equilibrium(
                    Dynamics(
                        scene_of(
                            document
                            | {
                                "loads": [
                                    unloaded[i] if i == index else document["loads"][i]
                                    for i in range(2)
                                ]
                            }
                        )
                    ),
                    efforts=efforts,
                ),
            )
            for index, name in enumerate(("dead", "follower"))
        ),
    ):
        branch = follow(dynamics, path, start, within=(0.0, end))
        assert branch.ended_by == "load" and not branch.special and not branch.unstable.any()
        np.testing.assert_allclose(branch.q[0], start, atol=1e-9)
        np.testing.assert_allclose(branch.q[-1], goal, atol=1e-8)


def test_the_factor_of_one_load_counts_from_what_its_ramp_leaves_of_it():
    """Half way up its ramp, twice the load is the load in full."""

    def scene(schedule):
        load = {"point": "push", "body": "rod", "force": [0.0, 1.5, 0.0], "schedule": schedule}
        return scene_of(rod_document(strains=["bend_z"], order=3, loads=[load]))

    dynamics, full = Dynamics(scene({"ramp": 1.0})), Dynamics(scene({}))
    path = one_load(dynamics, "push", time=0.5)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 2.0))
    np.testing.assert_allclose(branch.q[-1], equilibrium(full), atol=1e-9)


def test_a_follower_force_does_not_buckle_a_cantilever():
    """There is no equilibrium beside the straight one under a tangential load (it flutters)."""
    dynamics = rod(strains=["bend_z"], order=6, nodes=30)
    path = tip_wrench(dynamics, PUSH, tip_follows=True)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 15.0))
    assert branch.ended_by == "load" and not branch.special and not branch.unstable.any()


def test_a_column_buckles_under_a_load_of_which_a_part_follows():
    """Without a potential, but still by divergence: w = a (sin kx − kx) + b (cos kx − 1), k² =
    (P + F) L²/EI, w″ = 0 and w‴ + (P L²/EI) w′ = 0 at the tip; P is dead, F = P/5 follows."""

    def boundary(p):
        k = np.sqrt(1.2 * p)
        sin, cos = np.sin(k), np.cos(k)
        third = -(k**3) * cos + p * k * (cos - 1), k**3 * sin - p * k * sin
        return sin * third[1] - cos * third[0]

    expected = brentq(boundary, 1.0, 4.0)
    assert abs(expected / EULER - 1.0) > 0.05  # nor is it Euler's load
    tail = {"point": "tail", "body": "rod", "force": [0.2 * PUSH[3], 0.0, 0.0], "frame": "body"}
    dynamics = rod(strains=["bend_z"], order=8, nodes=40, loads=[tail])
    path = whole_load(dynamics, tip=PUSH)
    branch = follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 6.0))
    (point,) = branch.special
    assert point.kind == BIFURCATION and point.load == pytest.approx(expected, rel=1e-6)
    assert branch.unstable.tolist() == [int(load > expected) for load in branch.loads]
    with pytest.raises(StaticsFailed, match="loses stability") as caught:
        equilibrium(rod(strains=["bend_z"], order=8, nodes=40, loads=[
            tail | {"force": [0.4 * expected * PUSH[3], 0.0, 0.0]}
        ]), tip=2.0 * expected * PUSH)  # fmt: skip
    assert caught.value.load_factor == pytest.approx(0.5, abs=1e-4)


def test_what_cannot_be_followed_says_why():
    document = rod_document(strains=["stretch"], order=1)
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    dynamics = Dynamics(scene_of(document))
    zero = np.zeros(dynamics.n)
    path = one_effort(dynamics, "t")
    crushing = E * np.pi * RADIUS**2
    branch = follow(dynamics, path, zero, within=(0.0, 3.0 * crushing))
    assert branch.ended_by == "refused: a rod is compressed to nothing"
    assert branch.loads[-1] == pytest.approx(crushing, rel=1e-3)
    with pytest.raises(NoBranch, match="at load 7000: no equilibrium near"):
        follow(dynamics, path, zero, 7e3, within=(0.0, 8e3))
    with pytest.raises(CommandError, match="unknown actuator 'x': expected one of t"):
        one_effort(dynamics, "x")
    with pytest.raises(CommandError, match="unknown load 'x': expected one of none in this scene"):
        one_load(dynamics, "x")
    with pytest.raises(ValueError, match="two finite loads"):
        follow(dynamics, path, zero, within=(0.0, np.inf))


def test_a_branch_ends_where_numbers_do():
    """Never an exception of numpy: neither on the way, nor at the first point."""
    dynamics = Dynamics(scene_of(rod_document(strains=["bend_z"], order=2)))
    zero = np.zeros(dynamics.n)

    def path(load):
        # what is beyond half of the range is not finite: residual, stiffness and slope
        size = 1e-3 * load if load < 0.5 else np.inf
        return dynamics.forcing(tip=np.array([0.0, 0.0, 0.0, 0.0, size, 0.0]))

    branch = follow(dynamics, path, zero, within=(0.0, 1.0))
    assert branch.ended_by == "refused: it is not finite"
    assert 0.4 < branch.loads[-1] < 0.5 and np.isfinite(branch.q).all()
    with pytest.raises(NoBranch, match="it is not finite"):
        follow(dynamics, path, zero, 0.8, within=(0.0, 1.0))


@pytest.mark.parametrize("value", [np.nan, np.inf, "a", 1j, None, True, [0.1], -1, 0])
@pytest.mark.parametrize("name", ["steps", "step", "max_step", "tolerance"])
def test_lengths_and_counts_of_a_branch_are_checked(column, name, value):
    dynamics, path, _ = column
    with pytest.raises(BadArgument, match=f"^{name} must be"):
        follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 1.0), **{name: value})
    if name == "step":
        return
    point = SpecialPoint("bifurcation", 0.5, np.zeros(dynamics.n), np.ones((dynamics.n, 1)), 0)
    with pytest.raises(BadArgument, match=f"^{name} must be"):
        switch(dynamics, path, point, within=(0.0, 1.0), **{name: value})


def test_whole_numbers_of_points_and_loads_within_the_range(column):
    dynamics, path, _ = column
    zero = np.zeros(dynamics.n)
    for steps in (2.5, 1e300, 2**70):
        with pytest.raises(BadArgument, match="steps"):
            follow(dynamics, path, zero, within=(0.0, 1.0), steps=steps)
    for within in ((0.0, np.nan), (1.0, 0.0), (0.0,), "ab", (0.0, 1j)):
        with pytest.raises(BadArgument, match="within"):
            follow(dynamics, path, zero, within=within)
    for load in (np.nan, "a", None):
        with pytest.raises(BadArgument, match="load"):
            follow(dynamics, path, zero, load, within=(0.0, 1.0))
    point = SpecialPoint("bifurcation", 0.5, zero, np.ones((dynamics.n, 1)), 0)
    for direction in (zero, np.ones(dynamics.n + 1), np.full(dynamics.n, np.nan), "a"):
        with pytest.raises(BadArgument, match="direction"):
            switch(dynamics, path, point, within=(0.0, 1.0), direction=direction)
