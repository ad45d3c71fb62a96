"""The scores of cosseratbench, a benchmark of others that runs this package as a solver.

cosseratbench 0.3 (PyPI, Apache-2.0) judges trajectories against closed forms and accurate numerical
solutions of its own; it does not know who made them. It is one of the packages for tests.
"""

from __future__ import annotations

from typing import Any

# What cosseratbench 0.3 gives its own adapters at its default settings; None: it cannot run it.
PUBLISHED = {
    "cantilever": ("tip_deflection_error", "PyElastica, MuJoCo 3", 7.3e-2),
    "catenary": ("shape_error", "PyElastica, MuJoCo 3", 4.5e-4),
    "pendulum": ("period_error", "PyElastica, MuJoCo 3", 2.9e-5),
    "twist": ("critical_twist_error", "PyElastica", 1.1e-2),
    "crossing": ("", "PyElastica, MuJoCo 3", 7.8e-4),
    "capstan": ("", "", None),
    "pile": ("", "", None),
}
FLOORS = {
    "cantilever": "its reference is linear and without shear: under 1e-3, it says",
    "catenary": "its reference leaves bending out: 4.7e-4 is exact",
    "pendulum": "its reference is linear: 2e-5 at this swing",
    "twist": "its fit is good to 5e-3",
    "crossing": "", "capstan": "no reference", "pile": "no reference",
}  # fmt: skip


def scores() -> list[dict[str, Any]]:
    """Run everything that cosseratbench has; return one row per experiment."""
    from cosseratbench.experiment import run
    from cosseratbench.registry import load_experiment, load_solver

    solver = load_solver("soft_sim_ros")
    rows = []
    for name, (metric, who, published) in PUBLISHED.items():
        result = run(load_experiment(name), solver)
        metrics = {key: float(value) for key, value in result.metrics.items()}
        rows.append({
            "experiment": name, "outcome": result.outcome,
            "missing": list(result.missing), "reason": result.failure, "metric": metric,
            "score": metrics.get(metric), "metrics": metrics, "published": published,
            "published_by": who, "floor": FLOORS[name], "wall_s": result.wall_time,
        })  # fmt: skip
    return rows
