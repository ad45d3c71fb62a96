"""A forest against other formulations: absolute coordinates, another frame, two scenes."""

import numpy as np
from absolute import Absolute
from forests import EFFORTS, forest_document, place, rod, scene_of, tree_document
from scenes import random_state
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Dynamics, Simulation

GRAVITY = [1.0, -2.0, -9.0]
BASE = {"position": [0.3, -0.2, 1.1], "rpy": [0.4, -0.7, 1.9]}


def matrix(position=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)):
    """Pose (4, 4) of a position in m and of angles about fixed axes in rad."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    out[:3, 3] = position
    return out


class Seen:
    """What the package says of a state of a scene, in the world."""

    def __init__(self, dynamics, seed):
        self.dynamics = dynamics
        self.q, self.v, _ = random_state(dynamics, seed)
        self.efforts = np.random.default_rng(seed).uniform(0.1, 0.5, dynamics.actuators)
        self.a = dynamics.forward_dynamics(self.q, self.v, self.efforts)
        self.poses = dynamics.node_poses(self.q)
        self.twists = dynamics.node_twists(self.q, self.v)
        jacobian, rate = dynamics.jacobians(self.q, self.v)
        self.rates = jacobian @ self.a + rate @ self.v

    def coordinates(self, name):
        names = self.dynamics.compiled.coordinate_names
        return [i for i, own in enumerate(names) if own.split("/")[0] == name]

    def motion(self, node):
        """Angular velocity and velocity (3,) of a node, and their rates."""
        turn, twist, rate = self.poses[node][:3, :3], self.twists[node], self.rates[node]
        drift = np.cross(twist[:3], twist[3:])
        return (
            *(turn @ twist[:3], turn @ twist[3:]),
            *(turn @ rate[:3], turn @ (rate[3:] + drift)),
        )


# name, parent, kind of joint, its axis, its place and angles on the parent, mass, inertia, centre
TREE = [
    ("hub", "base", "revolute", [0.3, 0.5, -0.8], [0.0, 0.02, 0.1], [0.1, 0.2, 0.3],
     0.8, [2e-3, 3e-3, 4e-3], [0.05, 0.01, -0.02]),
    ("left", "hub", "spherical", None, [0.1, 0.1, 0.0], [0.0, 0.4, 0.9],
     0.3, [1e-3, 2e-3, 2.5e-3], [0.1, 0.0, 0.0]),
    ("right", "hub", "revolute", [0.0, 1.0, 0.0], [0.1, -0.1, 0.0], [0.5, 0.0, -0.9],
     0.4, [1e-3, 2e-3, 2e-3], [0.1, 0.02, 0.0]),
    ("finger", "left", "revolute", [0.0, 0.6, 0.8], [0.2, 0.0, 0.0], [0.0, 0.0, 0.3],
     0.1, [1e-4, 2e-4, 2e-4], [0.05, 0.0, 0.01]),
    ("thumb", "left", "revolute", [1.0, 0.2, 0.0], [0.15, 0.05, 0.0], [0.7, 0.1, 0.0],
     0.15, [1e-4, 1.5e-4, 2e-4], [0.0, 0.06, 0.0]),
    ("ball", "right", "spherical", None, [0.25, 0.0, 0.0], [0.0, 0.0, 0.0],
     0.2, [3e-4, 2e-4, 4e-4], [0.08, 0.0, 0.03]),
    ("tail", "ball", "revolute", [0.0, 0.0, 1.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0],
     0.1, [1e-4, 1e-4, 1e-4], [0.04, 0.0, 0.0]),
    ("other", "base", "spherical", None, [0.0, 0.6, 0.0], [0.0, 1.0, 0.0],
     0.5, [2e-3, 1e-3, 2e-3], [0.2, 0.0, 0.0]),
]  # fmt: skip
STIFF = 0.7  # N·m/rad, of every hinge
DAMPED = 0.05  # N·m·s/rad
PUSH, TURN = np.array([0.4, -0.3, 0.7]), np.array([0.02, 0.01, -0.03])


def unit(axis):
    return np.array(axis) / np.linalg.norm(axis)


def rigid_tree():
    bodies, motors = [], []
    for name, parent, kind, axis, position, rpy, mass, inertia, com in TREE:
        joint = {"joint": f"to_{name}", "kind": kind, "parent": parent,
                 "offset": {"position": position, "rpy": rpy}}  # fmt: skip
        if axis is not None:
            joint |= {"axis": axis, "stiffness": STIFF, "damping": DAMPED}
            motors.append({"joint_torque": f"turn_{name}", "joint": f"to_{name}"})
        centre = {"position": com, "rpy": [0.3, 0, 0.5]}
        body = {"rigid_body": name, "mass": mass, "inertia": inertia, "com": centre}
        bodies += [joint, body | {"parent": f"to_{name}"}]
    loads = [
        {"point": "push", "body": "ball", "force": PUSH.tolist()},
        {"point": "turn", "body": "thumb", "moment": TURN.tolist(), "frame": "body"},
    ]
    document = forest_document(bodies, actuators=motors, loads=loads, base=BASE, numerics={})
    return Dynamics(scene_of(document | {"gravity": GRAVITY}))


def test_a_rigid_tree_accelerates_as_in_absolute_coordinates():
    """Eight bodies on hinges and balls: twice as many unknowns as needed, and multipliers."""
    dynamics = rigid_tree()
    for seed in range(2):
        seen = Seen(dynamics, seed)
        world = Absolute(6 * len(TREE), GRAVITY)
        frames = {"base": world.ground().fixed(matrix(**BASE))}
        torques = iter(seen.efforts)
        for name, parent, kind, axis, position, rpy, mass, inertia, com in TREE:
            node = dynamics.compiled.node_of(name)
            spin, speed, _, _ = seen.motion(node)
            own = frames[name] = world.body(seen.poses[node], spin, speed)
            world.inertia(own.fixed(matrix(com, [0.3, 0, 0.5])), mass, inertia)
            held = frames[parent].fixed(matrix(position, rpy))
            if kind == "spherical":
                world.ball(held, own)
            else:
                (column,) = seen.coordinates(f"to_{name}")
                world.hinge(held, own, unit(axis))
                torque = next(torques) - STIFF * seen.q[column] - DAMPED * seen.v[column]
                world.motor(held, own, unit(axis), torque)
        world.load(frames["ball"], PUSH, np.zeros(3))
        world.load(frames["thumb"], np.zeros(3), frames["thumb"].turn @ TURN)
        assert np.abs(world.errors).max() < 1e-12
        found = world.accelerations()
        for name, *_ in TREE:
            _, _, turning, going = seen.motion(dynamics.compiled.node_of(name))
            both = np.concatenate(world.of(frames[name], found))
            expected = np.concatenate([turning, going])
            assert np.linalg.norm(expected) > 1.0
            np.testing.assert_allclose(both, expected, atol=1e-9 * np.linalg.norm(expected))


# what hangs where: name, parent, place on it; rods by their lengths
RODS = {"stem": 0.3, "left": 0.2, "twig": 0.15, "finger": 0.1, "second": 0.25}
HELD = {
    "stem": ("base", None, {}),
    "left": ("stem", 0.12, {"position": [0, 0.01, 0], "rpy": [0.1, 0.2, 0.9]}),
    "twig": ("left", 0.07, {"rpy": [0.5, -0.8, 0.3]}),
    "finger": ("left", None, {"rpy": [0.0, 0.3, 0.2]}),
    "second": ("base", None, {"position": [0.0, 0.5, 0.0], "rpy": [0.4, -0.3, 0.2]}),
}
RING = {"mass": 0.1, "inertia": [2e-4, 1e-4, 1.5e-4]}
TOOL = {"mass": 0.05, "inertia": [2e-5, 1e-5, 1e-5]}
AXIS = [0.2, 1.0, 0.1]
SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1e3, "viscosity": 2e3}}


def flexible_tree():
    bodies = [{"joint": "swing", "kind": "revolute", "axis": AXIS, "stiffness": STIFF}]
    for name, (parent, s, offset) in HELD.items():
        bodies.append(
            rod(name, RODS[name], "swing" if name == "stem" else place(parent, s, **offset))
        )
    bodies += [
        {"rigid_body": "ring", "parent": place("stem", 0.2), **RING},
        {"joint": "wrist", "kind": "spherical", "parent": "finger"},
        {"rigid_body": "tool", "parent": "wrist", **TOOL},
    ]
    tendon = {"tendon": "pull", "rod": "left", "offset": [0.01, 0.004]}
    document = forest_document(bodies, base=BASE, materials=SLACK, actuators=[tendon])
    return Dynamics(scene_of(document | {"gravity": GRAVITY}))


def alone(name):
    """One rod with nothing on it, clamped, cut where others are fixed to it in the tree."""
    marks = {s for parent, s, _ in HELD.values() if parent == name and s is not None}
    marks |= {0.2} if name == "stem" else set()
    cuts = [
        {"joint": f"mark{i}", "kind": "fixed", "parent": place(name, s)}
        for i, s in enumerate(sorted(marks))
    ]
    tendons = [{"tendon": "pull", "rod": "left", "offset": [0.01, 0.004]}]
    more = {"actuators": tendons} if name == "left" else {}
    document = forest_document([rod(name, RODS[name]), *cuts], materials=SLACK, **more)
    return Dynamics(scene_of(document | {"gravity": [0, 0, 0]}))


class Loose:
    """A rod of the tree, floating by itself in absolute coordinates."""

    def __init__(self, world, seen, own, name):
        chain, tree = own.compiled.chain, seen.dynamics.compiled.chain
        columns = seen.coordinates(name)
        q, v = seen.q[columns], seen.v[columns]
        local, twists = own.node_poses(q), own.node_twists(q, v)
        jacobian, rate = own.jacobians(q, v)
        last, there = chain.ends[name], tree.ends[name]
        # where its first frame is, and how it moves, by what is seen of its last
        pose = seen.poses[there] @ np.linalg.inv(local[last])
        spin, speed, _, _ = seen.motion(there)
        turn, arm = pose[:3, :3], pose[:3, :3] @ local[last][:3, 3]
        spin = spin - turn @ local[last][:3, :3] @ twists[last][:3]
        speed = speed - turn @ local[last][:3, :3] @ twists[last][3:] - np.cross(spin, arm)
        self.base = world.body(pose, spin, speed)
        self.columns = world.inner(len(columns))
        self.nodes = {}
        for k in range(chain.rods[name].first_node, last + 1):
            self.nodes[k] = world.inside(
                self.base, local[k], self.columns, jacobian[k], twists[k], rate[k] @ v
            )
            world.inertia(self.nodes[k], own.model.inertia[k, 0], own.model.inertia[k, 1:])
        force = -own.elastic_force(q) - own.damping_matrix(q) @ v
        if own.actuators:
            force += own.effort_matrix(q) @ seen.efforts
        world.force[self.columns] += force
        self.accelerations, self._chain, self._name = seen.a[columns], chain, name

    def at(self, s):
        """The frame at an arc length in m; None: its end."""
        if s is None:
            return self.nodes[self._chain.ends[self._name]]
        return self.nodes[self._chain.node_at(self._chain.rods[self._name], s)]


def test_a_flexible_tree_accelerates_as_in_absolute_coordinates():
    """Each rod floats by itself, with its own nodes, and is tied to others by multipliers."""
    dynamics = flexible_tree()
    single = {name: alone(name) for name in RODS}
    for seed in range(2):
        seen = Seen(dynamics, seed)
        world = Absolute(6 * (len(RODS) + 2) + sum(d.n for d in single.values()), GRAVITY)
        base = world.ground().fixed(matrix(**BASE))
        loose = {name: Loose(world, seen, own, name) for name, own in single.items()}
        for name, (parent, s, offset) in HELD.items():
            if name == "stem":
                (column,) = seen.coordinates("swing")
                world.hinge(base, loose[name].base, unit(AXIS))
                world.motor(base, loose[name].base, unit(AXIS), -STIFF * seen.q[column])
                continue
            held = base if parent == "base" else loose[parent].at(s)
            world.weld(held.fixed(matrix(**offset)), loose[name].base)
        rigid = {}
        for name, facts in (("ring", RING), ("tool", TOOL)):
            node = dynamics.compiled.node_of(name)
            rigid[name] = world.body(seen.poses[node], *seen.motion(node)[:2])
            world.inertia(rigid[name], facts["mass"], facts["inertia"])
        world.weld(loose["stem"].at(0.2), rigid["ring"])
        world.ball(loose["finger"].at(None), rigid["tool"])
        assert np.abs(world.errors).max() < 1e-11
        found = world.accelerations()
        for name, own in loose.items():
            expected = own.accelerations * single[name].model.weight
            np.testing.assert_allclose(
                found[own.columns] * single[name].model.weight,
                expected,
                atol=1e-9 * np.abs(expected).max(),
            )
        for name, frame in rigid.items():
            expected = np.concatenate(seen.motion(dynamics.compiled.node_of(name))[2:])
            both = np.concatenate(world.of(frame, found))
            np.testing.assert_allclose(both, expected, atol=1e-9 * np.linalg.norm(expected))


def turned(document, by):
    """The same scene in a world that is moved by a pose (4, 4): base, gravity, dead loads."""
    turn = by[:3, :3]
    moved = by @ matrix(**document["base"])
    rpy = Rotation.from_matrix(moved[:3, :3]).as_euler("xyz")
    loads = [
        load | {key: turn @ load[key] for key in ("force", "moment") if key in load}
        if load.get("frame") != "body"
        else load
        for load in document["loads"]
    ]
    return document | {
        "base": {"position": moved[:3, 3], "rpy": rpy},
        "gravity": turn @ document["gravity"],
        "loads": loads,
    }


def test_a_forest_moves_alike_wherever_the_world_is_seen_from():
    """Base, gravity and dead loads turned and moved; with a driven and a free root, too."""
    document = tree_document(base=BASE)
    document["bodies"] += [
        {"joint": "carried", "kind": "free", "driven": {"x": "0.1*sin(9*t)", "rz": "2*t**2"},
         "parent": "base", "offset": {"position": [0.1, -0.5, 0.0], "rpy": [0.0, 0.3, 1.0]}},
        rod("antenna", 0.2),
        {"joint": "flying", "kind": "free", "parent": "base",
         "offset": {"position": [0.0, -1.0, 0.2], "rpy": [1.0, 0.2, -0.4]}},
        rod("stick", 0.2),
    ]  # fmt: skip
    document["initial"] = {"velocities": {"flying": [1.0, -2.0, 3.0, 0.5, 0.2, 0.1]}}
    by = matrix([3.0, -2.0, 0.5], [2.0, -0.8, 0.7])
    runs = [Simulation(scene_of(each)) for each in (document, turned(document, by))]
    for simulation in runs:
        simulation.set_efforts(EFFORTS)
        simulation.advance(150)
    one, other = runs
    weight = one.model.weight
    assert np.abs(one.q * weight).max() > 0.4
    np.testing.assert_allclose(other.q * weight, one.q * weight, atol=1e-9)
    np.testing.assert_allclose(other.v * weight, one.v * weight, atol=1e-7)
    seen = [simulation.dynamics.node_poses(simulation.q) for simulation in runs]
    np.testing.assert_allclose(seen[1], by @ seen[0], atol=1e-9)
