"""Modes and frequencies of small motion about a state of rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.closing import free_directions
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.scene.numerics import Numerics

from .small_motion import Complex, real_modes, small_motions, unit_scale

LONG = 5.0  # times the recommended step: its slowest swings then have about 20 steps
LOOKED_AT = 300  # coordinates up to which modes are a matter of a moment


def modes(
    dynamics: Dynamics, q: Floats, efforts: Floats | None = None, time: float = 0.0
) -> tuple[Floats, Floats]:
    """Return angular frequencies (n,) in rad/s, ascending, and mode shapes (n, n).

    Shapes are columns with φᵀ M φ = 1.

    Parameters
    ----------
    dynamics : the arm
    q : (n,) where it is at rest
    efforts : (m,) of the actuators there
    time : s, for loads with a schedule

    Notes
    -----
    From the symmetric part of the exact tangent at q; an unstable direction has a negative
    "frequency". What constraints hold does not move. Damping and what is not symmetric (follower
    loads) count in ``complex_modes``.
    """
    free = dynamics.free
    matrices = dynamics.tangents(q, *dynamics.guided(time)[1:], efforts, time)
    stiffness, _, mass = (matrix[np.ix_(free, free)] for matrix in matrices)
    scale = unit_scale(stiffness, dynamics.law_at_rest[free], dynamics.model.weight[free])
    left = free_directions(dynamics, free, time, scale)
    if left is not None:
        stiffness, mass = left.T @ stiffness @ left, left.T @ mass @ left
        scale = np.ones(left.shape[1])
    omega, own = real_modes(stiffness, mass, scale)
    shapes = np.zeros((dynamics.n, len(omega)))
    shapes[free] = own if left is None else left @ own
    return omega, shapes


def frequencies(dynamics: Dynamics, q: Floats | None = None, count: int = 5) -> Floats:
    """Return the lowest ``count`` frequencies in Hz of ``dynamics`` at q (n,).

    Without q: at the reference shape.
    """
    state = np.zeros(dynamics.n) if q is None else q
    return modes(dynamics, state)[0][:count] / (2.0 * np.pi)


class ComplexModes(NamedTuple):
    """Small motions δq = Re(φ e^{st}) about a state of rest, slowest first.

    Of every conjugate pair only the one with Im s > 0 is listed; real s stand alone.
    """

    values: Complex  # (m,) s in 1/s
    shapes: Complex  # (n, m) φ; the coordinate that moves most may move the tip by an arm length

    @property
    def frequencies(self) -> Floats:
        """Frequencies (m,) in Hz of what swings; 0 for what only creeps or leaves."""
        return self.values.imag / (2.0 * np.pi)

    @property
    def damping_ratios(self) -> Floats:
        """−Re s / |s| (m,): 1 does not swing, negative grows; 0 for s = 0."""
        size = np.abs(self.values)
        return 0.0 - np.divide(self.values.real, size, out=np.zeros_like(size), where=size > 0.0)

    @property
    def growth(self) -> float:
        """Largest Re s in 1/s: above zero the state is left, by divergence or by flutter."""
        return float(self.values.real.max(initial=-np.inf))


def complex_modes(
    dynamics: Dynamics,
    q: Floats,
    efforts: Floats | None = None,
    time: float = 0.0,
    *,
    tip: Floats | None = None,
    tip_follows: bool = False,
) -> ComplexModes:
    """Return the modes of M δq̈ + R δq̇ + K δq = 0 with the exact tangents at rest in q.

    Parameters
    ----------
    dynamics : the arm
    q : (n,) coordinates, meant to be an equilibrium under the loads that follow
    efforts : (A,) in scene order
    time : s at which scheduled loads are taken
    tip : (6,) moment and force at the tip, along world axes or (``tip_follows``) those of the tip

    Notes
    -----
    K is that of all loads and efforts, so it need not be symmetric: follower loads may lead to
    flutter (a pair with Re s > 0), dead loads to divergence (a real s > 0). Where Re s > 0 is no
    more than round-off can make it, it is 0. Driven joints move as they are told at ``time``, so
    on a table that turns the modes are those of the arm that turns with it.
    """
    free, guided = dynamics.free, dynamics.guided(time)[1:]
    matrices = dynamics.tangents(q, *guided, efforts, time, tip, tip_follows)
    stiffness, damping, mass = (matrix[np.ix_(free, free)] for matrix in matrices)
    scale = unit_scale(stiffness, dynamics.law_at_rest[free], dynamics.model.weight[free])
    left = free_directions(dynamics, free, time, scale)
    if left is not None:
        stiffness, damping, mass = (left.T @ x @ left for x in (stiffness, damping, mass))
        scale = np.ones(left.shape[1])
    found = small_motions(stiffness, damping, mass, scale)
    kept = found.values.imag >= 0.0
    values = found.values[kept].copy()
    shapes = np.zeros((dynamics.n, len(values)), dtype=complex)
    shapes[free] = found.shapes[:, kept] if left is None else left @ found.shapes[:, kept]
    # growth that is round-off is none
    values.real[~found.growing[kept] & (values.real > 0.0)] = 0.0
    order = np.argsort(np.abs(values), kind="stable")
    shapes = shapes[:, order]
    reach = shapes * dynamics.model.weight[:, None]
    largest = reach[np.argmax(np.abs(reach), axis=0), np.arange(len(order))]
    return ComplexModes(values[order], shapes / largest)


def mode_poses(
    dynamics: Dynamics,
    q: Floats,
    shape: Floats | Complex,
    s: Floats,
    *,
    amplitude: float = 0.1,
    phases: Floats | tuple[float, ...] = (0.0,),
) -> Floats:
    """Return poses (P, N, 7) x y z qx qy qz qw of the arm moved along a mode.

    Parameters
    ----------
    q : (n,) the state of rest
    shape : (n,) a mode shape, real or complex
    s : (N,) arc lengths in m along all rods, base to tip
    amplitude : factor of the shape; with shapes of ``complex_modes`` about the displacement of
        the tip in arm lengths
    phases : (P,) in rad; the arm is at q + amplitude · Re(shape · e^{i phase})
    """
    moved, q = np.zeros(dynamics.n), dynamics.coordinates(q)
    sampler = Sampler(dynamics.compiled, moved, s)
    out = np.empty((len(phases), len(sampler.s), 7))
    for i, phase in enumerate(phases):
        moved[:] = q + amplitude * np.real(np.asarray(shape) * np.exp(1j * phase))
        out[i] = sampler.poses()
    return out


def recommended_step(dynamics: Dynamics, q: Floats) -> float:
    """Return a step in s that resolves the slowest motions.

    It is 1/100 of the period of the third lowest mode. Stiffer motion is stable at any step and
    damped out; only its detail is lost. Rounded down to 1, 2 or 5 · 10^k.
    """
    omega = np.abs(modes(dynamics, q)[0])
    omega = omega[omega > 1e-6][:3]
    if len(omega) == 0:
        return 0.01
    step = min(2.0 * np.pi / omega[-1] / 100.0, 0.02)
    power = 10.0 ** np.floor(np.log10(step))
    return float(max(m for m in (1.0, 2.0, 5.0) if m * power <= step * (1 + 1e-12)) * power)


def long_step(dynamics: Dynamics, q: Floats, numerics: Numerics) -> str | None:
    """Say in words that the step is much longer than recommended about q (n,); None if it is not.

    Not looked at are many coordinates, and a method that chooses its own steps.
    """
    if numerics.integrator == "adaptive" or not 0 < dynamics.n <= LOOKED_AT:
        return None
    best = recommended_step(dynamics, q)
    if numerics.step <= LONG * best:
        return None
    return (
        f"numerics.step = {numerics.step:g} s is {numerics.step / best:.2g} times the recommended "
        f"{best:g} s: the arm's slow swings are shown coarsely, or damped out"
    )
