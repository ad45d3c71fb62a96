"""Whether the arm stays in an equilibrium: by its stiffness if loads are dead, else by its motion.

With a symmetric stiffness K the equilibrium is stable if K is positive definite, whatever mass and
damping are. Without symmetry (dead moments, follower loads) it is stable if no small motion
M δq̈ + R δq̇ + K δq = 0 grows, with the damping that the scene has: the growth of ``complex_modes``.

Without any damping in the scene, a growing oscillation is called *undamped*: the damping of the
real arm would decide, and it is not known. That leads to a warning, not to an error
(``statics.equilibrium``). Divergence without oscillation is an error; and under dead loads all λ of
K x = λ M x with Re λ < 0, s² = −λ, since these leave whatever the damping.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.blocks import Blocks
from soft_sim_ros.core.mechanics.closing import free_directions
from soft_sim_ros.core.mechanics.dynamics import Dynamics

from .large import growing_of, negative_directions, slow_motions, symmetric_blocks, unit_blocks
from .small_motion import EPS, Complex, all_decay, is_symmetric, leaving, small_motions, unit_scale

# Beyond so many coordinates motions without symmetry are looked at in the slowest directions only.
SLOWEST = 300
# Im s / Re s of motion that grows from round-off to the size of the arm within half a period, so
# that no oscillation is seen.
UNSEEN = np.pi / -np.log(EPS)


class Verdict(NamedTuple):
    """The verdict on the stability of an equilibrium.

    Attributes
    ----------
    unstable : number of directions in which the arm leaves by itself; of a swing that grows, two
    growth : largest growth in 1/s of what leaves; nan where only the stiffness was looked at
    hertz : the frequency in Hz at which that swings; 0 for what leaves without swinging
    undamped : whether all that leaves swings, and the scene has no damping that would decide
    """

    unstable: int
    growth: float = float("nan")
    hertz: float = 0.0
    undamped: bool = False

    @property
    def flutters(self) -> bool:
        """Whether what leaves swings as it does."""
        return self.unstable > 0 and 2.0 * np.pi * self.hertz > self.growth

    @property
    def refused(self) -> bool:
        """Whether this is no stable equilibrium, as far as the scene says what decides it."""
        return self.unstable > 0 and not self.undamped


def verdict(dynamics: Dynamics, mask: np.ndarray | None = None, time: float = 0.0) -> Verdict:
    """Judge the equilibrium of the last residual, for the coordinates in ``mask`` (n,).

    What constraints hold at ``time`` in s does not move.
    """
    mask = np.ones(dynamics.n, dtype=bool) if mask is None else mask
    if Blocks.serve(dynamics, mask):
        judged = _large(dynamics, mask)
        if judged is not None:
            return judged
    own = np.ix_(mask, mask)
    stiffness = dynamics.last_tangent((1.0, 0.0, 0.0))[own]
    if not stiffness.size:
        return Verdict(0)
    scale = unit_scale(stiffness, dynamics.law_at_rest[mask], dynamics.model.weight[mask])
    free = free_directions(dynamics, mask, time, scale)
    if free is not None:
        stiffness, scale = free.T @ stiffness @ free, np.ones(free.shape[1])
        if not stiffness.size:
            return Verdict(0)
    scaled = stiffness / np.outer(scale, scale)
    if is_symmetric(scaled):
        return Verdict(leaving(scaled))
    damping = dynamics.last_tangent((0.0, 1.0, 0.0))[own]
    mass = dynamics.last_tangent((0.0, 0.0, 1.0))[own]
    if free is not None:
        damping, mass = free.T @ damping @ free, free.T @ mass @ free
    if len(scale) > SLOWEST:
        heavy = np.linalg.eigh(0.5 * (mass + mass.T) / np.outer(scale, scale))[1][:, -SLOWEST:]
        basis = heavy / scale[:, None]
        stiffness, damping, mass = (basis.T @ x @ basis for x in (stiffness, damping, mass))
        scale = np.ones(SLOWEST)
    if all_decay(stiffness, damping, mass, scale):
        return Verdict(0)
    found = small_motions(stiffness, damping, mass, scale)
    return _of_growing(dynamics, found.values[found.growing], bool(damping.any()))


def _of_growing(dynamics: Dynamics, growing: Complex, damped: bool) -> Verdict:
    """Return the verdict on motions that grow, s (k,) in 1/s."""
    if not len(growing):
        return Verdict(0)
    fastest = growing[np.argmax(growing.real)]
    hertz = abs(float(fastest.imag)) / (2.0 * np.pi)
    follows = dynamics.forces_follow
    leaves = np.abs(growing.imag) < (UNSEEN if follows else 1.0) * growing.real
    undamped = not damped and not leaves.any()
    return Verdict(len(growing), float(fastest.real), hertz, undamped)


def _large(dynamics: Dynamics, mask: np.ndarray) -> Verdict | None:
    """Return the verdict on many coordinates at linear cost; None where only a dense one can tell.

    Without symmetry, of the slowest motions only.
    """
    blocks = Blocks(dynamics, mask)
    blocks.fill((1.0, 0.0, 0.0))
    scale = unit_blocks(dynamics, blocks)
    if symmetric_blocks(blocks, scale):
        count = None if blocks.tied else negative_directions(blocks, scale)
        return None if count is None else Verdict(count)
    motions = slow_motions(dynamics, mask, scale)
    if motions is None:
        return None
    blocks.fill((0.0, 1.0, 0.0))
    damped = bool(blocks.times(np.where(mask, 1.0, 0.0)).any())
    return _of_growing(dynamics, growing_of(motions), damped)


def unstable_directions(
    dynamics: Dynamics, mask: np.ndarray | None = None, time: float = 0.0
) -> int:
    """Return in how many ways the arm leaves the equilibrium of the last residual by itself.

    What constraints hold at ``time`` in s does not move.

    With a symmetric K, the number of its negative eigenvalues; without symmetry, the number of
    motions e^{st} with Re s > 0, those that swing included.
    """
    return verdict(dynamics, mask, time).unstable


def scaled_stiffness(dynamics: Dynamics, stiffness: Floats) -> tuple[Floats, Floats]:
    """Return a stiffness (n, n) in coordinates of elastic stiffness 1, and their scale (n,)."""
    scale = unit_scale(stiffness, dynamics.law_at_rest, dynamics.model.weight)
    return stiffness / np.outer(scale, scale), scale
