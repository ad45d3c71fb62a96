"""Tendons and chambers that run over several rods: as over one, where nothing moves between."""

import copy

import numpy as np
import pytest
from scenes import ALL, SOFT, scene_of

from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

LENGTHS = (0.25, 0.15)
PATHS = {
    "offset": {"offset": {"from": [0.02, 0.01], "to": [-0.01, 0.015]}, "start": 0.05, "end": 0.35},
    "helix": {"helix": {"radius": [0.02, 0.01], "angle": 0.4, "turns": 0.8}},
    "points": {"points": [[0.02, 0.02, 0.0], [0.2, 0.0, 0.02], [0.3, -0.02, 0.0], [0.4, 0.0, 0.0]]},
}
KINDS = {
    "tension": ({"tendon": "t"}, 3.0),
    "friction": ({"tendon": "t", "friction": 0.3}, 3.0),
    "length": ({"tendon": "t", "control": "length", "axial_stiffness": 500.0,
                "axial_damping": 0.5, "friction": 0.2}, 0.01),
    "chamber": ({"chamber": "t", "area": 2e-4}, 3e4),
}  # fmt: skip


def document(split, actuators, between=()):
    """Return an arm of two sections: one rod, or two rods with something between them."""
    sections = [
        {"name": name, "length": length, "material": "soft",
         "cross_section": {"shape": "circle", "radius": 0.02}}
        for name, length in zip("ab", LENGTHS, strict=True)
    ]  # fmt: skip
    material = SOFT | {"viscosity": 500.0, "maxwell": {"ratio": 0.5, "time": 0.05}}
    material["rayleigh"] = {"mass": 0.5}
    rods = [{"rod": "one", "strains": ALL, "sections": sections}]
    if split:
        rods = [
            {"rod": "one", "strains": ALL, "sections": sections[:1]},
            *between,
            {"rod": "two", "strains": ALL, "sections": sections[1:]},
        ]
    where = {"rods": ["one", "two"]} if split else {"rod": "one"}
    return {
        "name": "arm",
        "materials": {"soft": material},
        "bodies": rods,
        "actuators": [copy.deepcopy(actuator) | where for actuator in actuators],
        "numerics": {"basis": {"order": 2}, "step": 0.002, "newton_tolerance": 1e-9},
    }


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_rod_cut_in_two_moves_as_the_whole_one(kind, path):
    keys, effort = KINDS[kind]
    whole, cut = (
        Simulation(scene_of(document(split, [keys | PATHS[path]]))) for split in (False, True)
    )
    start = whole.q.copy()
    for simulation in (whole, cut):
        simulation.set_efforts([effort])
        simulation.advance(50)
    scale = np.abs((whole.q - start) * whole.model.weight).max()
    assert scale > 0.01
    difference = np.abs((whole.q - cut.q) * whole.model.weight).max()
    assert difference < 1e-9 * scale
    for one, other in zip(whole.ports(), cut.ports(), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(whole.ledger(), cut.ledger(), atol=1e-9 * np.abs(whole.ledger()[3]))


FLANGE = (
    {"rigid_body": "plate", "mass": 0.05, "com": {"position": [0.01, 0.0, 0.0]}},
    {"joint": "flange", "kind": "fixed",
     "offset": {"position": [0.02, 0.01, 0.0], "rpy": [0.3, 0.2, -0.1]}},
)  # fmt: skip
HINGE = [{"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0]}]
STRAIGHT = {"tendon": "t", "offset": [0.02, 0.01], "control": "length", "axial_stiffness": 300.0}


def measured_length(dynamics, q):
    """Length of the line of points that the tendon runs through, from poses alone."""
    poses, chain = dynamics.node_poses(q), dynamics.compiled.chain
    nodes = [k for m in chain.rods.values() for k in range(m.first_node, m.last_node + 1)]
    points = np.array([poses[k][:3, :3] @ [0.0, 0.02, 0.01] + poses[k][:3, 3] for k in nodes])
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def test_across_a_flange_the_port_is_the_length_of_the_line_through_space():
    scene = document(True, [STRAIGHT], FLANGE)
    scene["numerics"]["basis"]["nodes"] = 60
    dynamics = Dynamics(scene_of(scene))
    zero = np.zeros(dynamics.n)
    q = zero.copy()
    q[[i for i, n in enumerate(dynamics.compiled.coordinate_names) if n.endswith("bend_y/0")]] = 2.0
    shorter = measured_length(dynamics, zero) - measured_length(dynamics, q)
    # chords from node to node are shorter than the arcs
    assert dynamics.ports(q, zero)[0][0] == pytest.approx(shorter, rel=5e-4)
    # the whole tendon stretches, with the piece across the flange: T = EA e / ℓ₀
    effort = 0.01
    tension = dynamics.port_efforts(zero, zero, np.array([effort]))[0]
    assert tension == pytest.approx(300.0 * effort / measured_length(dynamics, zero), rel=1e-6)


@pytest.mark.parametrize("keys", [STRAIGHT, STRAIGHT | {"friction": 0.4}])
def test_tangent_and_work_across_a_flange(keys):
    """The generalised force is effort · ∂y/∂q, and the exact tangent is its difference quotient."""
    dynamics = Dynamics(scene_of(document(True, [keys], FLANGE)))
    rng = np.random.default_rng(4)
    q, v = 0.05 * rng.normal(size=(2, dynamics.n)) / dynamics.model.weight
    zero, effort = np.zeros(dynamics.n), np.array([0.03])
    exact = dynamics.tangents(q, v, zero, effort)[0]
    rows = []
    for e in np.diag(1e-5 / dynamics.model.weight):
        ahead, behind = (dynamics.inverse_dynamics(q + s * e, v, zero, effort) for s in (1, -1))
        rows.append((ahead - behind) / (2.0 * e.sum()))
    units = np.outer(*2 * [dynamics.model.weight])
    error = np.abs(exact - np.array(rows).T) / units
    assert error.max() < 1e-6 * (np.abs(exact) / units).max()
    if "friction" not in keys:
        tension = dynamics.port_efforts(q, v, effort)
        without = dynamics.inverse_dynamics(q, v, zero, np.array([-1.0]))  # slack
        force = without - dynamics.inverse_dynamics(q, v, zero, effort)
        assert force @ v == pytest.approx(float(tension @ dynamics.ports(q, v)[1]), rel=1e-9)


@pytest.mark.parametrize(
    ("rods", "between", "expected"),
    [
        (["one", "two"], HINGE, "hinge moves"),
        (["two", "one"], [], "order from base to tip"),
        (["one", "one"], [], "only once"),
        (["one", "tow"], [], "two"),
        ([], [], "at least one"),
    ],
)  # fmt: skip
def test_rods_that_no_tendon_can_run_over_are_refused(rods, between, expected):
    scene = document(True, [STRAIGHT], between)
    scene["actuators"][0]["rods"] = rods
    with pytest.raises(SceneError, match=expected) as caught:
        scene_of(scene)
    assert caught.value.key_path.startswith("actuators[0].rods")
