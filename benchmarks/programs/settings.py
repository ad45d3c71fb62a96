"""What every program is run with on a case, cheap settings first."""

from __future__ import annotations

from typing import Any

from ..cases import Case

Settings = dict[str, Any]

# (order, elements, nodes or None, step as a share of the output period, integrator)
OURS = (
    (1, 1, None, 1 / 2, "sdirk2"),
    (1, 1, None, 1 / 5, "generalized_alpha"),
    (2, 1, None, 1 / 2, "sdirk2"),
    (2, 1, None, 1 / 5, "sdirk2"),
    (2, 1, None, 1 / 5, "generalized_alpha"),
    (2, 1, None, 1 / 10, "generalized_alpha"),
    (3, 1, None, 1 / 2, "sdirk3"),
    (3, 1, None, 1 / 5, "sdirk3"),
    (3, 1, 8, 1 / 2, "sdirk4"),
    (3, 1, 8, 1 / 5, "sdirk4"),
    (3, 2, 8, 1 / 5, "sdirk4"),
    (4, 2, 10, 1 / 10, "sdirk4"),
    (4, 1, 10, 1 / 5, "sdirk3"),
    (4, 1, 12, 1 / 5, "sdirk4"),
    (4, 1, 12, 1 / 20, "sdirk4"),
    (5, 1, 16, 1 / 5, "sdirk4"),
    (5, 1, 16, 1 / 20, "sdirk4"),
    (5, 2, 16, 1 / 20, "sdirk4"),
    (6, 1, 24, 1 / 10, "sdirk4"),
    (6, 2, 20, 1 / 20, "sdirk4"),
    (8, 1, 30, 1 / 20, "sdirk4"),
    (8, 1, 30, 1 / 50, "sdirk4"),
)


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
    """Return settings of this package: orders, nodes, steps and integrators."""
    out: list[Settings] = []
    if case.name in ("planar_pcs", "spatial_pcs"):  # the published model, matched on purpose
        coarse = {"kind": "constant", "nodes": 8, "integrator": "sdirk2"}
        steps = (_dividing(case, case.output_period * share) for share in (1 / 2, 1 / 10))
        out += [coarse | {"step": step} for step in steps]
    for order, elements, nodes, share, integrator in OURS:
        step = _dividing(case, case.output_period * share)
        settings = {"order": order, "elements": elements, "step": step, "integrator": integrator}
        out.append(settings | ({"nodes": nodes} if nodes else {}))
    return [s for i, s in enumerate(out) if s not in out[:i]]


def _dividing(case: Case, step: float) -> float:
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

    Semi-implicit Euler runs at its largest stable step and at half of it; Tsit5 and Kvaerno5 adapt
    theirs. Locking shear leaves out the stiffest strains: a physical error near (r/L)² for larger
    steps.
    """
    out: list[Settings] = []
    published = {"planar_pcs": "planar_pcs", "spatial_pcs": "pcs"}
    euler = {"solver": "semi_implicit_euler"}
    if case.name in published:
        out += [{"model": published[case.name]} | euler | {"fraction": f} for f in (1.0, 0.5)]
    strains = plane_of(case)
    shears = any("shear" in strain for strain in strains.get("strains", case.strains))
    for order in (1, 2):
        model = {"model": "gvs", "order": order, "lock_shear": shears} | strains
        out += [model | euler | {"fraction": f} for f in (1.0, 0.5)]
    finer = {"model": "gvs", "order": 3} | strains
    out += [finer | euler | {"fraction": f} for f in (1.0, 0.5)]
    out += [{"model": "gvs", "order": 2} | strains | {"solver": "kvaerno5", "accuracy": 1e-4}]
    out += [finer | {"solver": "tsit5", "accuracy": 1e-5}]
    return out
