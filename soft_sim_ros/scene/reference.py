"""The shape a section has when nothing acts on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats, Taper

ZERO, ONE = Taper(0.0, 0.0), Taper(1.0, 1.0)


@dataclass(frozen=True)
class Reference:
    """Reference strains of a section: curvature K_x K_y K_z in 1/m, stretch Γ_x, shear Γ_y Γ_z."""

    curvature: tuple[Taper, ...] = (ZERO, ZERO, ZERO)
    stretch: Taper = ONE
    shear: tuple[Taper, ...] = (ZERO, ZERO)

    def strain(self, x: Floats) -> Floats:
        """Return ξ₀ (…, 6) at normalised arc lengths x (…)."""
        return np.stack([t(x) for t in (*self.curvature, self.stretch, *self.shear)], axis=-1)


def read_reference(reader: Reader) -> Reference:
    """Read ``reference`` of a section; what is absent is straight."""
    reader.only("curvature", "stretch", "shear")
    return Reference(
        curvature=reader.tapers("curvature", 3, default=0.0),
        stretch=reader.taper("stretch", POSITIVE, default=1.0),
        shear=reader.tapers("shear", 2, default=0.0),
    )
