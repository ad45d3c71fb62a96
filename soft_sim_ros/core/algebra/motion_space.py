"""The directions in which a model can move: in space, or in a plane of the base frame."""

from typing import NamedTuple

from soft_sim_ros.core.backend.structs import struct


@struct
class Spatial(NamedTuple):
    """Motion in space. The type of ``Model.space`` tells kernels which components can move."""

    components: tuple[int, ...] = (0, 1, 2, 3, 4, 5)  # components of twists that may not vanish


@struct
class PlaneXY(NamedTuple):
    """Motion in the x-y plane of the base frame: kernels skip components that vanish."""

    components: tuple[int, ...] = (2, 3, 4)


@struct
class PlaneXZ(NamedTuple):
    """Motion in the x-z plane of the base frame."""

    components: tuple[int, ...] = (1, 3, 5)


Space = Spatial | PlaneXY | PlaneXZ
SPACES: tuple[type[Space], ...] = (Spatial, PlaneXY, PlaneXZ)
