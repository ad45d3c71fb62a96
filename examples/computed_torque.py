"""Computed torque: follow a fast motion with the inverse dynamics of a simpler model.

The plant is the default arm with 30 coordinates. The controller's model has constant curvature in
each section, so six coordinates q for six torques. Its inverse dynamics along the wanted motion
gives the torques; a PD loop on the bending angles y = Gᵀ q takes care of what the model lacks:

    u = G⁻¹ ID(q*, q̇*, q̈*) + Kp (y* − y) + Kd (ẏ* − ẏ),

where ID is ``Dynamics.inverse_dynamics`` and G the matrix of generalised forces per torque. The
model is evaluated on the wanted motion, not on the measured one: the coordinates that the model
lacks would otherwise be driven unstable by high gains.

Run it with ``python examples/computed_torque.py`` or add ``--plot computed_torque.png``.
"""

import argparse
from dataclasses import replace

import numpy as np

from soft_sim_ros import Dynamics, Simulation, load_scene, parse_scene

STEP, DURATION = 0.002, 3.0  # s; the loop runs at 500 Hz
SPEED = 2.0 * np.pi / 1.5  # rad/s
AMPLITUDE = np.array([0.5, 0.3, 0.3, 0.2, 0.2, 0.1])  # rad, bending angles of the sections
KP, KD = 2.0, 0.1  # N·m/rad, N·m·s/rad
NUMERICS = """numerics:
  step: 0.002
  basis: {order: 0, nodes: 5}
"""


def simple_model() -> Dynamics:
    """Return the default arm with constant curvature in each section."""
    text = load_scene("soft_arm").source
    text = text[: text.index("numerics:")] + NUMERICS
    text = text.replace("[torsion, bend_y, bend_z, stretch]", "[bend_y, bend_z]")
    return Dynamics(parse_scene(text, "simple_arm"))


def reference(time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return bending angles (6,), rates and accelerations that begin at rest."""
    begin = min(time / 0.75, 1.0)  # fades in
    fade, rate = begin**3 * (10 - 15 * begin + 6 * begin**2), 30 * begin**2 * (1 - begin) ** 2
    bend = 60 * begin * (1 - begin) * (1 - 2 * begin)
    rate, bend = rate / 0.75, bend / 0.75**2
    sine, cosine = np.sin(SPEED * time), np.cos(SPEED * time)
    return (
        AMPLITUDE * fade * sine,
        AMPLITUDE * (rate * sine + fade * SPEED * cosine),
        AMPLITUDE * (bend * sine + 2 * rate * SPEED * cosine - fade * SPEED**2 * sine),
    )


def run(feedforward: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (T,), bending angles (T, 6) and their references in rad."""
    scene = load_scene("soft_arm")
    arm = Simulation(replace(scene, initial=replace(scene.initial, state="reference")))
    model = simple_model()
    forces = model.effort_matrix(np.zeros(model.n))  # G (6, 6)
    limits = np.array([actuator.limits for actuator in scene.actuators]).T
    times, found, wanted = [], [], []
    while arm.time < DURATION:
        position, rate, _ = arm.ports()
        goal = reference(arm.time)
        efforts = KP * (goal[0] - position) + KD * (goal[1] - rate)
        if feedforward:
            q, v, a = (np.linalg.solve(forces.T, part) for part in goal)
            efforts += np.linalg.solve(forces, model.inverse_dynamics(q, v, a))
        arm.set_efforts(np.clip(efforts, *limits))
        arm.advance(round(STEP / (arm.step_ns * 1e-9)))
        times.append(arm.time)
        found.append(arm.ports()[0])
        wanted.append(reference(arm.time)[0])
    return np.array(times), np.array(found), np.array(wanted)


def main() -> None:
    """Compare both controllers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", metavar="FILE.png")
    options = parser.parse_args()
    results = {"PD": run(False), "computed torque": run(True)}
    for name, (_, found, wanted) in results.items():
        error = np.sqrt(np.mean((found - wanted) ** 2))
        print(f"{name}: root mean square error {np.degrees(error):.2f}°")
    if options.plot:
        import matplotlib.pyplot as plt

        _, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
        times, _, wanted = results["PD"]
        axes.plot(times, np.degrees(wanted[:, 0]), "k--", label="reference")
        for name, (times, found, _) in results.items():
            axes.plot(times, np.degrees(found[:, 0]), label=name)
        axes.set(xlabel="time, s", ylabel="bending of the first section, °")
        axes.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        plt.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
