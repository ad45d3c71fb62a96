"""Tip tracking: inverse kinematics along a circle, and a PD loop on the bending angles.

Inverse kinematics gives efforts and bending angles for every point of the circle, each solved from
the one before. The arm moves, so the efforts of rest alone lag behind; a PD loop on the angles
takes most of the lag away.

Run it with ``python examples/track_tip.py`` or add ``--plot track_tip.png``.
"""

import argparse
from functools import cache

import numpy as np
from scipy.interpolate import CubicSpline

from soft_sim_ros import Dynamics, Simulation, inverse_kinematics, load_scene

RADIUS, HEIGHT, PERIOD = 0.15, 0.45, 4.0  # m, m, s
POINTS = 16  # of the circle, with splines between them
STEP = 0.002  # s
KP, KD = 2.0, 0.1  # N·m/rad, N·m·s/rad


def circle(angle: float) -> list[float]:
    """Return a point (3,) of the circle in m."""
    return [RADIUS * np.cos(angle), RADIUS * np.sin(angle), HEIGHT]


@cache
def plan() -> tuple[CubicSpline, CubicSpline]:
    """Return periodic splines in time: of efforts (A,) and of bending angles (A,)."""
    model = Dynamics(load_scene("soft_arm"))
    efforts, angles, start = [], [], None
    for angle in np.linspace(0.0, 2.0 * np.pi, POINTS, endpoint=False):
        found = inverse_kinematics(model, circle(angle), start=start)
        start = found.efforts
        efforts.append(found.efforts)
        angles.append(model.ports(found.q, np.zeros(model.n))[0])
    times = np.linspace(0.0, PERIOD, POINTS + 1)
    return (
        CubicSpline(times, [*efforts, efforts[0]], bc_type="periodic"),
        CubicSpline(times, [*angles, angles[0]], bc_type="periodic"),
    )


def run(feedback: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the path (T, 3) of the tip over the second turn in m, and the wanted one."""
    efforts, angles = plan()
    scene = load_scene("soft_arm")
    limits = np.array([actuator.limits for actuator in scene.actuators]).T
    arm = Simulation(scene)
    tip = arm.sampler(2)
    path, wanted = [], []
    while arm.time < 2.0 * PERIOD:
        now = arm.time
        position, rate, _ = arm.ports()
        command = efforts(now)
        if feedback:
            command = command + KP * (angles(now) - position) + KD * (angles(now, 1) - rate)
        arm.set_efforts(np.clip(command, *limits))
        arm.advance(round(STEP / (arm.step_ns * 1e-9)))
        if arm.time > PERIOD:
            path.append(tip.poses()[-1, :3].copy())
            wanted.append(circle(2.0 * np.pi * arm.time / PERIOD))
    return np.array(path), np.array(wanted)


def main() -> None:
    """Compare both controllers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", metavar="FILE.png")
    options = parser.parse_args()
    results = {"efforts of rest": run(False), "with PD": run(True)}
    for name, (path, wanted) in results.items():
        error = np.sqrt(np.mean(np.sum((path - wanted) ** 2, axis=1)))
        print(f"{name}: root mean square error {1e3 * error:.1f} mm")
    if options.plot:
        import matplotlib.pyplot as plt

        _, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
        for name, (path, wanted) in results.items():
            errors = np.linalg.norm(path - wanted, axis=1)
            axes.plot(PERIOD + STEP * np.arange(len(errors)), 1e3 * errors, label=name)
        axes.set(xlabel="time, s", ylabel="tip to its place on the circle, mm", ylim=(0.0, None))
        axes.legend()
        plt.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
