"""Arms that are clamped and damped like silicone."""

from __future__ import annotations

import math

from .case import Case, Moments, Tendon

# The material of the published SoRoMoX roll-outs; their viscosity.
SOFT = {"radius": 0.03, "young": 1e6, "density": 1000.0, "viscosity": 1e4}

HEAVY_ARM = Case(
    name="heavy_arm",
    title="Heavy arm, clamped horizontally, settles under its weight",
    sections=(0.6,),
    **SOFT,
    gravity=(0.0, -9.81, 0.0),
    duration=10.0,
    outputs=100,
)

RELEASE_3D = Case(
    name="release_3d",
    title="Rod held bent and twisted by an end wrench is let go (3-D, torsion)",
    sections=(0.4,),
    radius=0.01,
    young=1e6,
    density=1000.0,
    viscosity=3e3,
    gravity=(0.0, 0.0, -9.81),
    duration=1.0,
    outputs=50,
    offset=(6.0, 4.0, -2.0, 0.0, 0.0, 0.0),
)

_ARM = {"radius": 0.025, "young": 7e5, "density": 1070.0, "viscosity": 5e3}
_HANGING = (9.81, 0.0, 0.0)

TORQUE_STEP = Case(
    name="torque_step",
    title="Three-section arm, hanging: steps of bending and twisting torque (3-D, torsion)",
    sections=(0.2, 0.2, 0.2),
    **_ARM,
    gravity=_HANGING,
    duration=1.0,
    outputs=50,
    moments=Moments(
        channels=(
            (0, "bend_y"), (0, "bend_z"), (1, "bend_y"), (1, "bend_z"), (2, "bend_y"),
            (2, "bend_z"), (0, "torsion"),
        ),
        period=1.0,
        values=((0.8, 0.4, -0.5, 0.6, 0.5, -0.4, 0.3),),
    ),
)  # fmt: skip

TENDON_STEP = Case(
    name="tendon_step",
    title="Arm, hanging: a tendon that winds by a quarter is pulled at once (3-D, torsion)",
    sections=(0.6,),
    **_ARM,
    gravity=_HANGING,
    duration=1.0,
    outputs=50,
    tendon=Tendon(start=(0.02, 0.0), end=(0.0, 0.015), tension=15.0),
)


def _chirp() -> Moments:
    period, duration, low, high = 0.005, 1.0, 0.5, 8.0
    rows = []
    for k in range(round(duration / period)):
        t = k * period
        phase = 2.0 * math.pi * (low * t + (high - low) * t * t / (2.0 * duration))
        rows.append((0.25 * math.sin(phase), 0.2 * math.sin(0.8 * phase)))
    return Moments(((0, "bend_y"), (0, "bend_z")), period, tuple(rows))


CHIRP = Case(
    name="chirp",
    title="Arm, hanging: two chirped torques, 0.5 to 8 Hz, held for 5 ms each (3-D)",
    sections=(0.3,),
    radius=0.02,
    young=7e5,
    density=1070.0,
    viscosity=5e3,
    gravity=_HANGING,
    duration=1.0,
    outputs=50,
    moments=_chirp(),
)

PLANAR_PCS = Case(
    name="planar_pcs",
    title="Set-up of SoRoMoX's planar PCS roll-out",
    sections=(0.3, 0.3),
    **SOFT,
    gravity=(0.0, -9.81, 0.0),
    duration=3.0,
    outputs=60,
    strains=("bend_z", "stretch", "shear_y"),
)

SPATIAL_PCS = Case(
    name="spatial_pcs",
    title="Set-up of SoRoMoX's spatial PCS roll-out",
    sections=(0.3, 0.3),
    **SOFT,
    gravity=(0.0, -9.81, -9.81),
    duration=3.0,
    outputs=60,
)

GVS = Case(
    name="gvs",
    title="Set-up of SoRoMoX's GVS roll-out",
    sections=(0.3, 0.3),
    **SOFT,
    gravity=(0.0, -9.81, -9.81),
    duration=3.0,
    outputs=60,
    strains=("bend_y", "bend_z", "stretch"),
)
