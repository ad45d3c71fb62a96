"""PyElastica, run in its own environment: reads one job as JSON, prints one JSON line per run.

Equal physics: PyElastica's section law thins a stretched section (stiffness over dilatation) and it
has no material damping. Two small pieces through its public arrays and interfaces change that: the
stiffness arrays are multiplied by the powers of the dilatation that its kernels divide by, so that
the law is linear per reference length; a user-defined forcing adds Kelvin–Voigt forces. Rotary
inertia keeps its dependence on dilatation (an effect of the order of strain times (r/L)²).

The clamp fixes a node and a whole element. With ``clamp: shifted`` the rod begins half an element
before the base, as somebody who knows this would set it up: bending then starts at the base.
"""

import json
import resource
import sys
import time

import elastica as ea
import numpy as np
from numba import njit

GENTLE = 0.98


@njit(cache=True)
def linear_law(position, rest_lengths, rest_voronoi, shear0, bend0, shear, bend):
    """Multiply the stiffness arrays by e and by the third power of the Voronoi dilatation."""
    n = rest_lengths.shape[0]
    last = 0.0
    for k in range(n):
        length = 0.0
        for i in range(3):
            length += (position[i, k + 1] - position[i, k]) ** 2
        length = np.sqrt(length)
        e = length / rest_lengths[k]
        for i in range(3):
            shear[i, i, k] = shear0[i, i, k] * e
        if k > 0:
            dilatation = 0.5 * (length + last) / rest_voronoi[k - 1]
            for i in range(3):
                bend[i, i, k - 1] = bend0[i, i, k - 1] * dilatation**3
        last = length


@njit(cache=True)
def kelvin_voigt(position, velocity, omega, q, kappa, rest, voronoi, shear, bend, force, torque):
    """Add forces (3, n+1) and body torques (3, n) of viscous strains; shear, bend (3,) viscosities.

    Strain rates: Q v' − ω × Q r' and ω' + κ × ω.
    """
    n = rest.shape[0]
    tangent, rate, lab = np.empty(3), np.empty(3), np.empty(3)
    for k in range(n):
        for i in range(3):
            tangent[i], rate[i] = 0.0, 0.0
            for j in range(3):
                tangent[i] += q[i, j, k] * (position[j, k + 1] - position[j, k]) / rest[k]
                rate[i] += q[i, j, k] * (velocity[j, k + 1] - velocity[j, k]) / rest[k]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            lab[i] = shear[i] * (rate[i] - omega[a, k] * tangent[b] + omega[b, k] * tangent[a])
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            torque[i, k] += rest[k] * (tangent[a] * lab[b] - tangent[b] * lab[a])
            f = q[0, i, k] * lab[0] + q[1, i, k] * lab[1] + q[2, i, k] * lab[2]
            force[i, k] += f
            force[i, k + 1] -= f
    for k in range(n - 1):
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            mean_a = 0.5 * (omega[a, k] + omega[a, k + 1])
            mean_b = 0.5 * (omega[b, k] + omega[b, k + 1])
            turn = kappa[a, k] * mean_b - kappa[b, k] * mean_a
            lab[i] = bend[i] * ((omega[i, k + 1] - omega[i, k]) / voronoi[k] + turn)
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            half = 0.5 * voronoi[k] * (kappa[a, k] * lab[b] - kappa[b, k] * lab[a])
            torque[i, k] += lab[i] + half
            torque[i, k + 1] += half - lab[i]


class KelvinVoigt(ea.NoForces):
    """Material damping η·diag(3I, 3I, J; A, A, 3A) in PyElastica's order (axis last)."""

    def __init__(self, shear, bend):
        super().__init__()
        self.shear, self.bend = shear, bend

    def apply_forces(self, system, time=0.0):
        kelvin_voigt(
            system.position_collection, system.velocity_collection, system.omega_collection,
            system.director_collection, system.kappa, system.rest_lengths,
            system.rest_voronoi_lengths, self.shear, self.bend, system.external_forces,
            system.external_torques,
        )  # fmt: skip


class SectionMoments(ea.NoForces):
    """Couples at both ends of a section: what a constant internal moment along it amounts to.

    The moment belongs to the section frame; at nodes inside the section the internal moment turns
    with it, so it is applied as a couple stress: m' + κ × m per length, in the elements' frames.
    An end of a section inside a Voronoi region counts with its share of the region, which keeps the
    second order in the grid wherever the sections end.
    """

    def __init__(self, axes, shares, period, values):
        super().__init__()
        self.axes, self.shares, self.period, self.values = axes, shares, period, values

    def apply_torques(self, system, time=0.0):
        row = self.values[min(int(time / self.period + 1e-9), len(self.values) - 1)]
        section_moments(
            system.kappa, system.rest_voronoi_lengths, self.axes, self.shares, row,
            system.external_torques,
        )  # fmt: skip


@njit(cache=True)
def section_moments(kappa, voronoi, axes, shares, row, torque):
    """Add the couples of internal moments ``row`` about ``axes``; shares (channels, n − 1)."""
    m = np.zeros(3)
    for c in range(axes.shape[0]):
        for k in range(shares.shape[1]):
            if shares[c, k] > 0.0:
                m[:] = 0.0
                m[axes[c]] = row[c] * shares[c, k]
                for i in range(3):
                    a, b = (i + 1) % 3, (i + 2) % 3
                    half = -0.5 * voronoi[k] * (kappa[a, k] * m[b] - kappa[b, k] * m[a])
                    torque[i, k] += half - m[i]
                    torque[i, k + 1] += half + m[i]


class HubTorque(ea.NoForces):
    """A torque about the fixed hinge axis on the first element."""

    def __init__(self, hub, axis):
        super().__init__()
        self.hub, self.axis = hub, axis

    def apply_torques(self, system, time=0.0):
        hub = self.hub
        factor = min(time / hub["ramp"], (hub["end"] - time) / hub["ramp"], 1.0)
        if factor > 0.0:
            value = hub["value"] * factor
            system.external_torques[:, 0] += system.director_collection[:, :, 0] @ (
                value * self.axis
            )


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What a run needs of PyElastica's modules."""


# PyElastica: (d1, d2, d3) with d3 along the rod; here: (x along the rod, y, z).
# d1 = y, d2 = z, d3 = x.
ORDER = (1, 2, 0)


def helix(case, s):
    """Poses of a rod of uniform strain: positions (3, len(s)) and frames, by the exponential."""
    kappa = np.array(case["offset"][:3])
    size = np.linalg.norm(kappa)
    frames = []
    hat = np.array([
        [0, -kappa[2], kappa[1]], [kappa[2], 0, -kappa[0]], [-kappa[1], kappa[0], 0],
    ])  # fmt: skip
    points = []
    for x in s:
        if size < 1e-12:
            frames.append(np.eye(3))
            points.append([x, 0.0, 0.0])
            continue
        turn = np.eye(3) + np.sin(size * x) / size * hat
        turn += (1 - np.cos(size * x)) / size**2 * hat @ hat
        shift = x * np.eye(3) + (1 - np.cos(size * x)) / size**2 * hat
        shift += (size * x - np.sin(size * x)) / size**3 * hat @ hat
        frames.append(turn)
        points.append(shift[:, 0])
    return np.array(points).T, frames


def build(case, settings):
    """Return (simulator, rod, element length)."""
    n, length = settings["elements"], case["length"]
    r, rho, young, eta = case["radius"], case["density"], case["young"], case["viscosity"]
    # bending starts half an element after the first node
    shift = 0.0
    if settings.get("clamp") == "shifted" and not case["hinge"]:
        shift = 0.5 * length / (n - 0.5)
    total = length + shift
    dl = total / n
    nodes = np.linspace(-shift, length, n + 1)
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    inside = np.maximum(nodes, 0.0)
    position, _ = helix(case, inside)
    position[0] += nodes - inside
    _, frames = helix(case, np.maximum(middles, 0.0))
    directors = np.zeros((3, 3, n))
    for k, frame in enumerate(frames):
        for i, column in enumerate(ORDER):
            directors[i, :, k] = frame[:, column]
    rod = ea.CosseratRod.straight_rod(
        n, np.array([-shift, 0.0, 0.0]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), total, r,
        density=rho, youngs_modulus=young, shear_modulus=case["shear"],
    )  # fmt: skip
    area, second = np.pi * r**2, np.pi / 4 * r**4
    shear = case["shear"]
    for i, value in enumerate((shear * area, shear * area, young * area)):
        rod.shear_matrix[i, i, :] = value
    for i, value in enumerate((young * second, young * second, 2 * shear * second)):
        rod.bend_matrix[i, i, :] = value
    rod.position_collection[:] = position
    rod.director_collection[:] = directors
    simulator = Simulator()
    simulator.append(rod)
    if case["hinge"]:
        # rotation about one axis of the inertial frame stays free
        axes = np.array([axis != case["hinge"] for axis in "xyz"])
        simulator.constrain(rod).using(
            ea.GeneralConstraint,
            constrained_position_idx=(0,), constrained_director_idx=(0,),
            translational_constraint_selector=np.array([True, True, True]),
            rotational_constraint_selector=axes,
        )  # fmt: skip
    else:
        simulator.constrain(rod).using(
            ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
        )
    if any(case["gravity"]):
        gravity = np.array(case["gravity"], dtype=float)
        simulator.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=gravity)
    if eta > 0.0:
        simulator.add_forcing_to(rod).using(
            KelvinVoigt,
            shear=eta * area * np.array([1.0, 1.0, 3.0]),
            bend=eta * second * np.array([3.0, 3.0, 2.0]),
        )
    if case["moments"]:
        ends = np.concatenate([[0.0], np.cumsum(case["sections"])])
        axes, shares = [], []
        for section, strain in case["moments"]["channels"]:
            axes.append({"bend_y": 0, "bend_z": 1, "torsion": 2}[strain])
            low = np.maximum(middles[:-1], ends[section])
            high = np.minimum(middles[1:], ends[section + 1])
            shares.append(np.maximum(high - low, 0.0) / dl)
        simulator.add_forcing_to(rod).using(
            SectionMoments,
            axes=np.array(axes, dtype=np.int64),
            shares=np.array(shares),
            period=case["moments"]["period"],
            values=np.array(case["moments"]["values"], dtype=float),
        )
    if case["hub"]:
        axis = np.array([float(a == case["hinge"]) for a in "xyz"])
        simulator.add_forcing_to(rod).using(HubTorque, hub=case["hub"], axis=axis)
    simulator.finalize()
    (block,) = simulator.final_systems()
    shear0, bend0 = block.shear_matrix.copy(), block.bend_matrix.copy()
    plain = block.compute_internal_forces_and_torques

    def with_linear_law(time):
        linear_law(
            block.position_collection, block.rest_lengths, block.rest_voronoi_lengths,
            shear0, bend0, block.shear_matrix, block.bend_matrix,
        )  # fmt: skip
        plain(time)

    block.compute_internal_forces_and_torques = with_linear_law
    return simulator, rod, dl


def estimated_step(case, dl):
    """Return a step that is stable: explicit waves, shear over rotary inertia, lagged damping."""
    speed = np.sqrt(case["young"] / case["density"])
    shear = np.sqrt(case["shear"] / case["density"]) / (0.5 * case["radius"])
    top = np.hypot(2.0 * speed / dl, shear)
    damping = case["viscosity"] / case["shear"] * top**2
    return 1.0 / (0.5 * top + 0.5 * damping + 1e-300)


def survives(case, settings, h, steps):
    """Whether a noisy rod is still in one piece after some steps."""
    simulator, rod, _ = build(case, settings)
    (block,) = simulator.final_systems()
    rng = np.random.default_rng(0)
    size = 1e-6 * np.sqrt(case["young"] / case["density"])
    moving = block.velocity_collection[:, 1:]
    moving += size * rng.normal(size=moving.shape)
    stepper, time_now = ea.PositionVerlet(), np.float64(0.0)
    with np.errstate(all="ignore"):
        for _ in range(steps):
            time_now = stepper.step(simulator, time_now, h)
    speed = np.max(np.abs(rod.velocity_collection))
    return bool(np.isfinite(speed) and speed < 0.1 * np.sqrt(case["young"] / case["density"]))


def largest_stable_step(case, settings, dl):
    """Search by factors of 1.2, with runs of 1500 steps."""
    h = estimated_step(case, dl)
    while not survives(case, settings, h, 1500):
        h /= 2.0
    while survives(case, settings, 1.2 * h, 1500) and h < 1e-2:
        h *= 1.2
    return h


def run(case, settings, limit):
    """Run one setting at its largest stable step."""
    simulator, rod, dl = build(case, settings)
    stepper = ea.PositionVerlet()
    stable = largest_stable_step(case, settings, dl)
    wanted = GENTLE * stable * settings.get("fraction", 1.0)
    period = case["duration"] / case["outputs"]
    per_output = int(np.ceil(period / wanted))
    h = period / per_output
    steps = per_output * case["outputs"]
    out = {"coordinates": 6 * settings["elements"], "steps": steps, "step": h, "tip": []}
    time_now = np.float64(0.0)
    begin = time.process_time()
    for _ in range(200):
        time_now = stepper.step(simulator, time_now, h)
    each = (time.process_time() - begin) / 200
    if each * steps > limit:
        out["reason"] = f"{steps} steps of {each * 1e6:.0f} us: over the limit of {limit:g} s"
        return out | {"outcome": "skipped", "wall_s": each * steps}
    walls, cpus = [], []
    while True:
        simulator, rod, dl = build(case, settings)
        tip, time_now = [], np.float64(0.0)
        begin, begin_cpu = time.perf_counter(), time.process_time()
        with np.errstate(all="ignore"):
            for _ in range(case["outputs"]):
                for _ in range(per_output):
                    time_now = stepper.step(simulator, time_now, h)
                tip.append(rod.position_collection[:, -1].tolist())
                if not np.isfinite(tip[-1]).all() or np.max(np.abs(tip[-1])) > 3 * case["length"]:
                    out["reason"] = f"not finite or out of reach at {time_now:.3f} s"
                    wall = time.perf_counter() - begin
                    return out | {"outcome": "diverged", "wall_s": wall}
        walls.append(time.perf_counter() - begin)
        cpus.append(time.process_time() - begin_cpu)
        if len(walls) == 3 or sum(walls) > 2.0:
            costs = {"wall_s": min(walls), "cpu_s": min(cpus)}
            return out | costs | {"outcome": "completed", "tip": tip}


def main():
    """Read the job, print a line per run."""
    job = json.load(sys.stdin)
    resource.setrlimit(resource.RLIMIT_CPU, (job["everything"], job["everything"]))
    for settings in job["settings"]:
        result = run(job["case"], settings, job["limit"])
        print(json.dumps(result | {"settings": settings}), flush=True)


if __name__ == "__main__":
    main()
