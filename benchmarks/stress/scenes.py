"""The scenes of the stability map: one clamped rod, and commands that ask too much of it."""

from __future__ import annotations

import itertools
import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.scene import Scene, parse_scene
from soft_sim_ros.scene.numerics import INTEGRATORS

LENGTH = 0.5  # m
POISSON = 0.45
STEPS = 64  # steps of every run; the command is held for one of them
YOUNG = tuple(10.0**k for k in range(3, 13))
SLENDERNESS = (5.0, 20.0, 80.0, 300.0, 1000.0)
STEP = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
COMMANDS = ("step", "chirp", "noise", "reversal", "buckling")
DENSITY = (100.0, 1000.0, 8000.0)
DAMPING = (0.0, 0.01, 0.1, 1.0, 10.0)
METHODS = tuple(name for name in INTEGRATORS if name != "adaptive")
# Σ of the channels' angles: what a step turns the tip by, in rad
TURN = np.array([0.5, 1.0, 0.5])
CHANNELS = ("torsion", "bend_y", "bend_z")


@dataclass(frozen=True)
class Case:
    """One point of the map.

    young : Pa; slenderness : length over diameter; step : s; density : kg/m³
    damping : ratio of the slowest bending mode, of the straight rod
    seed : of noise and of where on the map the other factors were drawn
    """

    young: float
    slenderness: float
    step: float
    command: str
    density: float
    damping: float
    integrator: str
    seed: int

    @property
    def radius(self) -> float:
        """Radius in m."""
        return 0.5 * LENGTH / self.slenderness

    @property
    def omega(self) -> float:
        """Lowest angular frequency in rad/s of the straight clamped rod (Euler–Bernoulli)."""
        return 1.8751**2 / LENGTH**2 * math.sqrt(self.young / self.density) * self.radius / 2.0

    @property
    def sag(self) -> float:
        """Weight times length squared over bending stiffness: beyond 8 a rod cannot stand."""
        return self.density * 9.81 * LENGTH**3 * 4.0 / (self.young * self.radius**2)

    def real(self) -> bool:
        """Tell whether somebody may build and drive this arm, with a step that shows its motion.

        From gel to hard rubber, as thick or as thin as arms are, not foam, able to lift its tip,
        and no longer a step than recommended: 1/100 of the period of the third mode, which for a
        round rod is 0.01 over the angular frequency of the first.
        """
        return (
            1e4 <= self.young <= 1e8
            and 5.0 <= self.slenderness <= 100.0
            and self.density >= 900.0
            and self.damping >= 0.01
            and self.sag <= 50.0
            and self.command != "buckling"
            and self.omega * self.step <= 0.01
        )

    def scene(self, pieces: int = 1) -> Scene:
        """Return the scene, each of its steps cut into so many."""
        shear = self.young / (2.0 * (1.0 + POISSON))
        document: dict[str, Any] = {
            "name": "stress",
            "materials": {
                "soft": {
                    "young_modulus": self.young,
                    "shear_modulus": shear,
                    "density": self.density,
                    "viscosity": 2.0 * self.damping / self.omega * shear,
                }
            },
            "bodies": [
                {
                    "rod": "rod",
                    "sections": [
                        {
                            "name": "all",
                            "length": LENGTH,
                            "material": "soft",
                            "cross_section": {"shape": "circle", "radius": self.radius},
                        }
                    ],
                }
            ],
            "actuators": [
                {"moment": name, "rod": "rod", "section": "all", "strain": name}
                for name in CHANNELS
            ],
            "numerics": {"step": self.step / pieces, "integrator": self.integrator},
        }
        return parse_scene(yaml.safe_dump(document), "stress.yaml")

    def efforts(self) -> Floats:
        """Return the moments (STEPS, 3) in N·m held during each step."""
        bending = self.young * 0.25 * math.pi * self.radius**4
        torsion = bending / (1.0 + POISSON)
        unit = TURN * np.array([torsion, bending, bending]) / LENGTH
        n = np.arange(STEPS)
        if self.command == "step":
            wave = np.ones(STEPS)
        elif self.command == "chirp":  # from rest to a sign change at every step
            wave = np.cos(0.5 * math.pi * n**2 / STEPS)
        elif self.command == "noise":
            wave = np.random.default_rng(self.seed).normal(size=(STEPS, 3))
            return wave * unit
        elif self.command == "reversal":
            wave = np.where(n // (STEPS // 4) % 2 == 0, 2.0, -2.0)
        else:
            # 10 times the torque that makes a straight rod coil (Greenhill: 2π EI / L), and bending
            twist = np.array([10.0 * 2.0 * math.pi * bending / LENGTH, 0.0, 0.0])
            return np.tile(twist + unit, (STEPS, 1))
        return np.outer(wave, unit)

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters."""
        return asdict(self)


def cases(count: int, seed: int = 1) -> list[Case]:
    """Return ``count`` cases all over the map.

    Stiffness, slenderness, step and command on a full grid, as often as needed, the other factors
    drawn anew each time.
    """
    rng = np.random.default_rng(seed)
    grid = list(itertools.product(YOUNG, SLENDERNESS, STEP, COMMANDS))
    drawn = (point for _ in itertools.count() for point in grid)
    return [
        Case(
            *point,
            density=float(rng.choice(DENSITY)),
            damping=float(rng.choice(DAMPING)),
            integrator=str(rng.choice(METHODS)),
            seed=int(rng.integers(2**31)),
        )
        for point in itertools.islice(drawn, count)
    ]


def real_cases(count: int, seed: int = 2) -> list[Case]:
    """Return ``count`` cases of real arms, drawn evenly between bounds or their logarithms."""
    rng = np.random.default_rng(seed)
    out: list[Case] = []
    while len(out) < count:
        case = Case(
            young=10.0 ** rng.uniform(4.0, 8.0),
            slenderness=10.0 ** rng.uniform(np.log10(5.0), 2.0),
            step=round(10.0 ** rng.uniform(-5.0, -1.5), 6) or 1e-6,
            command=str(rng.choice(COMMANDS[:-1])),
            density=rng.uniform(900.0, 2000.0),
            damping=10.0 ** rng.uniform(-2.0, 1.0),
            integrator=str(rng.choice(METHODS)),
            seed=int(rng.integers(2**31)),
        )
        if case.real():
            out.append(case)
    return out
