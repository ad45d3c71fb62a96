"""Small motion about a state of rest as a linear system: ẋ = A x + B u, y = C x + D u.

With K, R, M the exact tangents of the residual r(q, q̇, q̈), and x = (δq; δq̇),

    A = [0, 1; −M⁻¹K, −M⁻¹R],    B = [0; −M⁻¹ ∂r/∂u].
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve, expm

from soft_sim_ros.core.arguments import vector_or_zeros
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.closing import free_directions
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.history import refuse_driven

WRENCH = ("moment_x", "moment_y", "moment_z", "force_x", "force_y", "force_z")
POSE = ("x", "y", "z", "turn_x", "turn_y", "turn_z")


@dataclass(frozen=True, eq=False)
class Linearisation:
    """A linear time-invariant system, in the order and with the names scipy.signal uses.

    Parameters
    ----------
    A, B, C, D : (2n, 2n), (2n, A + 6), (6 + 2A, 2n), (6 + 2A, A + 6)
    drift : (2n,) what moves the state at x = 0, u = 0: zero in an equilibrium. ẋ in continuous
        time, the change per step in discrete time
    q, efforts, output : state of rest (n₀,), efforts (A,) in it, and outputs (6 + 2A,) there:
        x, u and y count from these
    ways : (n₀, n) the motion of the coordinates per state, one by one but for scenes with
        constraints: there states are the directions that these leave free, and n fewer than q
    states, inputs, outputs : names. Inputs are commands in scene order, in their own units, then
        the wrench at the tip (N·m, N). Outputs are the position of the tip, or of another frame
        (m, world), its small rotation as a vector along world axes (rad), then position and rate of
        every actuator port
    step : s between instants; 0 = continuous time
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    drift: Floats
    q: Floats
    efforts: Floats
    output: Floats
    ways: Floats
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    step: float = 0.0

    @property
    def matrices(self) -> tuple[Floats, Floats, Floats, Floats]:
        """A, B, C, D, as ``scipy.signal.StateSpace`` and ``control.ss`` take them."""
        return self.A, self.B, self.C, self.D

    def discrete(self, step: float) -> Linearisation:
        """Return the system at instants ``step`` s apart, with inputs held between: exact.

        Raises
        ------
        ValueError
            if this one is in discrete time already, or the step is not a finite number above 0.
        """
        if self.step:
            raise ValueError(f"this system has a step of {self.step:g} s already")
        if not 0.0 < step < np.inf:
            raise ValueError(f"step = {step!r} s: expected a finite number above zero")
        n, m = self.B.shape
        whole = np.zeros((n + m + 1, n + m + 1))
        whole[:n, :n], whole[:n, n : n + m], whole[:n, -1] = self.A, self.B, self.drift
        flow = expm(whole * step)[:n]
        return replace(self, A=flow[:, :n], B=flow[:, n : n + m], drift=flow[:, -1], step=step)

    def select(self, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> Linearisation:
        """Return the same system with some of its inputs and outputs, by name.

        Raises
        ------
        ValueError
            if it has no input or output of that name.
        """
        columns = _indices("input", inputs, self.inputs)
        rows = _indices("output", outputs, self.outputs)
        return replace(
            self,
            B=self.B[:, columns],
            C=self.C[rows],
            D=self.D[np.ix_(rows, columns)],
            output=self.output[rows],
            inputs=tuple(inputs),
            outputs=tuple(outputs),
        )

    def static_gain(self) -> Floats:
        """Return y per constant u (outputs, inputs) once all has settled."""
        n = len(self.A)
        held = np.eye(n) - self.A if self.step else -self.A
        return self.C @ np.linalg.solve(held, self.B) + self.D


def _indices(what: str, names: tuple[str, ...], known: tuple[str, ...]) -> list[int]:
    for name in names:
        if name not in known:
            raise ValueError(f"unknown {what} {name!r}: expected one of {', '.join(known)}")
    return [known.index(name) for name in names]


def _ways(dynamics: Dynamics, q: Floats, time: float) -> Floats:
    """Return the directions (n₀, n) that constraints leave free, all of them without any."""
    if not len(dynamics.constraints):
        return np.eye(dynamics.n)
    zero, all_of_them = np.zeros(dynamics.n), np.ones(dynamics.n, dtype=bool)
    dynamics.residual(q, zero, zero, dynamics.forcing(time=time))
    ways = free_directions(dynamics, all_of_them, time, dynamics.model.weight)
    return np.eye(dynamics.n) if ways is None else ways


def linearise(
    dynamics: Dynamics,
    q: Floats,
    efforts: Floats | None = None,
    time: float = 0.0,
    *,
    tip: Floats | None = None,
    tip_follows: bool = False,
    frame: str | None = None,
) -> Linearisation:
    """Return the linear system of small motion about rest in q, exact for the discrete model.

    Parameters
    ----------
    dynamics : the arm
    q : (n,) coordinates; ``statics.equilibrium`` gives them
    efforts : (A,) held there, in scene order
    time : s at which scheduled loads are taken, and then held
    tip : (6,) wrench held at the tip, along world axes or (``tip_follows``) those of the tip; the
        same frame is that of the wrench among the inputs
    frame : name of a body, whose end is looked at; the tip, the last of all ends, by default. Its
        name takes the place of ``tip`` in those of the outputs
    """
    n, actuators = dynamics.n, dynamics.actuators
    q = dynamics.coordinates(q).copy()
    held = vector_or_zeros("efforts", efforts, actuators).copy()
    zero = np.zeros(n)
    forcing = (held, time, 1.0, tip, tip_follows)
    refuse_driven(dynamics.compiled.scene, "a linear system")
    ways = _ways(dynamics, q, time)
    mass = ways.T @ dynamics.mass_matrix(q) @ ways
    factors = cho_factor(0.5 * (mass + mass.T))
    still = dynamics.residual(q, zero, zero, dynamics.forcing(*forcing))
    start = cho_solve(factors, -(ways.T @ still))
    stiffness, damping, _ = (
        ways.T @ x @ ways
        for x in dynamics.tangents(q, zero, ways @ start, held, time, tip, tip_follows)
    )
    jacobians, poses = dynamics.jacobians(q, zero)[0], dynamics.node_poses(q)
    node = dynamics.compiled.node_of(frame)
    jacobian, rotation = jacobians[-1], poses[-1, :3, :3]
    to_world = block_diag(rotation, rotation)
    wrench = jacobian.T if tip_follows else jacobian.T @ to_world.T
    force = ways.T @ np.hstack([dynamics.effort_matrix(q, held), wrench])
    n = ways.shape[1]
    upper = np.hstack([np.zeros((n, n)), np.eye(n), np.zeros((n, force.shape[1]))])
    lower = cho_solve(factors, np.hstack([-stiffness, -damping, force]))
    flow = np.vstack([upper, lower])
    # a port's rate is linear in q̇: ẏ = (∂y/∂q) q̇
    ports = np.stack([dynamics.ports(q, way)[1] for way in ways.T], axis=1)
    seen = poses[node, :3, :3]
    turned = block_diag(seen, seen) @ jacobians[node] @ ways
    positions = np.vstack([turned[3:], turned[:3], ports])
    output = np.concatenate([poses[node, :3, 3], np.zeros(3), dynamics.ports(q, zero)[0]])
    names = [actuator.name for actuator in dynamics.compiled.scene.actuators]
    coordinates = dynamics.compiled.coordinate_names
    if n < dynamics.n:
        coordinates = tuple(f"way_{i}" for i in range(n))
    return Linearisation(
        A=flow[:, : 2 * n],
        B=flow[:, 2 * n :],
        C=np.vstack(
            [
                np.hstack([positions, np.zeros_like(positions)]),
                np.hstack([np.zeros_like(ports), ports]),
            ]
        ),
        D=np.zeros((6 + 2 * actuators, actuators + 6)),
        drift=np.concatenate([np.zeros(n), start]),
        q=q,
        ways=ways,
        efforts=held,
        output=np.concatenate([output, np.zeros(actuators)]),
        states=(*coordinates, *(f"{name}_rate" for name in coordinates)),
        inputs=(*names, *(f"tip_{name}" for name in WRENCH)),
        outputs=(
            *(f"{frame or 'tip'}_{name}" for name in POSE),
            *names,
            *(f"{name}_rate" for name in names),
        ),
    )
