"""What every program is run with on a case, cheap settings first."""

from __future__ import annotations

from typing import Any

from ..cases import Case
from .settings_engines import exudyn, mujoco

__all__ = ["exudyn", "mujoco", "ours", "plane_of", "pyelastica", "soromox"]

Settings = dict[str, Any]

# `adaptive`: (order, elements per section, nodes per element, options.error), about cheap first
CLAMPED = (
    (1, 1, 4, 1e-3), (1, 2, 4, 1e-3), (2, 1, 5, 1e-3), (2, 2, 5, 1e-3), (3, 1, 8, 1e-3),
    (2, 2, 5, 1e-4), (2, 3, 5, 1e-4), (3, 1, 8, 1e-4), (3, 1, 8, 1e-5), (3, 2, 6, 1e-5),
    (3, 3, 6, 1e-5), (5, 1, 12, 1e-5), (5, 1, 16, 1e-6), (4, 2, 10, 1e-6), (3, 4, 6, 1e-6),
    (3, 6, 6, 1e-6), (4, 4, 8, 1e-6), (6, 2, 14, 1e-7), (4, 6, 8, 1e-7),
)  # fmt: skip
SECTIONS = (
    (1, 1, 4, 1e-3), (2, 1, 5, 1e-3), (2, 1, 5, 1e-4), (3, 1, 6, 1e-4), (3, 1, 8, 1e-5),
    (2, 2, 5, 1e-5), (4, 1, 10, 1e-5), (4, 1, 10, 1e-6), (3, 2, 6, 1e-6), (5, 1, 12, 1e-6),
    (5, 1, 14, 1e-7), (6, 1, 18, 1e-8),
)  # fmt: skip
HINGED = (
    (2, 1, 5, 1e-3), (3, 1, 6, 1e-4), (2, 2, 5, 1e-3), (2, 2, 5, 1e-4), (3, 2, 6, 1e-4),
    (2, 4, 5, 1e-4), (3, 3, 6, 1e-5), (3, 4, 6, 1e-5), (3, 6, 6, 1e-5), (3, 6, 6, 1e-6),
    (3, 8, 6, 1e-6), (4, 8, 8, 1e-6), (4, 8, 8, 1e-7), (6, 8, 12, 1e-8),
)  # fmt: skip
CHIRP = ((1, 2, 4, 1e-3), (2, 2, 5, 1e-4), (2, 3, 5, 1e-5), (3, 3, 6, 1e-6))
# fixed steps: (order, elements, nodes, step as a share of the output period, integrator)
FIXED = (
    (2, 1, 5, 1 / 10, "generalized_alpha"), (2, 1, 5, 1 / 5, "sdirk2"), (3, 1, 8, 1 / 5, "sdirk3"),
    (4, 1, 10, 1 / 5, "sdirk4"), (5, 1, 16, 1 / 10, "sdirk4"),
)  # fmt: skip
JUMPING = (
    (1, 1, 4, 1 / 4, "sdirk2"), (2, 1, 5, 1 / 4, "generalized_alpha"), (2, 1, 5, 1 / 4, "sdirk2"),
    (1, 2, 4, 1 / 4, "sdirk3"), (2, 1, 5, 1 / 8, "generalized_alpha"), (2, 1, 5, 1 / 4, "sdirk3"),
    (2, 1, 5, 1 / 8, "sdirk2"), (2, 1, 5, 1 / 8, "sdirk3"), (2, 2, 5, 1 / 4, "sdirk3"),
    (2, 2, 5, 1 / 8, "sdirk3"), (3, 1, 8, 1 / 16, "sdirk3"), (3, 2, 6, 1 / 20, "sdirk3"),
    (2, 3, 5, 1 / 40, "sdirk3"), (3, 3, 6, 1 / 40, "sdirk4"), (3, 3, 6, 1 / 80, "sdirk3"),
)  # fmt: skip
# Simulations that choose everything but their inputs' grid themselves.
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)


PLANES = {
    "heavy_arm": ("bend_z", "stretch", "shear_y"),
    "slender_swing": ("bend_y", "stretch", "shear_z"),
    "spin_up": ("bend_z", "stretch", "shear_y"),
}


def plane_of(case: Case) -> Settings:
    """Return the strains that a planar case needs, as settings; nothing for other cases.

    Loads and gravity of these cases lie in a plane: whoever writes the scene sees it, and the
    solution is the same. SoRoMoX is given the same; PyElastica cannot lock strains.
    """
    return {"strains": list(PLANES[case.name])} if case.name in PLANES else {}


def ours(case: Case) -> list[Settings]:
    """Return settings of this package: bases, integrators, steps."""
    out: list[Settings] = []
    adaptive = {"step": dividing(case, case.output_period), "integrator": "adaptive"}
    if case.name in ("planar_pcs", "spatial_pcs"):  # the published model, matched on purpose
        coarse = {"kind": "constant", "nodes": 8} | adaptive
        out += [coarse | {"options": {"error": error}} for error in (1e-3, 1e-6)]
    jumping = case.moments is not None and len(case.moments.values) > 1
    rows = SECTIONS if len(case.sections) > 1 else CLAMPED
    rows = HINGED if case.hinge else CHIRP if jumping else rows
    for order, elements, nodes, error in rows:
        basis = {"order": order, "elements": elements, "nodes": nodes}
        out.append(basis | adaptive | {"options": {"error": error}} | plane_of(case))
        if case.hinge:  # slender: shear matters no more than for a peer without it
            slender = [strain for strain in PLANES[case.name] if "shear" not in strain]
            out.append(out[-1] | {"strains": slender})
    if plane_of(case):  # one with what the plane does not need, to show that it does not
        out.append({key: value for key, value in out[len(out) // 2].items() if key != "strains"})
    for order, elements, nodes, share, integrator in JUMPING if jumping else FIXED:
        basis = {"order": order, "elements": elements, "nodes": nodes}
        step = dividing(case, case.output_period * share)
        out.append(basis | {"step": step, "integrator": integrator} | plane_of(case))
    grid = {"step": adaptive["step"]} | plane_of(case)
    return out + [{"tolerance": tolerance} | grid for tolerance in TOLERANCES]


def dividing(case: Case, step: float) -> float:
    """Return the largest whole-nanosecond step up to ``step`` that divides all periods.

    Commands are held, so a step has to end where they change.
    """
    periods = [case.output_period] + ([case.moments.period] if case.moments else [])
    pieces = 1
    shortest = round(min(periods) * 1e9)
    while True:
        candidate, rest = divmod(shortest, pieces)
        divides = all(round(p * 1e9) % candidate == 0 for p in periods)
        if rest == 0 and divides and candidate <= step * 1e9 * (1 + 1e-9):
            return candidate * 1e-9
        pieces += 1


def pyelastica(case: Case) -> list[Settings]:
    """Return settings of PyElastica: elements, and its own clamp or the shifted one.

    Its own clamp converges with the first order only; two runs show it.
    """
    counts = (8, 16, 24, 32, 48, 64, 96, 128, 192, 256)
    if case.hinge:
        return [{"elements": n, "clamp": "plain"} for n in counts]
    out: list[Settings] = [{"elements": n, "clamp": "plain"} for n in (8, 16)]
    return out + [{"elements": n, "clamp": "shifted"} for n in counts]


def soromox(case: Case) -> list[Settings]:
    """Return settings of SoRoMoX: its published model, then strains of rising order.

    Semi-implicit Euler runs at its largest stable step, and at half of it to show what the step
    does. Locking shear leaves out the stiffest strains: an error of a few (r/L)² for larger steps.
    Tsit5 and Kvaerno5 adapt their steps; the implicit one has its chance where the coordinates are
    few, elsewhere compiling it alone takes longer than all the others.
    """
    out: list[Settings] = []
    published = {"planar_pcs": "planar_pcs", "spatial_pcs": "pcs"}
    euler = {"solver": "semi_implicit_euler"}
    if case.name in published:
        out += [{"model": published[case.name]} | euler | {"fraction": 1.0}]
    strains = plane_of(case)
    free = strains.get("strains", case.strains)
    model = {"model": "gvs"} | strains
    if any("shear" in strain for strain in free):
        locked = model | {"lock_shear": True}
        # on hinges rods are slender: shear matters little, and high orders stay affordable
        orders = (1, 2, 3, 4, 6) if case.hinge else (1, 2)
        out += [locked | {"order": order} | euler | {"fraction": 1.0} for order in orders]
    else:
        out += [model | {"order": 1} | euler | {"fraction": 1.0}]
    for order in (2, 3):
        out += [model | {"order": order} | euler | {"fraction": f} for f in (1.0, 0.5)]
    if len(free) == 3:
        out += [model | {"order": 2, "solver": "kvaerno5", "accuracy": a} for a in (1e-3, 1e-5)]
    return [*out, model | {"order": 3, "solver": "tsit5", "accuracy": 1e-5}]
