"""What the multibody engines are run with on a case, cheap settings first.

Pieces and steps per output, found by search; a run beyond the time allowed is skipped.
"""

from __future__ import annotations

from typing import Any

from ..cases import Case

Settings = dict[str, Any]

# Exudyn: (elements, steps per output)
CABLE = ((4, 8), (8, 6), (8, 8), (8, 16), (16, 8), (16, 16), (32, 32))
BEAM = {
    "spin_up": ((32, 8), (64, 16), (128, 32), (256, 64)),
    "slender_swing": ((32, 8), (64, 16), (128, 32), (256, 64)),
    "heavy_arm": ((16, 8), (16, 16), (32, 8), (32, 16), (64, 16), (64, 32), (128, 64)),
}
PUBLISHED = ((16, 2), (16, 4), (32, 4), (32, 8), (64, 8), (64, 16), (128, 32), (256, 64))
BODIES = ((12, 2), (12, 4), (24, 4), (24, 8), (48, 8), (48, 16), (96, 16), (96, 32), (192, 64))
# spectral radius at infinity of generalised-α
PLANAR, SPATIAL = 0.95, 0.8

# MuJoCo: (pieces, steps per output); with bending alone, and with stretch: what is just stable
BENT = {
    "slender_swing": ((8, 10), (16, 20), (32, 40)), "spin_up": ((8, 10), (16, 30), (32, 120)),
}  # fmt: skip
STRETCHED = {
    "slender_swing": ((16, 40), (24, 60), (32, 80), (64, 160)),
    "spin_up": ((16, 80), (24, 120), (32, 160), (64, 320)),
}
IMPLICIT = (
    (6, 20), (12, 20), (12, 40), (12, 100), (24, 40), (24, 100), (24, 200), (32, 400), (48, 200),
)  # fmt: skip


def exudyn(case: Case) -> list[Settings]:
    """Return settings of Exudyn: planar elements where the motion is planar, else bodies."""
    bodies = {"model": "rigid", "rho": SPATIAL}
    if case.moments or any(case.offset):
        per = round(case.output_period / case.moments.period) if case.moments else 1
        steps = max(per, 1)  # efforts change at the ends of steps
        return [bodies | {"elements": n, "steps": s} for n, s in BODIES if s % steps == 0]
    radius = {"rho": PLANAR}
    grid = BEAM.get(case.name, PUBLISHED)
    out = [{"model": "ge2d", "elements": n, "steps": s} | radius for n, s in grid]
    if case.hinge:
        out = [{"model": "ancf", "elements": n, "steps": s} | radius for n, s in CABLE] + out
    elif case.name == "heavy_arm":  # what a chain of bodies would do here
        out.append(bodies | {"elements": 24, "steps": 8})
    return out


def mujoco(case: Case) -> list[Settings]:
    """Return settings of MuJoCo: Runge–Kutta where nothing is damped much, else implicitfast."""
    plane = {"slender_swing": ["bend_y", "stretch"], "spin_up": ["bend_z", "stretch"]}
    if case.hinge:
        bent = plane[case.name][:1]
        grids = [
            ("RK4", bent, BENT[case.name]),
            ("RK4", plane[case.name], STRETCHED[case.name]),
            ("implicitfast", bent, ((16, 60), (32, 200))),
        ]
        return [
            {"elements": n, "steps": s, "integrator": integrator, "strains": strains}
            for integrator, strains, grid in grids
            for n, s in grid
        ]
    chosen = {"strains": ["bend_z", "stretch", "shear_y"]} if case.name == "heavy_arm" else {}
    return [{"elements": n, "steps": s, "integrator": "implicitfast"} | chosen for n, s in IMPLICIT]
