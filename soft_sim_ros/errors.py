"""Every error this package raises on purpose: each keeps its numbers and prints them."""

from __future__ import annotations


class SoftSimError(Exception):
    """Base of all errors of this package."""


class SceneError(SoftSimError):
    """A scene says something that cannot be simulated, or says it in words nobody knows.

    Parameters
    ----------
    file : name of the scene file
    key_path : where in the file, such as ``bodies[0].sections[1].length``; empty for the whole file
    value : what is written there; None if nothing is
    expected : what should be written there
    line : line in the file, counted from 1, if known
    """

    def __init__(
        self, file: str, key_path: str, value: object, expected: str, line: int | None = None
    ) -> None:
        super().__init__(file, key_path, value, expected, line)
        self.file, self.key_path, self.value = file, key_path, value
        self.expected, self.line = expected, line

    def __str__(self) -> str:
        """Put the numbers in a sentence."""
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        key = self.key_path or "scene"
        what = f"{key} is missing" if self.value is None else f"{key} = {self.value}"
        return f"{where}: {what}: expected {self.expected}"


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
        """Put the numbers in a sentence."""
        return f"at t = {self.time:.9g} s: {self.reason}"


class Diverged(SolverError):
    """No acceptable step leads on from ``time``; the state is still the last good one."""


class Inaccurate(SolverError):
    """The run knows that its error is beyond what is allowed.

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


class ToleranceMissed(SoftSimError):
    """No choice of numerics, or not the one that the scene fixes, meets its tolerance.

    Parameters
    ----------
    file : of the scene
    tolerance, estimate : of the tip's error, over the arm's length
    finest : the finest choice that was tried, in words
    """

    def __init__(self, file: str, tolerance: float, estimate: float, finest: str) -> None:
        super().__init__(file, tolerance, estimate, finest)
        self.file, self.tolerance, self.estimate, self.finest = file, tolerance, estimate, finest

    def __str__(self) -> str:
        """Put the numbers in a sentence."""
        return (
            f"{self.file}: numerics.tolerance = {self.tolerance:g} is not met: the estimate is "
            f"{self.estimate:.2g} with {self.finest}"
        )


class EnergyGained(SolverError):
    """The steps made energy out of nothing.

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
        """Put the numbers in a sentence."""
        return (
            f"the equilibrium flutters: a swing of {self.hertz:.3g} Hz about it grows by "
            f"{self.growth:.3g} 1/s under moments or loads that follow the arm; the scene has no "
            "damping (material.viscosity) that would decide whether the arm does"
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
        """Put the numbers in a sentence."""
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
        """Put the numbers in a sentence."""
        return (
            f"the target is out of reach: the tip comes within {self.distance:.4g} m "
            f"and {self.angle:.4g} rad of it"
        )


class RecordingError(SoftSimError):
    """A recording cannot be read or written.

    Parameters
    ----------
    path : file or directory of the recording
    reason : why
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(str(path), reason)
        self.path, self.reason = str(path), reason

    def __str__(self) -> str:
        """Put the numbers in a sentence."""
        return f"{self.path}: {self.reason}"


class TornRecording(RecordingError):
    """A recording that was never closed: its end is missing, its beginning may be readable."""


class CommandError(SoftSimError):
    """A command that came in from outside is refused.

    Parameters
    ----------
    topic : where it came from
    why : what is wrong with it
    """

    def __init__(self, topic: str, why: str) -> None:
        super().__init__(topic, why)
        self.topic, self.why = topic, why

    def __str__(self) -> str:
        """Put the numbers in a sentence."""
        return f"{self.topic}: {self.why}"


class NotResolved(UserWarning):
    """A result is further from the continuous arm than it should be: the basis is too coarse.

    Parameters
    ----------
    scene : its name
    error : estimate of the tip's error in space over the length; infinite where none can be given
    limit : beyond which somebody is told
    """

    def __init__(self, scene: str, error: float, limit: float) -> None:
        super().__init__(scene, error, limit)
        self.scene, self.error, self.limit = scene, error, limit

    def __str__(self) -> str:
        """Put the numbers in a sentence, and say what helps."""
        size = f"{self.error:.2g} of the length"
        if self.error == float("inf"):
            size = "any amount (a finer basis finds no equilibrium nearby)"
        return (
            f"{self.scene}: basis and nodes do not show this state: the tip may be off by {size}, "
            f"more than {self.limit:g}; write a higher numerics.basis.order or more elements"
        )


class NoSuchPlace(SoftSimError):
    """A rod, a strain or an arc length that the arm does not have.

    Parameters
    ----------
    asked : what was asked for
    expected : what there is
    """

    def __init__(self, asked: object, expected: str) -> None:
        super().__init__(asked, expected)
        self.asked, self.expected = asked, expected

    def __str__(self) -> str:
        """Put both in a sentence."""
        return f"{self.asked!r}: expected {self.expected}"


class MissingExtra(SoftSimError):
    """Something optional is asked for, and the package it needs is not installed.

    Parameters
    ----------
    what : what was asked for
    package : name of the missing package
    extra : name of our extra that brings it
    """

    def __init__(self, what: str, package: str, extra: str) -> None:
        super().__init__(what, package, extra)
        self.what, self.package, self.extra = what, package, extra

    def __str__(self) -> str:
        """Say how to get it."""
        return (
            f"{self.what} needs {self.package}, which is not installed: "
            f"pip install 'soft_sim_ros[{self.extra}]', or apt install python3-{self.package}"
        )


class DeriveError(SoftSimError):
    """Equations cannot be derived from what is asked for.

    Parameters
    ----------
    key : the option
    value : what it says
    expected : what it should say
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        """Put it in a sentence."""
        return f"{self.key} = {self.value!r}: expected {self.expected}"
