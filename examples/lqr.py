"""A linear-quadratic regulator from ``linearise`` damps the arm after a push.

The arm is linearised about a bent equilibrium and sampled at the period of the loop. The gain of
the regulator comes from the discrete Riccati equation; the loop then runs on the nonlinear arm.

Run it with ``python examples/lqr.py`` or add ``--plot lqr.png``.
"""

import argparse

import numpy as np
from scipy.linalg import solve_discrete_are

from soft_sim_ros import Dynamics, Simulation, equilibrium, linearise, load_scene

EFFORTS = np.array([1.0, 0.0, 0.3, 0.0, 0.1, 0.0])  # N·m, held at rest
PUSH = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0]  # N·m and N at the tip, let go at t = 0
STEP, DURATION = 0.01, 3.0  # s
OUTPUTS = ("tip_x", "tip_y", "tip_z")


def regulator() -> tuple[np.ndarray, np.ndarray]:
    """Return the equilibrium (n,) and the gain (A, 2n): u = u* − K x, x = (q − q*; q̇)."""
    dynamics = Dynamics(load_scene("soft_arm"))
    q = equilibrium(dynamics, efforts=EFFORTS)
    names = tuple(actuator.name for actuator in dynamics.compiled.scene.actuators)
    plant = linearise(dynamics, q, EFFORTS).select(names, OUTPUTS).discrete(STEP)
    A, B, C = plant.A, plant.B, plant.C
    state_cost = 1e4 * C.T @ C + 1e-9 * np.eye(len(A))
    effort_cost = np.eye(len(names))
    riccati = solve_discrete_are(A, B, state_cost, effort_cost)
    return q, np.linalg.solve(effort_cost + B.T @ riccati @ B, B.T @ riccati @ A)


def run(regulated: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return times (T,) in s and displacements (T, 3) of the tip from rest in m."""
    q, gain = regulator()
    scene = load_scene("soft_arm")
    limits = np.array([actuator.limits for actuator in scene.actuators]).T
    arm = Simulation(scene)
    tip = arm.sampler(2)
    arm.set_state(q, np.zeros_like(q))
    rest = tip.poses()[-1, :3].copy()
    pushed = equilibrium(arm.dynamics, q, efforts=EFFORTS, tip=np.array(PUSH))
    arm.set_state(pushed, np.zeros_like(q))
    times, moved = [], []
    while arm.time < DURATION:
        x = np.concatenate([arm.q - q, arm.v])
        arm.set_efforts(np.clip(EFFORTS - (gain @ x if regulated else 0.0), *limits))
        arm.advance(round(STEP / (arm.step_ns * 1e-9)))
        times.append(arm.time)
        moved.append(tip.poses()[-1, :3] - rest)
    return np.array(times), np.array(moved)


def main() -> None:
    """Compare the arm with and without the regulator."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", metavar="FILE.png")
    options = parser.parse_args()
    results = {"held efforts": run(False), "LQR": run(True)}
    for name, (_, moved) in results.items():
        strayed = np.sqrt(STEP * np.sum(moved**2))
        print(f"{name}: strays by {1e3 * strayed:.2f} mm √s")
    if options.plot:
        import matplotlib.pyplot as plt

        _, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
        for name, (times, moved) in results.items():
            axes.plot(times, 1e3 * np.linalg.norm(moved, axis=1), label=name)
        axes.set(xlabel="time, s", ylabel="tip from rest, mm", title="Let go after a push of 1.4 N")
        axes.legend()
        plt.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
