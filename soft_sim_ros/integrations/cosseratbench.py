"""A solver of cosseratbench: rods of its scenarios as scenes, without contact.

cosseratbench finds it by the entry point ``soft_sim_ros`` of its group ``cosseratbench.solvers``::

    cosseratbench run cantilever --solver soft_sim_ros

Rods are held at their start, clamped or pinned, and free at their end, or pinned at both, or their
end is clamped and driven. A start that is free or driven is not covered, and neither is contact;
the benchmark then says "unsupported". Quasi-static scenarios are solved as statics: their frames
after the first show the equilibrium. Those with a driven end are computed in time, with critical
damping of the slowest bending mode by mass, which the benchmark permits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from cosseratbench.scenario import EndCondition, Rod, Scenario
from cosseratbench.solver import Capability, Diverged
from cosseratbench.trajectory import Trajectory

from soft_sim_ros.version import __version__

from .cosseratbench_scene import ORDER, elements, mass_damping, scene_of

if TYPE_CHECKING:
    from soft_sim_ros.core.floats import Floats
    from soft_sim_ros.core.mechanics.dynamics import Dynamics


ERROR = 1e-8  # of a step, displacement of the tip over the length
HELD_ERROR = 1e-6  # likewise where a constraint holds the far end
BENDING = ("bend_y", "bend_z", "pin")  # coordinates that show in the shape of a centre line


class SoftSimRos:
    """The solver; ``time_step_scale`` multiplies the error that a step may make."""

    name = "soft_sim_ros"
    backend_version = __version__
    capabilities = frozenset({Capability.STRETCH, Capability.SHEAR})

    def __init__(self, time_step_scale: float = 1.0) -> None:
        self.error = ERROR * time_step_scale

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """Return the numerical choices of a run."""
        said: dict[str, Any] = {"elements": elements(n_elements), "order": ORDER}
        if any(rod.end is EndCondition.CLAMPED for rod in scenario.rods):
            damping = [mass_damping(scenario, rod) for rod in scenario.rods]
            said |= {"error_per_step": self._held_error, "mass_damping": max(damping)}
            return said | {"integrator": "adaptive", "far end": "constraint on a driven frame"}
        if scenario.quasi_static:
            return said | {"method": "statics by Newton's method"}
        return said | {"integrator": "adaptive", "error_per_step": self.error}

    @property
    def _held_error(self) -> float:
        return HELD_ERROR / ERROR * self.error

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """Return where the rods are, at ``n_frames`` times from zero to the end."""
        if scenario.obstacles:
            raise NotImplementedError("contact with obstacles")
        times = np.linspace(0.0, scenario.duration, n_frames)
        found = [self._rod(scenario, rod, n_elements, times) for rod in scenario.rods]
        positions, directors = zip(*found, strict=True)
        return Trajectory(times, positions, directors)

    def _rod(
        self, scenario: Scenario, rod: Rod, n_elements: int, times: Floats
    ) -> tuple[Floats, Floats]:
        """Return positions (T, n + 1, 3) and directors (T, n, 3) of one rod."""
        if rod.start is EndCondition.FREE or rod.start_motion is not None:
            raise NotImplementedError("a rod whose start is free or driven")
        if rod.end is EndCondition.PINNED and not scenario.quasi_static:
            raise NotImplementedError("motion of a rod that is pinned at both ends")
        from soft_sim_ros.core.settled import Dynamics, Simulation

        from ..errors import SolverError

        held = rod.end is EndCondition.CLAMPED
        interval = float(times[1] - times[0])
        error = self._held_error if held else self.error
        scene = scene_of(scenario, rod, n_elements, interval, error)
        if held or not scenario.quasi_static:
            simulation = Simulation(scene)
            q = laid_along(simulation.dynamics, rod)
            simulation.set_state(q, np.zeros(len(q)))
            look, shots = Frames(simulation.dynamics, n_elements), []
            for frame in range(len(times)):
                try:
                    simulation.advance(min(frame, 1))
                except SolverError as reason:
                    raise Diverged(str(reason), simulation.time) from reason
                shots.append(look(simulation.q))
            return stacked(shots)
        dynamics = Dynamics(scene)
        first = rod.nodes(n_elements), rod.directors(n_elements)
        last = Frames(dynamics, n_elements)(at_rest(dynamics, rod))
        return stacked([first] + [last] * (len(times) - 1))


class Frames:
    """Nodes (n + 1, 3) of a rod, and material directions (n, 3) of the pieces between them."""

    def __init__(self, dynamics: Dynamics, n: int) -> None:
        from soft_sim_ros.core.mechanics.sampler import Sampler

        self._q = np.zeros(dynamics.n)
        s = np.linspace(0.0, dynamics.compiled.length, 2 * n + 1)
        self._sampler = Sampler(dynamics.compiled, self._q, s)

    def __call__(self, q: Floats) -> tuple[Floats, Floats]:
        """Return nodes and directions at coordinates (n,)."""
        from scipy.spatial.transform import Rotation

        self._q[:] = q
        poses = self._sampler.poses()
        nodes = poses[::2, :3].copy()
        turned = Rotation.from_quat(poses[1::2, 3:]).as_matrix()[:, :, 1]
        along = np.diff(nodes, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        upright = turned - np.sum(turned * along, axis=1)[:, None] * along
        return nodes, upright / np.linalg.norm(upright, axis=1)[:, None]


def stacked(shots: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Return positions (T, n + 1, 3) and directors (T, n, 3)."""
    nodes, directors = zip(*shots, strict=True)
    return np.array(nodes), np.array(directors)


def laid_along(dynamics: Dynamics, rod: Rod) -> Floats:
    """Return q (n,) that lays the rod along its centre line, untwisted and without shear.

    By least squares (Levenberg–Marquardt) over the positions of material points.
    """
    from scipy.optimize import least_squares

    points = min(max(50, len(rod.centerline) - 1), 200)
    wanted = rod.nodes(points)
    look = Frames(dynamics, points)
    names, q = dynamics.compiled.coordinate_names, np.zeros(dynamics.n)

    def gap(values: Floats) -> Floats:
        q[free] = values
        out: Floats = (look(q)[0] - wanted).ravel()
        return out

    for parts in (BENDING, (*BENDING, "stretch")):  # all at once would squeeze it together first
        free = [k for k, name in enumerate(names) if any(part in name for part in parts)]
        q[free] = least_squares(gap, q[free], method="lm", xtol=1e-12, ftol=1e-12).x
    return q


def at_rest(dynamics: Dynamics, rod: Rod) -> Floats:
    """Return the equilibrium q (n,), with the end at its pin if it has one."""
    from soft_sim_ros.core.analysis.statics import equilibrium

    from ..errors import StaticsFailed

    if rod.end is EndCondition.FREE and rod.start is EndCondition.CLAMPED:
        try:
            return equilibrium(dynamics)
        except StaticsFailed as reason:
            raise Diverged(str(reason)) from reason
    return pinned(dynamics, laid_along(dynamics, rod), rod)


def pinned(dynamics: Dynamics, q: Floats, rod: Rod, steps: int = 20) -> Floats:
    """Return the equilibrium q (n,) that has its end where it is, if the end is pinned.

    Newton's method on coordinates and the force of the pin, while what is out of balance at the
    start goes to zero in ``steps``.
    """
    held = 3 if rod.end is EndCondition.PINNED else 0
    goal, n = np.asarray(rod.centerline[-1], dtype=float), dynamics.n
    force, zero = np.zeros(held), np.zeros(n)
    out_of_balance = None
    for left in np.linspace(1.0, 0.0, steps + 1)[1:]:
        for _ in range(40):
            tip = np.concatenate([np.zeros(3), force]) if held else np.zeros(6)
            pose = dynamics.node_poses(q)[-1]
            jacobian = (pose[:3, :3] @ dynamics.tip_jacobian(q)[3:])[:held]
            residual = dynamics.residual(q, zero, zero, dynamics.forcing(tip=tip))
            tangent = dynamics.last_tangent((1.0, 0.0, 0.0))
            if out_of_balance is None:
                force = np.linalg.lstsq(jacobian.T, residual, rcond=None)[0] if held else force
                out_of_balance = residual - jacobian.T @ force
                continue
            system = np.block([[tangent, -jacobian.T], [jacobian, np.zeros((held, held))]])
            gap = (goal - pose[:3, 3])[:held]
            step = np.linalg.solve(system, np.append(left * out_of_balance - residual, gap))
            if not np.isfinite(step).all():
                raise Diverged("statics: the system is singular")
            q, force = q + step[:n], force + step[n:]
            if np.abs(step[:n] * dynamics.model.weight).max() < 1e-11:
                break
        else:
            raise Diverged("statics: Newton's method does not converge")
    return q
