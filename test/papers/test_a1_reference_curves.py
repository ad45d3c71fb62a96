"""A-1: arbitrary reference curves and data that vary along them, as tables, functions, formulas."""

import csv
import itertools

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from planar_grid import extrapolated_tip
from scenes import SOFT, rod_document, scene_of
from scipy.spatial.transform import Rotation

from benchmarks.cases import Case
from benchmarks.independent import absolute
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import load_scene, parse_scene, register_profile, summary

E, G, RHO = SOFT["young_modulus"], SOFT["shear_modulus"], SOFT["density"]
LENGTH, RADIUS = 0.6, 0.03


def arm(section, **options):
    return Dynamics(scene_of(rod_document(section=section, **options)))


def section_of(section, **options):
    return scene_of(rod_document(section=section, **options)).bodies[0].sections[0]


def circular(radius, shear=1.0):
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    bend, pull = E * inertia, E * area
    return np.array([2 * G * inertia, bend, bend, pull, shear * G * area, shear * G * area])


# -- reference curves ----------------------------------------------------------------------

COIL, RISE = 0.08, 0.02  # radius in m, rise per radian in m
RATE = np.hypot(COIL, RISE)
TURNED = LENGTH / RATE
FRENET = np.array([RISE, 0.0, COIL]) / RATE**2  # torsion, 0, curvature


def helix(count):
    """Points (count, 3), and the frames of Frenet there as quaternions (count, 4)."""
    t = np.linspace(0.0, TURNED, count)
    points = np.stack([COIL * np.cos(t), COIL * np.sin(t), RISE * t], axis=1)
    tangent = np.stack([-COIL * np.sin(t), COIL * np.cos(t), RISE + 0 * t], axis=1) / RATE
    normal = np.stack([-np.cos(t), -np.sin(t), 0 * t], axis=1)
    frames = np.stack([tangent, normal, np.cross(tangent, normal)], axis=2)
    return points, Rotation.from_matrix(frames).as_quat()


def coil_tip(reference, loaded=True, **options):
    load = np.array([0.05, -0.02, 0.1, 0.8, -0.6, 0.5]) if loaded else np.zeros(6)
    options = {"order": 10, "nodes": 90, "gravity": (1.0, 2.0, -4.0) if loaded else (0, 0, 0)}
    dynamics = arm({"reference": reference, "shear_correction": 1.0}, **options)
    return dynamics.node_poses(equilibrium(dynamics, tip=load))[-1]


def test_a_loaded_helix_is_that_of_the_cosserat_equations():
    """By Frenet's strains, by points (no twist about the curve), by points with frames."""
    points, quaternions = helix(81)
    by_points = {"points": points, "normal": [-1, 0, 0]}
    stiffness = circular(RADIUS)
    rest = np.array([*FRENET, 1.0, 0, 0])
    weight = RHO * np.pi * RADIUS**2 * np.array([1.0, 2.0, -4.0])
    position, turn = solve_rod(
        LENGTH, stiffness, lambda s: rest, density_force=weight,
        tip_force=(0.8, -0.6, 0.5), tip_moment=(0.05, -0.02, 0.1),
    )  # fmt: skip
    framed = coil_tip({"centre_line": {"points": points, "frames": quaternions}})
    for pose in (coil_tip({"curvature": FRENET}), framed):
        np.testing.assert_allclose(pose[:3, 3], position, atol=2e-7)
        np.testing.assert_allclose(pose[:3, :3], turn, atol=2e-6)
    bishop = coil_tip({"centre_line": by_points})
    np.testing.assert_allclose(bishop[:3, 3], position, atol=2e-7)
    # its axes have turned back about the tangent by the total torsion of the curve
    back = Rotation.from_rotvec([-FRENET[0] * LENGTH, 0, 0]).as_matrix()
    np.testing.assert_allclose(bishop[:3, :3], turn @ back, atol=2e-5)
    # and the load matters
    assert np.abs(coil_tip({"curvature": FRENET}, loaded=False)[:3, 3] - position).max() > 0.01


@pytest.mark.parametrize(("framed", "order"), [(False, 4.0), (True, 3.0)])
def test_points_of_a_centre_line_converge_at_the_stated_order(framed, order):
    exact = coil_tip({"curvature": FRENET}, loaded=False)[:3, 3]
    counts, errors = np.array([9, 17, 33]), []
    for count in counts:
        points, quaternions = helix(count)
        extra = {"frames": quaternions} if framed else {"normal": [-1, 0, 0]}
        pose = coil_tip({"centre_line": {"points": points, **extra}}, loaded=False)
        errors.append(np.linalg.norm(pose[:3, 3] - exact))
    slope = -np.polyfit(np.log(counts - 1), np.log(errors), 1)[0]
    assert slope > order - 0.3, errors


@pytest.mark.parametrize(("count", "accuracy"), [(4, 0.2), (5, 0.1), (6, 0.01), (40, 1e-6)])
def test_few_points_on_a_circle_are_an_arc(count, accuracy):
    angle = np.linspace(0, 1.2, count)
    points = 0.5 * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1)
    strain = section_of({"reference": {"centre_line": {"points": points}}}).strain0(
        np.linspace(0, 1, 50)
    )
    # towards +y, the normal by default: about +z
    np.testing.assert_allclose(strain[:, 2], 2.0, rtol=accuracy)
    np.testing.assert_allclose(np.delete(strain, 2, axis=1), [[0, 0, 1, 0, 0]] * 50, atol=1e-9)


@pytest.mark.parametrize("framed", [False, True])
def test_a_rigidly_moved_reference_changes_nothing(framed):
    """The points, their frames and the normal moved together: the same strains to round-off."""
    points, quaternions = helix(25)
    turn, shift = Rotation.random(random_state=4), np.array([0.7, -0.4, 1.3])
    x = np.linspace(0, 1, 50)

    def strains(points, frames, normal):
        extra = {"frames": frames.as_quat()} if framed else {"normal": normal}
        return section_of({"reference": {"centre_line": {"points": points} | extra}}).strain0(x)

    frames = Rotation.from_quat(quaternions)
    one = strains(points, frames, np.array([-1.0, 0.2, 0.1]))
    two = strains(turn.apply(points) + shift, turn * frames, turn.apply([-1.0, 0.2, 0.1]))
    np.testing.assert_allclose(two, one, atol=1e-9 * np.abs(one).max())
    assert np.abs(one[:, :3]).max() > 5.0


def test_a_rigidly_moved_frame_changes_nothing_in_the_coordinates():
    """Base, gravity and loads turned together: q(t) is the same to round-off."""
    points, _ = helix(25)
    turn = Rotation.from_euler("xyz", [0.5, -0.9, 2.0])
    runs = []
    for move in (Rotation.identity(), turn):
        document = rod_document(
            section={"reference": {"centre_line": {"points": points}}},
            order=2,
            gravity=move.apply([1.0, 2.0, -4.0]),
            base={"position": move.apply([0.1, 0.2, 0.3]), "quaternion": move.as_quat()},
            numerics={"step": 0.002},
        )
        simulation = Simulation(scene_of(document))
        simulation.advance(50)
        runs.append(simulation.q.copy())
    assert np.abs(runs[0]).max() > 0.1
    np.testing.assert_allclose(runs[1], runs[0], atol=1e-9 * np.abs(runs[0]).max())


# -- data along the curve ------------------------------------------------------------------

WIDTH = "0.03 - 0.02 * s + 0.004 * sin(pi * s / 0.3)"
LINE = "2.0 + s - 3 * s ** 2"


def width(s):
    return 0.03 - 0.02 * s + 0.004 * np.sin(np.pi * s / 0.3)


def line(s):
    return 2.0 + s - 3 * s**2


def bent(s):
    return 3.0 * np.cos(6.0 * s)


VARIED = {
    "shear_correction": 0.9,
    "cross_section": {"shape": "circle", "radius": {"expression": WIDTH}},
    "mass_per_length": {"expression": LINE},
    "reference": {"curvature": [1.0, [0.0, -2.0], {"expression": "3.0 * cos(6.0 * s)"}]},
}


def test_a_curved_twisted_non_uniform_rod_is_that_of_the_cosserat_equations():
    dynamics = arm(VARIED, order=14, nodes=80, gravity=(1.0, -2.0, -9.81))
    load = np.array([0.05, 0.02, -0.1, 0.5, -1.0, 0.8])
    pose = dynamics.node_poses(equilibrium(dynamics, tip=load))[-1]
    position, turn = solve_rod(
        LENGTH,
        lambda s: circular(width(s), 0.9),
        lambda s: np.array([1.0, -2.0 * s / LENGTH, bent(s), 1.0, 0, 0]),
        density_force=lambda s: line(s) * np.array([1.0, -2.0, -9.81]),
        tip_force=load[3:],
        tip_moment=load[:3],
    )
    np.testing.assert_allclose(pose[:3, 3], position, atol=2e-7)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=2e-6)


def test_a_curved_non_uniform_rod_swings_as_on_an_independent_grid():
    """Equations (2.1) in a plane: ρ₀, H_r, stiffness and reference curvature functions of σ."""
    material = {"viscosity": 2e3}
    section = VARIED | {"reference": {"curvature": [0, 0, {"expression": "3.0 * cos(6.0 * s)"}]}}
    document = rod_document(
        section=section, material=material, strains=["bend_z", "stretch", "shear_y"],
        gravity=(0.0, -9.81, 0.0),
        numerics={"step": 5e-4, "integrator": "sdirk3", "basis": {"order": 10, "nodes": 40}},
    )  # fmt: skip
    simulation = Simulation(scene_of(document))
    simulation.advance(400)

    def inertia(s):
        return RHO * np.pi * width(s) ** 4 / 4

    place, correction = extrapolated_tip(
        8, LENGTH, 0.2, gravity=(0.0, -9.81), viscous=2e3 / G, mass=line, inertia=inertia,
        bend=lambda s: circular(width(s))[1], pull=lambda s: circular(width(s))[3],
        shear=lambda s: circular(width(s), 0.9)[4], curvature=bent,
    )  # fmt: skip
    start = simulation.dynamics.node_poses(0 * simulation.q)[-1, :2, 3]
    now = simulation.sampler(2).poses()[-1, :2]
    assert np.linalg.norm(now - start) > 0.05
    assert correction < 5e-5
    np.testing.assert_allclose(now, place, atol=2e-5)


def test_a_helix_let_go_moves_in_space_as_in_absolute_coordinates():
    """Points of a coil here, Frenet's curvature and torsion on a grid of frames there."""
    gravity, viscosity, radius = (1.0, 2.0, -9.0), 1e3, 0.01
    reference = {"centre_line": {"points": helix(81)[0], "normal": [-1, 0, 0]}}
    document = rod_document(
        radius=radius, gravity=gravity, material={"viscosity": viscosity},
        section={"reference": reference, "shear_correction": 1.0},
        numerics={"step": 2.5e-4, "integrator": "sdirk3", "basis": {"order": 10, "nodes": 90}},
    )  # fmt: skip
    simulation = Simulation(scene_of(document))
    start = simulation.sampler(2).poses()[-1, :3].copy()
    simulation.advance(600)
    case = Case("coil", "", (LENGTH,), radius, E, RHO, viscosity, gravity, 0.15, 1)
    place, correction = absolute.extrapolated(case, 12, 1e-6, FRENET)
    now = simulation.sampler(2).poses()[-1, :3]
    assert np.linalg.norm(now - start) > 0.1
    assert correction < 2e-4
    np.testing.assert_allclose(now, place[0], atol=5e-6)


def twist_angle(stiffness, **options):
    """Angle of the tip of a shaft under a torque of 1 N·m: ∫ ds / GJ."""
    options = {"strains": ["torsion"], "order": 25, "nodes": 40} | options
    dynamics = arm({"stiffness": {"torsion": stiffness}}, **options)
    q = equilibrium(dynamics, tip=np.array([1.0, 0, 0, 0, 0, 0]), tip_follows=True)
    strain = dynamics.node_poses(q)[-1][:3, :3]
    return np.arctan2(strain[2, 1], strain[1, 1])


def shaft(s):
    return 1.0 / (0.4 + 0.3 * np.sin(8.0 * s))


SHAFT_ANGLE = 0.4 * LENGTH + 0.3 / 8.0 * (1 - np.cos(8.0 * LENGTH))


@pytest.mark.parametrize(("interpolation", "order"), [("linear", 2), ("monotone", 2), ("cubic", 4)])
def test_tables_converge_at_the_order_of_their_interpolation(interpolation, order):
    counts, errors = np.array([9, 17, 33]), []
    for count in counts:
        s = np.linspace(0, LENGTH, count)
        table = {"table": np.stack([s, shaft(s)], axis=1), "interpolation": interpolation}
        options = {"order": 4, "nodes": 8} if interpolation == "linear" else {}
        errors.append(abs(twist_angle(table, **options) - SHAFT_ANGLE))
    slope = -np.polyfit(np.log(counts - 1), np.log(errors), 1)[0]
    assert slope > order - 0.3, errors


def test_functions_converge_exponentially_with_the_order():
    """∫ ds/GJ through a strain of order p: each two orders win a factor."""
    stiffness = {"expression": "1 / (0.4 + 0.3 * sin(8.0 * s))"}
    errors = [abs(twist_angle(stiffness, order=p) - SHAFT_ANGLE) for p in (2, 4, 6, 8)]
    assert all(b < a / 5 for a, b in itertools.pairwise(errors)), errors
    assert twist_angle(stiffness) == pytest.approx(SHAFT_ANGLE, rel=1e-12)


def test_lumped_mass_converges_exponentially_with_the_nodes():
    """∫ ρ₀ ds and ∫ ρ₀ s ds by the wrench that holds the rod up."""
    mass = {"expression": "exp(3 * s)"}
    exact = np.array([(np.exp(1.8) - 1) / 3, ((3 * LENGTH - 1) * np.exp(1.8) + 1) / 9])
    errors = []
    for nodes in (3, 4, 5, 6):
        dynamics = arm(
            {"mass_per_length": mass}, strains=["stretch"], order=1, nodes=nodes, gravity=(0, 0, -1)
        )
        base = dynamics.internal_wrench(np.zeros(dynamics.n)).before[0]
        errors.append(np.abs([-base[5], base[1]] - exact).max())
    assert all(b < a / 20 for a, b in itertools.pairwise(errors)), errors


def test_a_table_of_straight_lines_cuts_the_rod_where_it_bends():
    table = [[0, 0.03], [0.1, 0.02], [0.45, 0.025], [0.6, 0.01]]
    radius = {"table": table, "interpolation": "linear"}
    section = {"cross_section": {"shape": "circle", "radius": radius}}
    dynamics = arm(section, order=2)
    elements = dynamics.compiled.chain.rods["rod"].elements
    np.testing.assert_allclose([e.span[1] for e in elements], [0.1, 0.45, 0.6])
    pairs = [((0.0, 0.03), (0.1, 0.02)), ((0.1, 0.02), (0.45, 0.025)), ((0.45, 0.025), (0.6, 0.01))]
    mass = sum(
        RHO * np.pi * (t - s) * (a * a + a * b + b * b) / 3 for (s, a), (t, b) in pairs
    )  # frustums
    assert dynamics.model.inertia[:, 0].sum() == pytest.approx(mass, rel=1e-13)
    scene = scene_of(rod_document(section=section))
    assert summary(scene)[0].mass == pytest.approx(mass, rel=1e-13)


def test_given_stiffness_damping_and_inertia_stand_for_those_of_the_shape():
    """A rod described by its own numbers once more is the same rod."""
    material = {"viscosity": 100.0}
    plain = section_of({}, material=material)
    law, loss, inertia = (f(np.array(0.5)) for f in (plain.stiffness, plain.damping, plain.inertia))
    strains = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
    again = {
        "cross_section": {"shape": "circle", "radius": 0.5},
        "mass_per_length": inertia[0],
        "inertia_per_length": inertia[1:],
        "stiffness": dict(zip(strains, law, strict=True)),
        "damping": dict(zip(strains, loss, strict=True)),
    }
    one, two = arm({}, material=material), arm(again, material=material)
    np.testing.assert_allclose(two.stiffness_matrix(), one.stiffness_matrix(), rtol=1e-14)
    np.testing.assert_allclose(two.damping_matrix(), one.damping_matrix(), rtol=1e-14)
    np.testing.assert_allclose(two.model.inertia, one.model.inertia, rtol=1e-14)


# -- where data come from ------------------------------------------------------------------


def sources(folder):
    """The same table written in four ways."""
    s = np.linspace(0, LENGTH, 7)
    register_profile("width_of_test_a1", np.vectorize(width))
    rows = np.stack([s, width(s)], axis=1)
    with (folder / "data.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["s", "unused", "radius"])
        writer.writerows([[repr(float(a)), 1, repr(float(b))] for a, b in rows])
    np.savez(folder / "data.npz", s=s, radius=width(s))
    return {
        "table": {"table": rows},
        "csv": {"file": "data.csv", "column": "radius"},
        "npz": {"file": "data.npz", "column": "radius"},
        "function": {"function": "width_of_test_a1"},
        "expression": {"expression": WIDTH},
    }


def test_tables_functions_and_formulas_say_the_same(tmp_path):
    import yaml
    from scenes import plain

    x = np.linspace(0, 1, 7)
    for name, source in sources(tmp_path).items():
        document = rod_document(
            section={"cross_section": {"shape": "circle", "radius": source}}, name=name
        )
        scene = parse_scene(yaml.safe_dump(plain(document)), str(tmp_path / "scene.yaml"))
        radius = scene.bodies[0].sections[0].cross_section.radius
        np.testing.assert_allclose(radius(x), width(LENGTH * x), rtol=1e-14)
        # what is recorded stands alone: no file is needed to run it again
        again = parse_scene(scene.source, "elsewhere.yaml")
        other = again.bodies[0].sections[0].cross_section.radius
        fine = np.linspace(0, 1, 100)
        np.testing.assert_array_equal(other(fine), radius(fine))


def test_a_centre_line_from_a_file_stands_alone_in_the_source(tmp_path):
    points, quaternions = helix(12)
    np.savez(tmp_path / "coil.npz", **dict(zip("xyz", points.T, strict=True)))
    names = ["x", "y", "z", "qx", "qy", "qz", "qw"]
    columns = np.concatenate([points, quaternions], axis=1).T
    np.savez(tmp_path / "framed.npz", **dict(zip(names, columns, strict=True)))
    text = """
bodies:
  - rod: coil
    sections:
      - name: all
        length: 0.6
        material: m
        cross_section: {shape: circle, radius: 0.01}
        reference:
          centre_line:  # as measured
            file: FILE
            NORMAL
        # the end of the section
    strains: [bend_y, bend_z]
materials: {m: {young_modulus: 1e6, poisson_ratio: 0.4, density: 1e3}}
"""
    for file, normal in (("coil.npz", "normal: [-1, 0, 0]"), ("framed.npz", "")):
        here = text.replace("FILE", file).replace("NORMAL", normal)
        scene = parse_scene(here, str(tmp_path / "scene.yaml"))
        again = parse_scene(scene.source, "elsewhere.yaml")
        x = np.linspace(0, 1, 40)
        strains = [s.bodies[0].sections[0].strain0(x) for s in (scene, again)]
        np.testing.assert_array_equal(*strains)
        assert again.source == scene.source


BAD = [
    ({"table": [[0, 1], [0.6, 1], [0.3, 1]]}, "s rising"),
    ({"table": [[0, 1], [0.5, 1]]}, "s from 0 to the length of the section, 0.6 m"),
    ({"table": [[0, 1], [0.6]]}, "a list of 2 numbers|lists of 2 numbers"),
    ({"table": [[0, 1], [0.3, -1], [0.6, 1]]}, "a number > 0 all along the section .it is -0.01"),
    ({"table": [[0, 1], [0.6, 1]], "interpolation": "spline"}, "one of linear, monotone, cubic"),
    ({"expression": "open('/etc/passwd')"}, "a formula in s"),
    ({"expression": "s.__class__"}, "a formula in s"),
    ({"expression": "(lambda: 1)()"}, "a formula in s"),
    ({"expression": "0.1 - s"}, "it is -0.00"),
    ({"expression": "9**9**9**9"}, "it is inf"),
    ({"expression": "1 +"}, "not arithmetic"),
    ({"function": "nobody"}, "name of a registered function"),
    ({"file": "nothing.csv", "column": "r"}, "a file beside the scene"),
    ({"file": "nothing.npz", "column": "r"}, "npz file"),
    ({"tabel": []}, "did you mean table"),
]


@pytest.mark.parametrize(("radius", "words"), BAD, ids=[str(i) for i in range(len(BAD))])
def test_bad_profiles_are_refused(radius, words):
    with pytest.raises(SceneError, match=words) as refused:
        section_of({"cross_section": {"shape": "circle", "radius": radius}})
    assert "cross_section.radius" in refused.value.key_path


BAD_LINES = [
    ({"points": [[0, 0, 0], [0.3, 0, 0], [0.6, 0, 0]]}, "at least 4 points"),
    ({"points": [[0.2 * i, 0, 0] for i in range(5)]}, "as long as the section, 0.6 m"),
    ({"points": [[0.15 * i, 0, 0] for i in range(5)], "normal": [1, 0, 0]}, "not along the curve"),
    ({"points": [[0.15 * i, 0, 0] for i in range(5)], "frames": [[0, 0, 0, 1]]}, "5 quaternions"),
    (
        {"points": [[0.15 * i, 0, 0] for i in range(5)], "frames": 5 * [[0, 0, 1, 0]]},
        "x axes point along",
    ),
    ({"points": [[0.15 * i, 0, 0] for i in range(5)], "frames": 5 * [[0, 0, 0, 2]]}, "norm 1"),
]


@pytest.mark.parametrize(("line", "words"), BAD_LINES, ids=[str(i) for i in range(len(BAD_LINES))])
def test_bad_centre_lines_are_refused(line, words):
    with pytest.raises(SceneError, match=words):
        section_of({"reference": {"centre_line": line}})


def test_a_tube_whose_wall_vanishes_somewhere_is_refused():
    inner = {"expression": "0.02 + 0.01 * sin(pi * s / 0.6)"}
    with pytest.raises(SceneError, match="inner radii smaller"):
        section_of({"cross_section": {"shape": "annulus", "outer": 0.025, "inner": inner}})


def test_the_scene_of_this_row_hangs_by_its_weight_of_wire():
    dynamics = Dynamics(load_scene("spring_arm"))
    base = dynamics.internal_wrench(np.zeros(dynamics.n)).before[0]
    poses = dynamics.node_poses(np.zeros(dynamics.n))
    # one and a half turns on: half a turn about the axis of the coil, which rises by 0.225 m
    straight = np.linalg.norm(poses[-1, :3, 3] - poses[0, :3, 3])
    assert straight == pytest.approx(np.hypot(0.2, 0.225), rel=1e-4)
    weight = summary(load_scene("spring_arm"))[0].mass * 9.81
    assert np.linalg.norm(base[3:]) == pytest.approx(
        weight, rel=1e-5
    )  # lumped over the knots of a table
