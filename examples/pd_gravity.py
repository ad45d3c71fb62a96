"""PD control with gravity compensation: hold a pose although a payload hangs at the tip.

Inverse kinematics gives the efforts u* that hold the goal against weight and elasticity. A PD loop
on the bending angles of the sections, which are what a motor encoder or a bend sensor sees, adds
stiffness and damping:

    u = u* + Kp (y* − y) − Kd ẏ.

Run it with ``python examples/pd_gravity.py`` or add ``--plot pd_gravity.png``.
"""

import argparse

import numpy as np

from soft_sim_ros import Dynamics, Simulation, inverse_kinematics, load_scene

GOAL = [0.15, 0.10, 0.45]  # m
PAYLOAD = 0.5  # N, unknown to the controller
STEP, DURATION = 0.002, 4.0  # s; the loop runs at 500 Hz
KP, KD = 2.0, 0.1  # N·m/rad, N·m·s/rad


def run(feedback: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return times (T,) in s and distances (T,) of the tip from the goal in m."""
    scene = load_scene("soft_arm")
    model = Dynamics(scene)
    goal = inverse_kinematics(model, GOAL)
    wanted, _ = model.ports(goal.q, np.zeros(model.n))
    limits = np.array([actuator.limits for actuator in scene.actuators]).T

    arm = Simulation(scene)
    arm.set_tip_wrench([0.0, 0.0, 0.0, 0.0, 0.0, -PAYLOAD])
    tip = arm.sampler(2)
    times, errors = [], []
    while arm.time < DURATION:
        position, rate, _ = arm.ports()
        efforts = goal.efforts.copy()
        if feedback:
            efforts += KP * (wanted - position) - KD * rate
        arm.set_efforts(np.clip(efforts, *limits))
        arm.advance(round(STEP / (arm.step_ns * 1e-9)))
        times.append(arm.time)
        errors.append(np.linalg.norm(tip.poses()[-1, :3] - GOAL))
    return np.array(times), np.array(errors)


def main() -> None:
    """Compare both controllers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", metavar="FILE.png")
    options = parser.parse_args()
    results = {"efforts u* alone": run(False), "u* and PD": run(True)}
    for name, (_, errors) in results.items():
        print(f"{name}: {1e3 * errors[-1]:.1f} mm from the goal at the end")
    if options.plot:
        import matplotlib.pyplot as plt

        _, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
        for name, (times, errors) in results.items():
            axes.semilogy(times, 1e3 * errors, label=name)
        axes.set(xlabel="time, s", ylabel="tip to goal, mm", title="A payload of 0.5 N at the tip")
        axes.legend()
        plt.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
