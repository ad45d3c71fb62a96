"""Errors of the solvers of motions and equilibria."""

from __future__ import annotations

from .base import SoftSimError


class SolverError(SoftSimError):
    """The solver gave up.

    Parameters
    ----------
    time : simulation time in s at which it gave up
    reason : why
    """

    def __init__(self, time: float, reason: str) -> None:
        super().__init__(time, reason)
        self.time, self.reason = time, reason

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return f"at t = {self.time:.9g} s: {self.reason}"


class Diverged(SolverError):
    """No acceptable step leads on from ``time``; the state is still the last good one."""


class Inaccurate(SolverError):
    """The estimated error of a run exceeds its limit.

    Parameters
    ----------
    time : simulation time in s
    estimate, limit : of the tip's error, over the arm's length
    """

    def __init__(self, time: float, estimate: float, limit: float) -> None:
        super().__init__(
            time,
            f"the tip may be off by {estimate:.2g} of the arm's length, allowed is {limit:.2g} "
            "(a smaller step shows more)",
        )
        self.args = (time, estimate, limit)
        self.estimate, self.limit = estimate, limit


class EnergyGained(SolverError):
    """The steps generated spurious energy.

    Parameters
    ----------
    time : simulation time in s
    gained, limit : over the energy turned over
    """

    def __init__(self, time: float, gained: float, limit: float) -> None:
        super().__init__(
            time,
            f"{gained:.2g} of the energy turned over is from nowhere, allowed is {limit:.2g} "
            "(a smaller step keeps the balance)",
        )
        self.args = (time, gained, limit)
        self.gained, self.limit = gained, limit


class NewtonFailed(SolverError):
    """Newton's method of one step did not converge.

    Parameters
    ----------
    time : simulation time in s at the start of the step
    iterations : how many were made
    residual, tolerance : the measure of convergence reached, and the one asked for
    """

    def __init__(self, time: float, iterations: int, residual: float, tolerance: float) -> None:
        super().__init__(
            time,
            f"Newton's method reached {residual:.3g} after {iterations} iterations, "
            f"tolerance {tolerance:.3g}",
        )
        self.args = (time, iterations, residual, tolerance)
        self.iterations, self.residual, self.tolerance = iterations, residual, tolerance


class StaticsFailed(SolverError):
    """The path of equilibria could not be followed up to the full load.

    Parameters
    ----------
    load_factor : largest fraction of the load, in [0, 1], with an equilibrium found
    residual : measure of convergence of the last attempt beyond it
    time : simulation time in s of the loads in question
    why : what is known beyond that
    """

    def __init__(
        self, load_factor: float, residual: float, time: float = 0.0, why: str = ""
    ) -> None:
        text = f"no equilibrium found beyond {load_factor:.6g} of the load"
        known = why or f"residual {residual:.3g} of the last attempt"
        super().__init__(time, f"{text} ({known})")
        self.args = (load_factor, residual, time, why)
        self.load_factor, self.residual, self.why = load_factor, residual, why


class NotMet(SoftSimError):
    """A constraint between two frames is not met, and cannot be put right.

    Parameters
    ----------
    name : of the constraint
    distance : between its frames along what it holds, m
    angle : likewise, rad
    why : what is known, or helps
    """

    def __init__(self, name: str, distance: float, angle: float, why: str) -> None:
        super().__init__(name, distance, angle, why)
        self.name, self.distance, self.angle, self.why = name, distance, angle, why

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return (
            f"constraint {self.name!r} is not met: its frames are {self.distance:.4g} m and "
            f"{self.angle:.4g} rad apart along what it holds ({self.why})"
        )


class NoBranch(SoftSimError):
    """No branch of equilibria can be followed from where it was looked for.

    Parameters
    ----------
    load : λ at which it was looked for
    why : what is known
    """

    def __init__(self, load: float, why: str) -> None:
        super().__init__(load, why)
        self.load, self.why = load, why

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return f"no branch of equilibria at load {self.load:g}: {self.why}"


class TargetUnreachable(SoftSimError):
    """No efforts were found, within their limits, that bring the tip to its target.

    Parameters
    ----------
    distance : between the target position and the nearest one found, m
    angle : between the target orientation and the one found there, rad
    closest : efforts and pose found, an ``inverse_kinematics.Reach``
    """

    def __init__(self, distance: float, angle: float, closest: object = None) -> None:
        super().__init__(distance, angle, closest)
        self.distance, self.angle, self.closest = distance, angle, closest

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return (
            f"the target is out of reach: the tip comes within {self.distance:.4g} m "
            f"and {self.angle:.4g} rad of it"
        )


class UndampedFlutter(UserWarning):
    """About an equilibrium without any damping small swings grow, under moments or followers.

    Parameters
    ----------
    growth : in 1/s
    hertz : frequency of the swing in Hz
    """

    def __init__(self, growth: float, hertz: float) -> None:
        super().__init__(growth, hertz)
        self.growth, self.hertz = growth, hertz

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return (
            f"the equilibrium flutters: a swing of {self.hertz:.3g} Hz about it grows by "
            f"{self.growth:.3g} 1/s under moments or loads that follow the arm; the scene has no "
            "damping (material.viscosity) that would decide whether the arm does"
        )
