"""Stiffness, damping and inertia of a section that were measured, not computed from its shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.profile import Profile
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats

GIVEN = ("mass_per_length", "inertia_per_length", "stiffness", "damping")


@dataclass(frozen=True)
class Given:
    """What replaces the numbers of material and cross-section, by index of the component.

    stiffness, damping : of STRAINS, N·m² and N, N·m²·s and N·s
    inertia : 0 for the mass in kg/m, 1 … 3 for the moments about x, y, z in kg·m
    """

    stiffness: Mapping[int, Profile] = field(default_factory=dict)
    damping: Mapping[int, Profile] = field(default_factory=dict)
    inertia: Mapping[int, Profile] = field(default_factory=dict)

    @property
    def profiles(self) -> list[Profile]:
        """Everything given."""
        return [p for part in (self.stiffness, self.damping, self.inertia) for p in part.values()]

    @staticmethod
    def put(values: Floats, part: Mapping[int, Profile], x: Floats) -> Floats:
        """Overwrite the given components of values (…, k) at x (…), and return them."""
        for component, profile in part.items():
            values[..., component] = profile(np.asarray(x, dtype=float))
        return values


def read_given(reader: Reader, length: float) -> Given:
    """Read the keys GIVEN of a section of a length in m; all may be absent."""
    inertia: dict[int, Profile] = {}
    if reader.has("mass_per_length"):
        inertia[0] = reader.profile("mass_per_length", length, POSITIVE)
    if reader.has("inertia_per_length"):
        moments = reader.profiles("inertia_per_length", 3, length, POSITIVE)
        inertia |= dict(enumerate(moments, start=1))
    return Given(
        stiffness=_read_law(reader, "stiffness", length, POSITIVE),
        damping=_read_law(reader, "damping", length, NONNEGATIVE),
        inertia=inertia,
    )


def _read_law(reader: Reader, key: str, length: float, within: Interval) -> dict[int, Profile]:
    law = reader.mapping(key).only(*STRAINS)
    return {
        i: law.profile(strain, length, within)
        for i, strain in enumerate(STRAINS)
        if law.has(strain)
    }
