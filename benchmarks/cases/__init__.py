"""The cases, by name."""

from . import arms, hinged
from .case import STRAINS, Case

CASES: dict[str, Case] = {
    case.name: case
    for case in (
        arms.HEAVY_ARM,
        arms.RELEASE_3D,
        arms.TORQUE_STEP,
        arms.TENDON_STEP,
        arms.CHIRP,
        hinged.SLENDER_SWING,
        hinged.SPIN_UP,
        arms.PLANAR_PCS,
        arms.SPATIAL_PCS,
        arms.GVS,
    )
}

__all__ = ["CASES", "STRAINS", "Case"]
