"""Tendons and chambers along general paths, against closed forms and boundary value problems."""

import numpy as np
import pytest
from scenes import ALL, rod_document, scene_of
from tendon_bvp import solve_tendon_rod

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.simulation import LEDGER
from soft_sim_ros.errors import SceneError

LENGTH, RADIUS, E, G = 0.6, 0.03, 1e6, 1e6 / 3
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
EI, EA = E * INERTIA, E * AREA
STIFFNESS = np.array([2 * G * INERTIA, EI, EI, EA, G * AREA, G * AREA])
BORE = 2e-4


def rod_with(*actuators, **options):
    """Return the dynamics of a clamped rod with some actuators, which are on its own rod."""
    document = rod_document(**options)
    document["actuators"] = [{"rod": "rod"} | actuator for actuator in actuators]
    return Dynamics(scene_of(document))


def tip(dynamics, q):
    return dynamics.node_poses(q)[-1]


def straight(first, last):
    first, last = np.array([0.0, *first]), np.array([0.0, *last])

    def path(s):
        slope = np.broadcast_to((last - first) / LENGTH, (len(s), 3))
        return first + s[:, None] * slope, slope, 0.0 * slope

    return path


def helix(radius, angle, turns):
    rate = 2 * np.pi * turns / LENGTH

    def path(s):
        phase = angle + rate * s
        out = radius * np.stack([0 * s, np.cos(phase), np.sin(phase)], axis=1)
        side = radius * np.stack([0 * s, -np.sin(phase), np.cos(phase)], axis=1)
        return out, rate * side, -(rate**2) * out

    return path


def parabola(s):
    """y = 0.02 − 0.05 s², z = 0.03 s."""
    zero, one = 0.0 * s, 0.0 * s + 1.0
    rows = (
        [zero, 0.02 - 0.05 * s * s, 0.03 * s],
        [zero, -0.1 * s, 0.03 * one],
        [zero, -0.1 * one, zero],
    )
    return tuple(np.stack(row, axis=1) for row in rows)


TABLE = [[s, 0.02 - 0.05 * s * s, 0.03 * s] for s in np.linspace(0, LENGTH, 61).tolist()]
ROUTES = {
    "parallel": ({"offset": [0.02, 0.01]}, straight([0.02, 0.01], [0.02, 0.01])),
    "converging": ({"offset": {"from": [0.025, 0.0], "to": [-0.005, 0.01]}},
                   straight([0.025, 0.0], [-0.005, 0.01])),
    "helical": ({"helix": {"radius": 0.02, "angle": 0.3, "turns": 1.2}}, helix(0.02, 0.3, 1.2)),
    "table": ({"points": TABLE}, parabola),
}  # fmt: skip


@pytest.mark.parametrize("kind", ["tendon", "chamber"])
@pytest.mark.parametrize("route", ROUTES)
def test_equilibria_are_those_of_the_distributed_load_of_the_tendon(route, kind):
    keys, path = ROUTES[route]
    effort, tension = (9.0, 9.0) if kind == "tendon" else (5e4, -5e4 * BORE)
    area = {"area": BORE} if kind == "chamber" else {}
    dynamics = rod_with({kind: "a"} | keys | area, order=8, nodes=40,
                        gravity=(0, 0, -3.0), section={"shear_correction": 1.0})  # fmt: skip
    pose = tip(dynamics, equilibrium(dynamics, efforts=[effort]))
    weight = np.array([0, 0, -3.0]) * 1000.0 * AREA
    position, turn = solve_tendon_rod(LENGTH, STIFFNESS, path, tension, weight)
    np.testing.assert_allclose(pose[:3, 3], position, atol=5e-6)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=3e-5)
    droop = tip(dynamics, equilibrium(dynamics, efforts=[0.0]))
    assert np.linalg.norm(droop[:3, 3] - position) > 0.005  # the actuator does matter


def test_a_table_passes_through_its_points_and_a_table_of_a_line_is_that_line():
    points = [[0.1, 0.02, 0.0], [0.25, 0.02, -0.01], [0.4, 0.0, 0.01], [0.5, 0.01, 0.0]]
    dynamics = rod_with({"tendon": "t", "points": points})
    (tendon,) = dynamics.compiled.scene.actuators[0].stretches
    assert (tendon.start, tendon.end) == (0.1, 0.5)
    for s, y, z in points:
        np.testing.assert_allclose(tendon.offset(np.array(s)), [0, y, z], atol=1e-15)
    # smooth: curvature without jumps, and none at the ends
    inner = np.array([0.25 - 1e-9, 0.25 + 1e-9])
    assert np.abs(np.diff(tendon.curvature(inner), axis=0)).max() < 1e-5
    np.testing.assert_allclose(tendon.curvature(np.array([0.1, 0.5])), 0.0, atol=1e-12)
    line = {"offset": {"from": [0.02, 0.0], "to": [0.0, 0.01]}}
    table = {"points": [[s, 0.02 * (1 - s / 0.6), 0.01 * s / 0.6] for s in (0.0, 0.1, 0.45, 0.6)]}
    one, two = (rod_with({"tendon": "t"} | keys) for keys in (line, table))
    shapes = [tip(x, equilibrium(x, efforts=[10.0])) for x in (one, two)]
    np.testing.assert_allclose(*shapes, atol=1e-12)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.25), (0.15, 0.4)])
def test_a_tendon_that_ends_inside_a_section_leaves_the_rest_straight(start, end):
    """Where it ends, the moment T d jumps to zero: κ = T d/EI, Γ = 1 − T/EA between its ends."""
    tension, d = 15.0, 0.02
    dynamics = rod_with({"tendon": "t", "start": start, "end": end, "offset": [d, 0.0]})
    q = equilibrium(dynamics, efforts=[tension])
    dynamics.residual(q, 0 * q, 0 * q, dynamics.forcing([tension]))
    jumps = []
    for _, segment in dynamics.compiled.chain.rod_segments(dynamics.compiled.chain.rods["rod"]):
        k = len(jumps)
        strain = dynamics._data.xi[k, :, 0]
        inside = start < np.mean(segment.span) < end
        moment = EI * strain[:, 2]
        jumps.append(moment[0])
        np.testing.assert_allclose(moment, tension * d if inside else 0.0, atol=1e-10)
        np.testing.assert_allclose(
            EA * (strain[:, 3] - 1), -tension if inside else 0.0, atol=1e-8
        )  # fmt: skip
    assert np.count_nonzero(np.abs(np.diff(jumps)) > 0.1) == (2 if start else 1)
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(
        (end - start) * (d * tension * d / EI + tension / EA), rel=1e-10
    )


def test_a_tendon_over_three_sections_is_three_arcs():
    """κ_i = T d/EI_i in sections of different radius, in a plane: angles add up."""
    document = rod_document(strains=["bend_z"], order=3)
    section = document["bodies"][0]["sections"][0]
    radii = [0.03, 0.025, 0.02]
    document["bodies"][0]["sections"] = [
        section
        | {"name": f"s{i}", "length": 0.2, "cross_section": {"shape": "circle", "radius": r}}
        for i, r in enumerate(radii)
    ]
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.015, 0.0]}]
    dynamics = Dynamics(scene_of(document))
    turn = tip(dynamics, equilibrium(dynamics, efforts=[5.0]))
    angle = sum(5.0 * 0.015 / (E * np.pi * r**4 / 4) * 0.2 for r in radii)
    assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(angle, rel=1e-9)


def test_a_chamber_bends_the_rod_away_and_stretches_it():
    """A pressure is a negative tension: κ = −p A d/EI, Γ = 1 + p A/EA, ΔV = A Δℓ."""
    pressure, d = 4e4, 0.018
    dynamics = rod_with({"chamber": "c", "area": BORE, "offset": [d, 0.0]})
    q = equilibrium(dynamics, efforts=[pressure])
    force = pressure * BORE
    curvature, stretch = -force * d / EI, 1 + force / EA
    angle = curvature * LENGTH
    expected = stretch / curvature * np.array([np.sin(angle), 1 - np.cos(angle), 0.0])
    np.testing.assert_allclose(tip(dynamics, q)[:3, 3], expected, atol=1e-9)
    assert expected[1] < -0.02
    volume = BORE * LENGTH * (stretch - curvature * d - 1)
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(volume, rel=1e-9)
    assert dynamics.compiled.scene.actuators[0].unit == "Pa"


def test_three_chambers_of_a_section_at_one_pressure_only_stretch_it():
    around = 2 * np.pi * np.arange(3) / 3
    chambers = [
        {"chamber": f"c{i}", "section": "s", "area": BORE,
         "offset": [0.02 * np.cos(a), 0.02 * np.sin(a)]}
        for i, a in enumerate(around)
    ]  # fmt: skip
    dynamics = rod_with(*chambers)
    pose = tip(dynamics, equilibrium(dynamics, efforts=3 * [3e4]))
    expected = LENGTH * (1 + 3 * 3e4 * BORE / EA)
    np.testing.assert_allclose(pose[:3, 3], [expected, 0, 0], atol=1e-10)
    # and one of them alone bends in its own plane, away from itself
    pose = tip(dynamics, equilibrium(dynamics, efforts=[0, 3e4, 0]))
    side = pose[1:3, 3] / np.linalg.norm(pose[1:3, 3])
    np.testing.assert_allclose(side, [-np.cos(around[1]), -np.sin(around[1])], atol=1e-9)


def test_the_work_of_pressures_is_all_in_the_ledger():
    document = rod_document(strains=ALL[:4], order=3, material={"viscosity": 500.0},
                            numerics={"integrator": "implicit_midpoint", "step": 1e-3})  # fmt: skip
    document["actuators"] = [
        {"chamber": "a", "rod": "rod", "area": BORE, "offset": [0.02, 0.0]},
        {"chamber": "b", "rod": "rod", "area": BORE, "helix": {"radius": 0.02, "turns": 1.0}},
    ]
    simulation = Simulation(scene_of(document))
    work = 0.0
    for efforts in ([4e4, 0.0], [-1e4, 2e4], [0.0, 0.0]):
        simulation.set_efforts(efforts)
        before = simulation.ports()[0]
        simulation.advance(150)
        work += efforts @ (simulation.ports()[0] - before)
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    assert ledger["actuator_work"] == pytest.approx(work, rel=1e-12)
    assert work > 0.01 and abs(ledger["residual"]) < 2e-3 * work


def test_a_path_that_winds_faster_than_the_nodes_see_is_refused():
    spiral = {"tendon": "t", "helix": {"radius": 0.02, "turns": 6}}
    with pytest.raises(SceneError, match=r"actuators\[0\].tendon = t: .* winds") as failure:
        rod_with(spiral, nodes=20)
    assert "numerics.rods.rod" in str(failure.value)
    # by default there are enough: the length of a helix in a straight rod
    dynamics = rod_with(spiral)
    true = np.hypot(LENGTH, 2 * np.pi * 6 * 0.02)
    assert dynamics.model.tendon_rest[0] == pytest.approx(true, rel=1e-12)
