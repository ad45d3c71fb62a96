"""A flexible tree against finite elements in absolute coordinates, which share nothing with it.

Every rod is a row of rigid bodies at equal distances, each with its own six coordinates in the
world, and an elastic element between two of them whose strain is constant (a twist of one relative
to the other, as Sonneville, Cardona and Brüls 2014). Forces and stiffness come from difference
quotients of the strains. It is of second order, so two resolutions say where it leads to.
"""

import numpy as np
from forests import forest_document, place, rod, scene_of
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.modes import frequencies
from soft_sim_ros.core.settled import Simulation

GRAVITY = np.array([1.0, -2.0, -9.0])
RADIUS, YOUNG, DENSITY = 0.02, 1e6, 1000.0
MATERIAL = {"soft": {"young_modulus": YOUNG, "poisson_ratio": 0.5, "density": DENSITY}}
# name: length in m, parent, arc length on it, place and angles there
RODS = {
    "stem": (0.4, None, None, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    "branch": (0.2, "stem", 0.2, [0.0, 0.02, 0.01], [0.3, 0.2, 1.1]),
    "twig": (0.2, "branch", 0.1, [0.0, 0.0, 0.0], [0.5, -0.9, 0.3]),
}
RING = (0.3, 0.15, [2e-4, 1e-4, 1.5e-4])  # s on the stem in m, kg, kg·m²
MODES = 6


def tree():
    """The tree of the package, well resolved."""
    bodies = []
    for name, (length, parent, s, position, rpy) in RODS.items():
        where = None if parent is None else place(parent, s, position=position, rpy=rpy)
        bodies.append(rod(name, length, where))
    s, mass, inertia = RING
    ring = {"rigid_body": "ring", "mass": mass, "inertia": inertia, "parent": place("stem", s)}
    numerics = {"basis": {"order": 3}}
    document = forest_document([*bodies, ring], materials=MATERIAL, numerics=numerics)
    return Simulation(
        scene_of(document | {"gravity": GRAVITY, "initial": {"state": "equilibrium"}})
    )


def strains(turn, way, length):
    """Strains (…, E, 6), angular first, of relative rotations and ways in m, (…, E, 3)."""
    phi = Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().reshape(way.shape)
    square = (phi**2).sum(axis=-1, keepdims=True)
    half = 0.5 * np.sqrt(np.maximum(square, 1e-4))
    factor = (1.0 - half / np.tan(half)) / (4.0 * half**2)
    factor = np.where(square < 1e-4, 1.0 / 12.0 + square / 720.0, factor)
    once = np.cross(phi, way)
    straight = way - 0.5 * once + factor * np.cross(phi, once)
    out = np.concatenate([phi, straight], axis=-1) / length[:, None]
    out[..., 3] -= 1.0
    return out


def times(matrix, vector):
    """Matrices times vectors, whatever is in front."""
    return (matrix @ vector[..., None])[..., 0]


class Elements:
    """Bodies 1 … B with poses in the world; body 0 is the world itself."""

    def __init__(self, per_rod, near=None):
        self.turn, self.place = [np.eye(3)], [np.zeros(3)]
        self.pairs, self.lengths, self.offsets = [], [], []
        self.masses = []  # body, kg, kg·m² (3, 3) and the place of it (3,) in its frame
        self.nodes = {}
        area, second = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
        shear = 0.9 * area / 3  # Cowper 1966, of a circle: 6 (1 + ν)/(7 + 6 ν)
        self.law = YOUNG * np.array([2 * second / 3, second, second, area, shear, shear])
        for name, (length, parent, s, position, rpy) in RODS.items():
            h = length / per_rod
            share = DENSITY * h * np.array([area, 2 * second, second, second])
            first = (
                0 if parent is None else self.nodes[parent][round(s * per_rod / RODS[parent][0])]
            )
            offset = Rotation.from_euler("xyz", rpy).as_matrix()
            own = self.nodes[name] = [first]
            turn = self.turn[first] @ offset
            begin = self.place[first] + self.turn[first] @ position
            tensor = offset @ np.diag(share[1:]) @ offset.T
            self.masses.append((first, share[0] / 2, tensor / 2, np.array(position)))
            for i in range(1, per_rod + 1):
                before = (offset, np.array(position)) if i == 1 else (np.eye(3), np.zeros(3))
                self.pairs.append((own[-1], len(self.turn)))
                self.offsets.append(before)
                self.lengths.append(h)
                own.append(len(self.turn))
                part = 0.5 if i == per_rod else 1.0
                self.masses.append(
                    (own[-1], part * share[0], part * np.diag(share[1:]), np.zeros(3))
                )
                self.turn.append(turn)
                self.place.append(begin + turn @ [i * h, 0.0, 0.0])
        s, mass, inertia = RING
        ring = self.nodes["stem"][round(s * per_rod / RODS["stem"][0])]
        self.masses.append((ring, mass, np.diag(inertia), np.zeros(3)))
        self.turn, self.place = np.array(self.turn), np.array(self.place)
        if near is not None:  # a shape to begin from
            for name, own in self.nodes.items():
                poses = near.sampler(per_rod + 1, backbone=name).poses()[1:]
                self.place[own[1:]] = poses[:, :3]
                self.turn[own[1:]] = Rotation.from_quat(poses[:, 3:]).as_matrix()
        self.pairs, self.lengths = np.array(self.pairs), np.array(self.lengths)
        self.first_turn = np.array([turn for turn, _ in self.offsets])
        self.first_place = np.array([way for _, way in self.offsets])

    def ends(self):
        """Places (rods, 3) in m of the ends of all rods."""
        return self.place[[self.nodes[name][-1] for name in RODS]]

    def strain(self, moves):
        """Strains (M, E, 6) after the two bodies of each element have moved by (M, 12)."""
        a, b = self.pairs.T
        one, two = (
            self.turn[k] @ Rotation.from_rotvec(moves[:, i : i + 3]).as_matrix()[:, None]
            for k, i in ((a, 0), (b, 6))
        )
        begin = self.place[a] + times(self.turn[a], moves[:, None, 3:6])
        begin = begin + times(one, self.first_place)
        end = self.place[b] + times(self.turn[b], moves[:, None, 9:])
        back = np.swapaxes(one @ self.first_turn, -1, -2)
        return strains(back @ two, times(back, end - begin), self.lengths)

    def differences(self):
        """Strains (E, 6), their slopes (12, E, 6) and curvatures (12, 12, E, 6) by moves."""
        size = 1e-4 * np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1] * 2)
        steps = np.diag(size)
        near, far = (self.strain(k * steps) - self.strain(-k * steps) for k in (1, 2))
        slope = (8 * near - far) / (12 * size[:, None, None])
        e, d = (each.reshape(-1, 12) for each in np.broadcast_arrays(steps[:, None], steps[None]))
        bend = self.strain(e + d) - self.strain(e - d) - self.strain(d - e) + self.strain(-e - d)
        bend = bend.reshape(12, 12, -1, 6) / (4 * np.outer(size, size)[:, :, None, None])
        return self.strain(np.zeros((1, 12)))[0], slope, bend

    def forces(self):
        """Gradient (6 B,), stiffness and mass matrix (6 B, 6 B) of all bodies but the world."""
        here, slope, bend = self.differences()
        law = self.lengths[:, None] * self.law
        gradient = np.einsum("ek,jek->ej", law * here, slope)
        stiff = np.einsum("jek,ek,iek->eji", slope, law, slope)
        stiff += np.einsum("ek,jiek->eji", law * here, bend)
        total = 6 * len(self.turn)
        force, matrix, mass = np.zeros(total), np.zeros((total, total)), np.zeros((total, total))
        for (a, b), f, k in zip(self.pairs, gradient, stiff, strict=True):
            at_both = np.r_[6 * a : 6 * a + 6, 6 * b : 6 * b + 6]
            force[at_both] += f
            matrix[np.ix_(at_both, at_both)] += k
        for body, m, tensor, p in self.masses:
            own = slice(6 * body, 6 * body + 6)
            weight = m * self.turn[body].T @ GRAVITY
            force[own] -= np.concatenate([np.cross(p, weight), weight])
            spin = np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
            outer = np.outer(weight, p)
            turning = slice(6 * body, 6 * body + 3)
            matrix[turning, turning] -= 0.5 * (outer + outer.T) - p @ weight * np.eye(3)
            mass[own, own] += np.block(
                [[tensor - m * spin @ spin, m * spin], [-m * spin, m * np.eye(3)]]
            )
        return force[6:], matrix[6:, 6:], mass[6:, 6:]

    def rest(self):
        """Come to rest by Newton's method; return the natural frequencies in Hz."""
        for _ in range(12):
            force, matrix, mass = self.forces()
            move = np.linalg.solve(matrix, -force).reshape(-1, 6)
            self.place[1:] += (self.turn[1:] @ move[:, 3:, None])[:, :, 0]
            self.turn[1:] = self.turn[1:] @ Rotation.from_rotvec(move[:, :3]).as_matrix()
            if np.abs(move).max() < 1e-6:  # the next one is its square
                squares = eigh(matrix, mass, subset_by_index=[0, MODES - 1], eigvals_only=True)
                return np.sqrt(squares) / (2 * np.pi)
        raise AssertionError("Newton's method found no rest")


def test_a_flexible_tree_rests_and_swings_as_finite_elements_in_absolute_coordinates_do():
    """Twice the elements, a quarter of the distance; extrapolated, 10⁻⁵ of the way they sag."""
    simulation = tree()
    dynamics, q = simulation.dynamics, simulation.q
    ends = dynamics.node_poses(q)[[dynamics.compiled.node_of(name) for name in RODS], :3, 3]
    hertz = frequencies(dynamics, q, MODES)
    straight = Elements(4)
    sagged = np.linalg.norm(straight.ends() - ends, axis=1)
    assert sagged.min() > 0.3
    places, tones = [], []
    for per_rod in (8, 16):
        elements = Elements(per_rod, simulation)
        tones.append(elements.rest())
        places.append(elements.ends())
    apart = [np.linalg.norm(found - ends, axis=1).max() for found in places]
    out_of_tune = [np.abs(found / hertz - 1.0).max() for found in tones]
    assert 3.7 < apart[0] / apart[1] < 4.3
    assert 3.7 < out_of_tune[0] / out_of_tune[1] < 4.6
    np.testing.assert_allclose((4 * places[1] - places[0]) / 3, ends, atol=1e-5)
    np.testing.assert_allclose((4 * tones[1] - tones[0]) / 3, hertz, rtol=3e-4)
