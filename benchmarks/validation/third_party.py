"""The scores of cosseratbench, a benchmark of others that runs this package as a solver.

cosseratbench 0.3 (PyPI, Apache-2.0) judges trajectories against closed forms and accurate numerical
solutions of its own; it does not know who made them. It is one of the packages for tests.
"""

from __future__ import annotations

from typing import Any

# Experiment → its main metric, and the better of the scores of its own adapters for PyElastica and
# MuJoCo at default settings (MuJoCo cannot run twist); None: it has no reference.
KNOWN: dict[str, tuple[str, float | None]] = {
    "cantilever": ("tip_deflection_error", 7.3e-2),
    "catenary": ("shape_error", 4.5e-4),
    "pendulum": ("period_error", 2.9e-5),
    "twist": ("critical_twist_error", 1.1e-2),
    "crossing": ("", 7.8e-4),
    "capstan": ("", None),
    "pile": ("", None),
}
FLOORS = {
    "cantilever": "its reference is linear and without shear: under 1e-3, it says",
    "catenary": "its reference leaves bending out: 4.7e-4 is exact",
    "pendulum": "its reference is linear: 2e-5 at this swing",
    "twist": "its fit is good to 5e-3",
    "crossing": "not looked into", "capstan": "no reference", "pile": "no reference",
}  # fmt: skip


def scores() -> list[dict[str, Any]]:
    """Run everything that cosseratbench has; return one row per experiment."""
    from cosseratbench.experiment import run
    from cosseratbench.registry import load_experiment, load_solver

    solver = load_solver("soft_sim_ros")
    rows = []
    for name, (metric, known) in KNOWN.items():
        result = run(load_experiment(name), solver)
        metrics = {key: float(value) for key, value in result.metrics.items()}
        rows.append({
            "experiment": name, "outcome": result.outcome,
            "missing": list(result.missing), "reason": result.failure, "metric": metric,
            "score": metrics.get(metric), "metrics": metrics, "known": known,
            "floor": FLOORS[name], "wall_s": result.wall_time,
        })  # fmt: skip
    return rows
