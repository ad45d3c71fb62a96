"""The shape a section has when nothing acts on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.centre_line import read_centre_line
from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.profile import Profile, profile_of, profiles_of
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats, Taper

ZERO, ONE = Taper(0.0, 0.0), Taper(1.0, 1.0)


@dataclass(frozen=True)
class Reference:
    """Reference strains of a section: curvature K_x K_y K_z in 1/m, stretch Γ_x, shear Γ_y Γ_z."""

    curvature: tuple[Profile, ...] = (ZERO, ZERO, ZERO)
    stretch: Profile = ONE
    shear: tuple[Profile, ...] = (ZERO, ZERO)

    @property
    def profiles(self) -> tuple[Profile, ...]:
        """The six strains in the order of STRAINS."""
        return (*self.curvature, self.stretch, *self.shear)

    def strain(self, x: Floats) -> Floats:
        """Return ξ₀ (…, 6) at normalised arc lengths x (…)."""
        return np.stack([profile(x) for profile in self.profiles], axis=-1)


def read_reference(reader: Reader, length: float) -> Reference:
    """Read ``reference`` of a section of a length in m; what is absent is straight."""
    if reader.has("centre_line"):
        reader.only("centre_line")
        return Reference(*read_centre_line(reader.mapping("centre_line"), length))
    reader.only("curvature", "stretch", "shear", "centre_line")
    return Reference(
        curvature=profiles_of(reader, "curvature", 3, length, default=0.0),
        stretch=profile_of(reader, "stretch", length, POSITIVE, default=1.0),
        shear=profiles_of(reader, "shear", 2, length, default=0.0),
    )
