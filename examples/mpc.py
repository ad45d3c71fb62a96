"""A small model predictive controller: reach a point fast, with bounded torques.

The model is the arm linearised about rest and sampled. At every period the controller chooses the
torques of the next N periods that minimise

    Σ |y − y*|²/σ² + Σ |Δu|²/ρ²,   u within its limits,

by bounded least squares, applies the first of them and repeats. The limits are 0.3 times those
of the actuators, so that they matter.

Run it with ``python examples/mpc.py`` or add ``--plot mpc.png``.
"""

import argparse

import numpy as np
from scipy.optimize import lsq_linear

from soft_sim_ros import Dynamics, Simulation, equilibrium, linearise, load_scene

GOAL = np.array([0.12, 0.0, 0.0])  # m, of the tip, from rest; held as far as the model is right
INPUTS = ("proximal_bend_y", "proximal_bend_z", "middle_bend_y", "middle_bend_z")
OUTPUTS = ("tip_x", "tip_y")
STEP, HORIZON, DURATION = 0.05, 16, 2.5  # s, periods, s
SIGMA, RHO = 0.01, 0.5  # m, N·m
BOUND = 0.3  # of the actuators' limits


class Controller:
    """Model predictive control of a discrete linear system with bounded inputs.

    Parameters
    ----------
    A, B, C : matrices of x⁺ = A x + B u, y = C x
    bound : (m,) largest size of every input
    """

    def __init__(self, A: np.ndarray, B: np.ndarray, C: np.ndarray, bound: np.ndarray) -> None:
        m, p = B.shape[1], C.shape[0]
        self.free = []  # y_k = free_k x + Σ forced_kj u_j
        self.forced = np.zeros((HORIZON, p, HORIZON, m))
        response, power = [], np.eye(len(A))
        for k in range(HORIZON):
            response.append(C @ power @ B)
            power = A @ power
            self.free.append(C @ power)
            for j in range(k + 1):
                self.forced[k, :, j] = response[k - j]
        self.change = np.eye(HORIZON * m) - np.eye(HORIZON * m, k=-m)  # u_j − u_{j−1}
        self.bound, self.last = np.tile(bound, HORIZON), np.zeros(m)

    def __call__(self, x: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Return the inputs (m,) of this period for a state x and wanted outputs (p,)."""
        m = len(self.last)
        missing = np.concatenate([goal - free @ x for free in self.free])
        first = np.zeros(HORIZON * m)
        first[:m] = self.last
        matrix = np.vstack([
            self.forced.reshape(len(missing), -1) / SIGMA, self.change / RHO
        ])  # fmt: skip
        right = np.concatenate([missing / SIGMA, first / RHO])
        self.last = lsq_linear(matrix, right, (-self.bound, self.bound)).x[:m]
        return self.last


def run(predictive: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (T,), the tip (T, 2) from rest in m and torques (T, m) in N·m."""
    scene = load_scene("soft_arm")
    dynamics = Dynamics(scene)
    q = equilibrium(dynamics)
    plant = linearise(dynamics, q).select(INPUTS, OUTPUTS).discrete(STEP)
    chosen = [[a.name for a in scene.actuators].index(name) for name in INPUTS]
    bound = BOUND * np.array([scene.actuators[i].limits[1] for i in chosen])
    control = Controller(plant.A, plant.B, plant.C, bound)
    held = np.linalg.pinv(plant.static_gain()) @ GOAL[:2]  # what holds the goal at rest
    arm = Simulation(scene)
    tip = arm.sampler(2)
    rest = tip.poses()[-1, :3].copy()
    times, moved, torques = [0.0], [np.zeros(2)], []
    while arm.time < DURATION:
        x = np.concatenate([arm.q - q, arm.v])
        u = control(x, GOAL[:2]) if predictive else np.clip(held, -bound, bound)
        efforts = np.zeros(len(scene.actuators))
        efforts[chosen] = u
        arm.set_efforts(efforts)
        arm.advance(round(STEP / (arm.step_ns * 1e-9)))
        times.append(arm.time)
        moved.append(tip.poses()[-1, :2] - rest[:2])
        torques.append(u)
    return np.array(times), np.array(moved), np.array(torques)


def main() -> None:
    """Compare the controller with torques that hold the goal at rest."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", metavar="FILE.png")
    options = parser.parse_args()
    results = {"constant torques": run(False), "MPC": run(True)}
    for name, (times, moved, _) in results.items():
        away = np.linalg.norm(moved - GOAL[:2], axis=1)
        late = times[np.flatnonzero(away > 0.1 * np.linalg.norm(GOAL))[-1]]
        print(f"{name}: within a tenth of the way after {late:.2f} s")
    if options.plot:
        import matplotlib.pyplot as plt

        _, (above, below) = plt.subplots(
            2, 1, figsize=(6.4, 4.4), sharex=True, layout="constrained"
        )
        for name, (times, moved, torques) in results.items():
            above.plot(times, 1e3 * moved[:, 0], label=name)
            below.step(times[:-1], torques[:, 0], where="post", label=name)
        above.axhline(1e3 * GOAL[0], color="black", linestyle="--", label="goal")
        above.set(ylabel="tip along x, mm")
        below.set(xlabel="time, s", ylabel="torque of the first section, N·m")
        above.legend()
        plt.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
