"""What a case is: physics only, in plain numbers that any program and any Python can read."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


@dataclass(frozen=True)
class Moments:
    """Internal moments (N·m) along sections, held constant between multiples of ``period`` (s).

    channels : (section, strain) of every channel
    values : one row of efforts per period
    """

    channels: tuple[tuple[int, str], ...]
    period: float
    values: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Tendon:
    """A tendon from the base to the tip; offsets (y, z) in m go linearly from one end to the other.

    tension : N, from time zero on
    """

    start: tuple[float, float]
    end: tuple[float, float]
    tension: float


@dataclass(frozen=True)
class HubTorque:
    """A torque about the axis of the base hinge: ramp up, hold, ramp down, in s and N·m."""

    value: float
    ramp: float
    end: float


@dataclass(frozen=True)
class Case:
    """One uniform circular rod along x from the origin, straight when nothing acts on it.

    The section law is linear per reference length, with Kelvin–Voigt damping
    η·diag(J, 3I, 3I, 3A, A, A) and stiffness diag(GJ, EI, EI, EA, GA, GA): G = E/3, J = 2I, no
    shear correction.

    name, title : short and long name
    sections : lengths in m
    radius : m
    young : Pa
    density : kg/m³
    viscosity : η in Pa·s
    gravity : (3,) m/s²
    duration : s simulated
    outputs : number of equally spaced times, after zero, at which the tip is compared
    strains : the strains that are free; the others are locked
    hinge : axis of a free hinge at the base, "y" or "z"; None: clamped
    offset : (6,) uniform strain at rest at time zero, on top of the straight shape
    """

    name: str
    title: str
    sections: tuple[float, ...]
    radius: float
    young: float
    density: float
    viscosity: float
    gravity: tuple[float, float, float]
    duration: float
    outputs: int
    strains: tuple[str, ...] = STRAINS
    hinge: str | None = None
    offset: tuple[float, ...] = (0.0,) * 6
    moments: Moments | None = None
    tendon: Tendon | None = None
    hub: HubTorque | None = None

    @property
    def length(self) -> float:
        """Total length in m."""
        return sum(self.sections)

    @property
    def shear(self) -> float:
        """Shear modulus in Pa."""
        return self.young / 3.0

    @property
    def output_period(self) -> float:
        """Time between outputs in s."""
        return self.duration / self.outputs

    def as_dict(self) -> dict[str, Any]:
        """Return everything as JSON can hold it, with the derived numbers peers need."""
        return asdict(self) | {"length": self.length, "shear": self.shear}
