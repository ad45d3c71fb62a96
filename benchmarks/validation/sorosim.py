"""SoRoSim's bank: its static shapes and its releases, computed again by this package."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
import yaml
from scipy.optimize import lsq_linear

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene import Scene, parse_scene

from ..independent import shooting
from .bank import DIGIT, HALF, LENGTH, Floats, Release, Shape

YOUNG, POISSON, DENSITY, RADIUS = 70e6, 0.4, 1200.0, 0.005
ORDER = 5  # of the strains in each half
# Theirs has no shear: with it the releases swing 3e-4 more slowly than SoRoSim's, all ten of them.
STRAINS = ("torsion", "bend_y", "bend_z", "stretch")
SHEARS = ("shear_y", "shear_z")


def scene(
    gravity: Floats,
    wrenches: Floats | None,
    damping: float = 0.0,
    order: int = ORDER,
    strains: tuple[str, ...] = STRAINS,
) -> Scene:
    """Return the rod, held by wrenches (2, 6) at its middle and tip if there are any."""
    section = {
        "length": HALF, "material": "tpu", "shear_correction": 1.0,
        "cross_section": {"shape": "circle", "radius": RADIUS},
    }  # fmt: skip
    document: dict[str, Any] = {
        "gravity": gravity.tolist(),
        "materials": {
            "tpu": {
                "young_modulus": YOUNG, "poisson_ratio": POISSON, "density": DENSITY,
                "rayleigh": {"stiffness": damping},
            }
        },
        "bodies": [
            {"rod": "rod", "strains": list(strains),
             "sections": [section | {"name": name} for name in ("near", "far")]}
        ],
        "numerics": {
            "step": 0.005, "integrator": "adaptive", "options": {"error": 1e-6},
            "basis": {"order": order},
        },
    }  # fmt: skip
    if wrenches is not None:
        document["loads"] = [
            {"point": name, "body": "rod", "s": s, "moment": w[:3].tolist(),
             "force": w[3:].tolist()}
            for name, s, w in zip(("mid", "tip"), (HALF, LENGTH), wrenches, strict=True)
        ]  # fmt: skip
    return parse_scene(yaml.safe_dump(document), "tpu_rod.yaml")


def ours(shape: Shape, order: int = ORDER) -> Floats:
    """Return the positions (2, stations, 3) of an equilibrium."""
    dynamics = Dynamics(scene(shape.gravity, shape.wrenches, order=order))
    q = equilibrium(dynamics)
    sampler = Sampler(dynamics.compiled, q, np.ascontiguousarray(shape.stations.ravel()))
    return sampler.poses()[:, :3].reshape(shape.positions.shape).copy()


def exact(shape: Shape) -> Floats:
    """Return the positions (2, stations, 3) of the boundary-value problem."""
    area, second = np.pi * RADIUS**2, np.pi / 4 * RADIUS**4
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    bent, stiff = [2 * shear * second, YOUNG * second, YOUNG * second], [np.inf, np.inf]
    stiffness = np.array([*bent, YOUNG * area, *stiff])
    weight = DENSITY * area * shape.gravity
    rod = shooting.Rod((HALF, HALF), stiffness, weight, shape.wrenches)
    return np.array(shooting.solve(rod, list(shape.stations)))[:, :, :3]


def apart(one: Floats, other: Floats) -> float:
    """Return the largest distance of two shapes over the length."""
    return float(np.linalg.norm(one - other, axis=-1).max() / LENGTH)


def within_digits(shape: Shape) -> tuple[float, Shape]:
    """Return how close the shape comes with loads that the file would round to its own.

    That is the largest distance over the length, and the shape with those loads.
    """
    loads = np.concatenate([shape.gravity, shape.wrenches.ravel()])

    def moved(by: Floats) -> Shape:
        changed = loads + by
        return replace(shape, gravity=changed[:3], wrenches=changed[3:].reshape(2, 6))

    start, size = ours(shape), DIGIT
    columns = [(ours(moved(size * unit)) - start).ravel() / size for unit in np.eye(len(loads))]
    gap = (shape.positions - start).ravel()
    by = lsq_linear(np.array(columns).T, gap, bounds=(-DIGIT, DIGIT)).x
    best = moved(by)
    return apart(ours(best), shape.positions), best


def statics(shapes: list[Shape], checked: int = 10) -> dict[str, Any]:
    """Compare all shapes; ``checked`` of them with the boundary-value problem, too."""
    begin = time.thread_time()
    found = {shape.name: ours(shape) for shape in shapes}
    spent = time.thread_time() - begin
    errors = {s.name: apart(found[s.name], s.positions) for s in shapes}
    rows = []
    for shape in shapes[:: max(1, len(shapes) // checked)][:checked]:
        truth = exact(shape)
        nearest, _ = within_digits(shape)
        rows.append({
            "shape": shape.name, "difference": errors[shape.name],
            "ours": apart(found[shape.name], truth), "theirs": apart(shape.positions, truth),
            "within_digits": nearest,
        })  # fmt: skip
    values = np.array(list(errors.values()))
    return {
        "shapes": len(values), "median": float(np.median(values)), "worst": float(values.max()),
        "worst_shape": max(errors, key=lambda name: errors[name]), "cpu_s": spent,
        "checked": rows, "errors": errors,
    }  # fmt: skip


def motion(
    release: Release, order: int = ORDER, strains: tuple[str, ...] = STRAINS
) -> tuple[Floats, Floats]:
    """Return the places (times, 3) of middle and tip of a released rod in m."""
    held = Dynamics(scene(release.gravity, release.wrenches, release.damping, order, strains))
    q = equilibrium(held)
    simulation = Simulation(scene(release.gravity, None, release.damping, order, strains))
    simulation.set_state(q, np.zeros(len(q)))
    sampler = simulation.sampler(3)
    steps = np.rint(release.times * 1e9 / simulation.step_ns).astype(int)
    places = np.zeros((len(steps), 2, 3))
    for k, step in enumerate(steps):
        simulation.advance(int(step) - simulation.step_index)
        places[k] = sampler.poses()[1:, :3]
    return places[:, 0], places[:, 1]


def release_row(release: Release) -> tuple[dict[str, Any], Floats]:
    """Compare one release; return the row and our tip (times, 3)."""
    begin = time.thread_time()
    mid, tip = motion(release)
    spent = time.thread_time() - begin
    sheared = motion(release, strains=STRAINS + SHEARS)[1]
    at_tip = np.linalg.norm(tip - release.tip, axis=1) / LENGTH
    at_mid = np.linalg.norm(mid - release.mid, axis=1) / LENGTH
    return {
        "release": release.name, "damping_s": release.damping,
        "swing": float(np.ptp(release.tip, axis=0).max() / LENGTH),
        "tip_worst": float(at_tip.max()), "tip_rms": float(np.sqrt(np.mean(at_tip**2))),
        "tip_first": float(at_tip[0]), "tip_last": float(at_tip[-1]),
        "mid_worst": float(at_mid.max()), "cpu_s": spent,
        "tip_worst_with_shear": apart(sheared, release.tip),
    }, tip  # fmt: skip


def refined(release: Release, tip: Floats) -> float:
    """Return how far the tip moves with finer strains, over the length: our own part."""
    return apart(motion(release, ORDER + 2)[1], tip)


def motions(releases: list[Release]) -> tuple[dict[str, Any], list[Floats]]:
    """Compare all releases; return what is kept and our tips."""
    rows, tips = [], []
    for release in releases:
        row, tip = release_row(release)
        rows.append(row)
        tips.append(tip)
        print(f"  {release.name}: largest distance of the tip {row['tip_worst']:.1e}", flush=True)
    worst = np.array([row["tip_worst"] for row in rows])
    sheared = [row["tip_worst_with_shear"] for row in rows]
    summary = {
        "median": float(np.median(worst)), "worst": float(worst.max()),
        "worst_with_shear": max(sheared), "median_with_shear": float(np.median(sheared)),
        "ours": refined(releases[0], tips[0]),
    }  # fmt: skip
    return {"releases": len(rows), "rows": rows} | summary, tips
