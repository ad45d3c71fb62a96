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
RADIUS = {"hinge": 0.95, "damped": 0.8}

# MuJoCo: (pieces, steps per output)
RUNGE_KUTTA = ((8, 20), (16, 20), (16, 40), (32, 40), (32, 80), (64, 160))
IMPLICIT = (
    (6, 20), (12, 20), (12, 40), (12, 100), (24, 40), (24, 100), (24, 200), (32, 400), (48, 200),
)  # fmt: skip


def exudyn(case: Case) -> list[Settings]:
    """Return settings of Exudyn: planar elements where the motion is planar, else bodies."""
    radius = {"rho": RADIUS["hinge" if case.hinge else "damped"]}
    if case.moments or any(case.offset):
        return [{"model": "rigid", "elements": n, "steps": s} | radius for n, s in BODIES]
    grid = BEAM.get(case.name, PUBLISHED)
    out = [{"model": "ge2d", "elements": n, "steps": s} | radius for n, s in grid]
    if case.hinge:
        out = [{"model": "ancf", "elements": n, "steps": s} | radius for n, s in CABLE] + out
    elif case.name == "heavy_arm":  # what a chain of bodies would do here
        out.append({"model": "rigid", "elements": 24, "steps": 8} | radius)
    return out


def mujoco(case: Case) -> list[Settings]:
    """Return settings of MuJoCo: Runge–Kutta where nothing is damped much, else implicitfast."""
    plane = {"slender_swing": ["bend_y", "stretch"], "spin_up": ["bend_z", "stretch"]}
    if case.hinge:
        bent = plane[case.name][:1]
        out = [
            {"elements": n, "steps": s, "integrator": "RK4", "strains": bent}
            for n, s in RUNGE_KUTTA
        ]
        out += [
            {"elements": n, "steps": s, "integrator": "RK4", "strains": plane[case.name]}
            for n, s in ((16, 80), (32, 160), (64, 320))
        ]
        return out + [
            {"elements": n, "steps": s, "integrator": "implicitfast", "strains": bent}
            for n, s in ((16, 60), (32, 200))
        ]
    chosen = {"strains": ["bend_z", "stretch", "shear_y"]} if case.name == "heavy_arm" else {}
    return [{"elements": n, "steps": s, "integrator": "implicitfast"} | chosen for n, s in IMPLICIT]
