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
    """Return settings of PyElastica: elements, and its own clamp or the shifted one."""
    clamps = ("plain",) if case.hinge else ("plain", "shifted")
    counts = (8, 16, 24, 32, 64, 128)
    return [{"elements": n, "clamp": clamp} for n in counts for clamp in clamps]


def soromox(case: Case) -> list[Settings]:
    """Return settings of SoRoMoX: its published model, then refined ones and other solvers.

    Locking shear leaves out its stiffest strains: a physical error near (r/L)² for larger steps.
    """
    out: list[Settings] = []
    published = {"planar_pcs": "planar_pcs", "spatial_pcs": "pcs"}
    if case.name in published:
        model = {"model": published[case.name], "solver": "semi_implicit_euler"}
        out += [model | {"accuracy": step} for step in (5e-5, 2e-5)]
    shears = any("shear" in strain for strain in case.strains)
    for order, steps in ((1, (2e-4, 1e-4, 5e-5)), (2, (1e-4, 5e-5, 2e-5))):
        model = {"model": "gvs", "order": order, "lock_shear": shears}
        out += [model | {"solver": "semi_implicit_euler", "accuracy": step} for step in steps]
    finer = {"model": "gvs", "order": 3}
    out += [finer | {"solver": "tsit5", "accuracy": a} for a in (1e-3, 1e-5)]
    if case.name == "gvs":
        out += [finer | {"solver": "kvaerno5", "accuracy": a} for a in (1e-3, 1e-5)]
    return out
