"""Stiffness, damping and inertia of a section that were measured, not computed from its shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.profile import Profile, profile_of, profiles_of
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats

GIVEN = ("mass_per_length", "inertia_per_length", "stiffness", "damping", "coupling")


@dataclass(frozen=True)
class Given:
    """What replaces the numbers of material and cross-section, by index of the component.

    stiffness, damping : of STRAINS, N·m² and N, N·m²·s and N·s
    inertia : 0 for the mass in kg/m, 1 … 3 for the moments about x, y, z in kg·m
    coupling : by pair of components, lower first: the stiffness H_ij = H_ji between two strains,
        N·m² between angular ones, N between linear ones, N·m between one of each
    """

    stiffness: Mapping[int, Profile] = field(default_factory=dict)
    damping: Mapping[int, Profile] = field(default_factory=dict)
    inertia: Mapping[int, Profile] = field(default_factory=dict)
    coupling: Mapping[tuple[int, int], Profile] = field(default_factory=dict)

    @property
    def profiles(self) -> list[Profile]:
        """Everything given."""
        parts = (self.stiffness, self.damping, self.inertia, self.coupling)
        return [p for part in parts for p in part.values()]

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
        inertia[0] = profile_of(reader, "mass_per_length", length, POSITIVE)
    if reader.has("inertia_per_length"):
        moments = profiles_of(reader, "inertia_per_length", 3, length, POSITIVE)
        inertia |= dict(enumerate(moments, start=1))
    return Given(
        stiffness=_read_law(reader, "stiffness", length, POSITIVE),
        damping=_read_law(reader, "damping", length, NONNEGATIVE),
        inertia=inertia,
        coupling=_read_coupling(reader.mapping("coupling"), length),
    )


def _read_law(reader: Reader, key: str, length: float, within: Interval) -> dict[int, Profile]:
    law = reader.mapping(key).only(*STRAINS)
    return {
        i: profile_of(law, strain, length, within)
        for i, strain in enumerate(STRAINS)
        if law.has(strain)
    }


def _read_coupling(reader: Reader, length: float) -> dict[tuple[int, int], Profile]:
    """Read strain → strain → stiffness between the two; every pair stands once."""
    coupling: dict[tuple[int, int], Profile] = {}
    reader.only(*STRAINS)
    for i, first in enumerate(STRAINS):
        others = reader.mapping(first).only(*(strain for strain in STRAINS if strain != first))
        for j, second in enumerate(STRAINS):
            if not others.has(second):
                continue
            pair = min(i, j), max(i, j)
            if pair in coupling:
                others.refuse(f"every pair once: it stands under {second} too", second)
            coupling[pair] = profile_of(others, second, length)
    return coupling
