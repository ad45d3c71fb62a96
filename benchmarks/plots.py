"""Work–precision diagrams: error on x, wall time on y; one picture per case and one of all."""

from __future__ import annotations

import json

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

from . import fronts
from .cases import CASES
from .reference import RESULTS

STYLE = {
    "soft_sim_ros": ("#0072b2", "o", "soft_sim_ros"),
    "pyelastica": ("#d55e00", "s", "PyElastica 1.0.0"),
    "soromox": ("#009e73", "^", "SoRoMoX 0.5.0"),
    "exudyn": ("#cc79a7", "D", "Exudyn 1.13.6"),
    "mujoco": ("#e69f00", "v", "MuJoCo 4.0.0"),
}


def draw(axes: plt.Axes, entries: fronts.Entries, case: str, small: bool = False) -> None:
    """Draw one case: every completed run, and the line through the best ones."""
    missing = []
    for program, (colour, marker, label) in STYLE.items():
        mine = fronts.of(entries, case, program)
        done = [e for e in mine if e["outcome"] == "completed" and e["error_rel"]]
        if not done:
            if mine:
                outcomes = "/".join(sorted({e["outcome"] for e in mine}))
                missing.append(f"{label}: {outcomes}")
            continue
        x, y = [e["error_rel"] for e in done], [fronts.cost(e) for e in done]
        axes.loglog(x, y, marker, color=colour, alpha=0.45, markersize=4 if small else 6)
        best = fronts.front(mine)
        axes.loglog(*zip(*best, strict=True), "-", color=colour, label=label, linewidth=1.5)
    agreement = [e["reference_agreement"] for e in entries if e["case"] == case]
    axes.set_xlim(1e-8, 1.0)
    if agreement:
        axes.axvspan(1e-8, max(agreement[0], 1e-8), color="0.9", zorder=0)
    axes.grid(True, which="major", alpha=0.3)
    if missing:
        axes.text(0.02, 0.03, "\n".join(missing), transform=axes.transAxes, fontsize=7)
    axes.set_title(case if small else CASES[case].title, fontsize=9)


def main() -> None:
    """Draw everything there is."""
    file = RESULTS / "work_precision.json"
    if not file.is_file():
        return
    entries = json.loads(file.read_text())
    cases = [case for case in CASES if any(e["case"] == case for e in entries)]
    for case in cases:
        figure, axes = plt.subplots(figsize=(6.0, 4.5), layout="constrained")
        draw(axes, entries, case)
        axes.set_xlabel("largest tip error over the run / length (grey: not resolved)")
        axes.set_ylabel("time in s (one core)")
        axes.legend(fontsize=8)
        figure.savefig(RESULTS / f"work_precision_{case}.png", dpi=110)
        plt.close(figure)
    rows = (len(cases) + 2) // 3
    figure, grid = plt.subplots(
        rows, 3, figsize=(12, 3.1 * rows), layout="constrained", squeeze=False, sharex=True
    )
    for axes, case in zip(grid.flat, cases, strict=False):
        draw(axes, entries, case, small=True)
    for axes in grid.flat[len(cases) :]:
        axes.set_visible(False)
    for axes in grid.flat[max(len(cases) - 3, 0) : len(cases)]:  # the last one of every column
        axes.tick_params(labelbottom=True)
    grid.flat[0].legend(fontsize=8)
    figure.supxlabel("largest tip error over the run / length (grey: not resolved)")
    figure.supylabel("time in s (one core)")
    figure.savefig(RESULTS / "work_precision.png", dpi=110)
    plt.close(figure)
    scaling()
    convergence()


def convergence() -> None:
    """Draw error against coordinates, one panel per case."""
    file = RESULTS / "convergence.json"
    if not file.is_file():
        return
    rows = json.loads(file.read_text())["rows"]
    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure, grid = plt.subplots(
        1, len(cases), figsize=(5.4 * len(cases), 4.5), layout="constrained", sharey=True
    )
    for axes, case in zip(grid, cases, strict=True):
        for basis, marker in zip(dict.fromkeys(r["basis"] for r in rows), "o+x^sDv", strict=False):
            mine = [row for row in rows if (row["case"], row["basis"]) == (case, basis)]
            x, y = [r["coordinates"] for r in mine], [r["error_rel"] for r in mine]
            axes.loglog(x, y, marker + "-", label=basis, markersize=5, linewidth=1.0)
        axes.set_title(CASES[case].title, fontsize=9)
        axes.set_xlabel("number of coordinates")
        axes.grid(True, which="major", alpha=0.3)
    grid[0].set_ylabel("largest tip error over the run / length")
    grid[0].legend(fontsize=8)
    figure.savefig(RESULTS / "convergence.png", dpi=110)
    plt.close(figure)


def scaling() -> None:
    """Draw cost per step against elements."""
    file = RESULTS / "scaling.json"
    if not file.is_file():
        return
    kept = json.loads(file.read_text())
    figure, axes = plt.subplots(figsize=(6.0, 4.5), layout="constrained")
    for name, fit in kept["exponents"].items():
        rows = [row for row in kept["rows"] if row["program"] == name]
        x = [row["elements"] for row in rows]
        y = [row["wall_s_per_step"] * 1e6 for row in rows]
        step = rows[-1]["step"]
        label = f"{name}: n^{fit['all']:.2f} (step {step:.1e} s at {x[-1]})"
        axes.loglog(x, y, "o-", label=label)
    axes.set_xlabel("elements")
    axes.set_ylabel("CPU time per step in µs (one core)")
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(RESULTS / "scaling.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
