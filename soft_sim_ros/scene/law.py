"""Laws of fibres: uniaxial stress against stretch beyond the linear law.

A fibre of an incompressible rod is stretched by λ along the backbone and sheared by γ around it.
Its stored energy per reference volume is w(λ, γ²), its nominal stress ∂w/∂λ. A section puts its
fibres together (core/terms/fibres.py); here is what one of them is made of.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
import scipy

from soft_sim_ros.scene.interval import FINITE, POSITIVE, Interval
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

# Stretches between which a law may be used at all: the range of measurements.
LEAST, MOST = 0.05, 20.0
KINDS = {
    "neo_hookean": ("c10",),
    "mooney_rivlin": ("c10", "c01"),
    "yeoh": ("c10", "c20", "c30"),
    "table": ("stretch", "stress"),
    "registered": ("name", "stretch"),
}
ACCURACY = 1e-8  # of a sampled stress, relative to the largest in its range
SAMPLES = 4096  # intervals after which a stress that is still not resolved is no smooth function

Function = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Rivlin:
    """w = c10 (I₁ − 3) + c01 (I₂ − 3) + c20 (I₁ − 3)² + c30 (I₁ − 3)³, coefficients in Pa.

    Incompressible, I₁ = λ² + (2 + γ²)/λ and I₂ = 2λ + (1 + γ²)/λ². Stretches in ``span`` are those
    around 1 where the stress grows with the stretch.
    """

    c10: float
    c01: float = 0.0
    c20: float = 0.0
    c30: float = 0.0

    @property
    def shear_modulus(self) -> float:
        """Small-strain modulus G = 2 (c10 + c01) in Pa."""
        return 2.0 * (self.c10 + self.c01)

    @property
    def young_modulus(self) -> float:
        """Small-strain modulus E = 3 G in Pa."""
        return 3.0 * self.shear_modulus

    @property
    def span(self) -> tuple[float, float]:
        """Least and largest stretch of the stable range, within LEAST … MOST."""
        ends = []
        for end in (LEAST, MOST):
            stretch = np.geomspace(1.0, end, 4001)
            bad = np.flatnonzero(~(self.slope(stretch) > 0.0))
            ends.append(float(stretch[bad[0] - 1] if len(bad) else end))
        return ends[0], ends[1]

    def stress(self, stretch: Floats) -> Floats:
        """Return the nominal stress in Pa of stretches without shear."""
        invariant = stretch**2 + 2.0 / stretch - 3.0
        first = self.c10 + 2.0 * self.c20 * invariant + 3.0 * self.c30 * invariant**2
        return 2.0 * (stretch - stretch**-2) * (first + self.c01 / stretch)

    def slope(self, stretch: Floats) -> Floats:
        """Return the derivative of the stress in Pa."""
        invariant = stretch**2 + 2.0 / stretch - 3.0
        rate = 2.0 * (stretch - stretch**-2)
        first = self.c10 + 2.0 * self.c20 * invariant + 3.0 * self.c30 * invariant**2
        second = 2.0 * self.c20 + 6.0 * self.c30 * invariant
        return (
            first * (2.0 + 4.0 * stretch**-3)
            + second * rate**2
            + self.c01 * 6.0 * stretch**-4
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Curve:
    """Nominal stress in Pa as a piecewise cubic function of the stretch, G γ²/2 for the shear.

    coefficients (N, 4), of rising powers of λ − breaks[i], between breaks (N + 1,).
    """

    breaks: Floats
    coefficients: Floats

    @property
    def shear_modulus(self) -> float:
        """Small-strain modulus G = E/3 in Pa."""
        return self.young_modulus / 3.0

    @property
    def young_modulus(self) -> float:
        """Slope of the stress at rest in Pa."""
        return float(self._polynomials().derivative()(1.0))

    @property
    def span(self) -> tuple[float, float]:
        """Least and largest stretch it is given for."""
        return float(self.breaks[0]), float(self.breaks[-1])

    def stress(self, stretch: Floats) -> Floats:
        """Return the nominal stress in Pa of stretches without shear."""
        return np.asarray(self._polynomials()(stretch))

    def energies(self) -> Floats:
        """Return the energy per reference volume (N,) in J/m³ at all breaks but the last."""
        energy = self._polynomials().antiderivative()
        return np.asarray(energy(self.breaks[:-1]) - energy(1.0))

    def _polynomials(self) -> scipy.interpolate.PPoly:
        return scipy.interpolate.PPoly(self.coefficients.T[::-1], self.breaks)


Law = Rivlin | Curve


@dataclass(frozen=True)
class _Registered:
    function: Function
    is_energy: bool


_REGISTERED: dict[str, _Registered] = {}


def register_law(
    name: str, *, stress: Function | None = None, energy: Function | None = None
) -> None:
    """Make a law known to scenes as ``law: {kind: registered, name: NAME, stretch: [low, high]}``.

    Parameters
    ----------
    name : what scenes call it
    stress : nominal stress in Pa as a function of stretches (N,), or
    energy : stored energy per reference volume in J/m³ as a function of stretches (N,)

    Raises
    ------
    ValueError
        unless exactly one of the two is given.
    """
    if (stress is None) == (energy is None):
        raise ValueError(f"the law {name!r} is given by either its stress or its energy")
    function = energy if stress is None else stress
    assert function is not None
    _REGISTERED[name] = _Registered(function, stress is None)


def read_law(reader: Reader) -> Law:
    """Read ``law`` of a material."""
    reader.one_of(("kind",))
    kind = reader.choice("kind", KINDS)
    reader.only("kind", *KINDS[kind])
    if kind == "table":
        return _read_table(reader)
    if kind == "registered":
        return _read_registered(reader)
    given = {key: reader.number(key, FINITE) for key in KINDS[kind]}
    law = Rivlin(**given)
    if POSITIVE.refuses(law.shear_modulus):
        reader.refuse("a law with a shear modulus 2 (c10 + c01) > 0", KINDS[kind][-1])
    return law


def _read_table(reader: Reader) -> Curve:
    """Read measured points, joined so that a stress that rises from point to point rises always."""
    stretch, stress = reader.numbers("stretch", POSITIVE), reader.numbers("stress", FINITE)
    if len(stretch) < 3 or not (np.diff(stretch) > 0.0).all():
        reader.refuse("at least three stretches in rising order", "stretch")
    if len(stress) != len(stretch):
        reader.refuse(f"{len(stretch)} stresses in Pa, one for each stretch", "stress")
    if not (np.diff(stress) > 0.0).all():
        reader.refuse("stresses that rise from each stretch to the next", "stress")
    rest = np.flatnonzero(stretch == 1.0)
    if len(rest) != 1 or rest[0] in (0, len(stretch) - 1):
        reader.refuse("stretches below, at and above 1", "stretch")
    if stress[rest[0]] != 0.0:
        reader.refuse("a stress of 0 at the stretch of 1", "stress")
    law = _curve(scipy.interpolate.PchipInterpolator(stretch, stress))
    if expected := POSITIVE.refuses(law.young_modulus):
        slope = f"the slope at a stretch of 1, {law.young_modulus:g} Pa"
        reader.refuse(f"stresses with {expected} as {slope}", "stress")
    return law


def _read_registered(reader: Reader) -> Curve:
    """Sample a registered function until the spline through it is as good as ACCURACY."""
    name = reader.reference("name", _REGISTERED, "law that soft_sim_ros.scene.register_law knows")
    low, high = reader.vector("stretch", 2, Interval(LEAST, MOST, True, True))
    if not low < 1.0 < high:
        reader.refuse("a range [low, high] of stretches with low < 1 < high", "stretch")
    law = _REGISTERED[name]

    def refuse(what: str) -> NoReturn:
        reader.refuse(f"{what} everywhere in [{low:g}, {high:g}]", "name")

    count = 64
    while count <= SAMPLES:
        below = max(4, round(count * (1.0 - low) / (high - low)))
        grid = np.append(np.linspace(low, 1.0, below + 1)[:-1],
                         np.linspace(1.0, high, max(4, count - below) + 1))  # fmt: skip
        values, between = _call(law, grid, refuse), 0.5 * (grid[1:] + grid[:-1])
        spline = scipy.interpolate.CubicSpline(grid, values)
        if law.is_energy:
            spline = scipy.interpolate.CubicSpline(
                grid, scipy.interpolate.make_interp_spline(grid, values, k=5).derivative()(grid)
            )
            seen = spline.antiderivative()(between) - spline.antiderivative()(1.0)
            wanted = _call(law, between, refuse) - values[grid == 1.0]
        else:
            seen, wanted = spline(between), _call(law, between, refuse)
        if np.abs(seen - wanted).max() <= ACCURACY * np.abs(values).max():
            break
        count *= 2
    else:
        refuse("a smooth function of the stretch")
    rest = float(spline(1.0))
    if abs(rest) > 1e-6 * np.abs(spline(grid)).max():
        refuse(
            f"a law without stress at rest, it is {rest:g} Pa at a stretch of 1, and a smooth one"
        )
    spline.c[-1] -= rest
    if not (spline.derivative()(np.append(grid, between)) > 0.0).all():
        refuse("a stress that rises with the stretch")
    return _curve(spline)


def _call(law: _Registered, stretch: Floats, refuse: Callable[[str], NoReturn]) -> Floats:
    values = np.asarray(law.function(stretch), dtype=float)
    if values.shape != stretch.shape or not np.isfinite(values).all():
        refuse("a function of stretches (N,) with finite values (N,)")
    return values


def _curve(spline: scipy.interpolate.PPoly) -> Curve:
    return Curve(np.asarray(spline.x), np.ascontiguousarray(spline.c[::-1].T))
