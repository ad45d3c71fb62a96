"""Rods on a hinge: large rotations, little damping."""

from __future__ import annotations

from .case import Case, HubTorque

SLENDER_SWING = Case(
    name="slender_swing",
    title="Slender rod on a hinge falls from the horizontal and swings",
    sections=(1.0,),
    radius=0.005,
    young=2e7,
    density=1000.0,
    viscosity=100.0,
    gravity=(0.0, 0.0, -9.81),
    duration=1.0,
    outputs=50,
    hinge="y",
)

SPIN_UP = Case(
    name="spin_up",
    title="Flexible beam on a hub is spun up by a torque with ramps, then turns freely",
    sections=(1.0,),
    radius=0.01,
    young=5e7,
    density=1000.0,
    viscosity=500.0,
    gravity=(0.0, 0.0, 0.0),
    duration=1.5,
    outputs=50,
    hinge="z",
    hub=HubTorque(value=0.5, ramp=0.2, end=1.0),
)
