"""Pictures of the comparisons, into benchmarks/results."""

from __future__ import annotations

from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from ..reference import RESULTS
from . import vu_quoc
from .bank import LENGTH, Floats, Release

OURS, THEIRS, PRINTED = "#0072b2", "#d55e00", "0.35"


def keep(figure: plt.Figure, name: str) -> None:
    """Write a picture."""
    figure.savefig(RESULTS / f"validation_{name}.png", dpi=110)
    plt.close(figure)


def release(release: Release, tip: Floats) -> None:
    """Draw the tip of one release."""
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(7.0, 5.0), layout="constrained", sharex=True, height_ratios=(2, 1)
    )
    for k, axis in enumerate("xyz"):
        label = {"label": "SoRoSim"} if k == 0 else {}
        above.plot(release.times, release.tip[:, k], color=THEIRS, linewidth=3, alpha=0.5, **label)
        label = {"label": "soft_sim_ros"} if k == 0 else {}
        above.plot(release.times, tip[:, k], color=OURS, linewidth=1, **label)
        above.annotate(axis, (release.times[0], tip[0, k]))
    above.set_ylabel("tip in m")
    above.legend(fontsize=8)
    gap = np.linalg.norm(tip - release.tip, axis=1) / LENGTH
    below.semilogy(release.times, np.maximum(gap, 1e-6), color=OURS, linewidth=1)
    below.set_ylabel("distance / length")
    below.set_xlabel("time in s")
    above.set_title(f"A rod of TPU is let go: {release.name}", fontsize=9)
    keep(figure, "release")


def elbow(mine: Floats, theirs: Floats) -> None:
    """Draw corner and tip of the elbow."""
    times = np.linspace(0.0, float(vu_quoc.LOADED["duration"]), len(mine))
    figure, panels = plt.subplots(2, 1, figsize=(7.0, 5.5), layout="constrained", sharex=True)
    for k, (axes, (name, printed)) in enumerate(
        zip(panels, vu_quoc.digitised().items(), strict=True)
    ):
        axes.plot(times, theirs[:, k, 2], color=THEIRS, linewidth=3, alpha=0.5, label="Exudyn")
        axes.plot(times, mine[:, k, 2], color=OURS, linewidth=1, label="soft_sim_ros")
        axes.plot(*printed, ".", color=PRINTED, markersize=4, label="Simo, Vu-Quoc 1988, printed")
        axes.set_ylabel(f"{name}, out of the plane")
        axes.grid(alpha=0.3)
    panels[0].legend(fontsize=8)
    panels[1].set_xlabel("time")
    keep(figure, "elbow")


def statics(found: dict[str, Any]) -> None:
    """Draw how the differences to SoRoSim's shapes are distributed."""
    figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
    errors = np.array(list(found["errors"].values()))
    bins = np.geomspace(1e-8, 2e-3, 60)
    axes.hist(errors, bins, color=THEIRS, alpha=0.6, label=f"{len(errors)} shapes, ours to theirs")
    ours = [row["ours"] for row in found["checked"]]
    axes.hist(ours, bins, color=OURS, label=f"{len(ours)} shapes, ours to the boundary problem")
    axes.set_xscale("log")
    axes.set_xlabel("largest distance / length")
    axes.set_ylabel("shapes")
    axes.legend(fontsize=8)
    keep(figure, "statics")


def princeton(found: dict[str, Any]) -> None:
    """Draw the tips of the Princeton beam."""
    figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
    for force in dict.fromkeys(row["force_N"] for row in found["rows"]):
        rows = [row for row in found["rows"] if row["force_N"] == force]
        label = {"label": "soft_sim_ros"} if force == found["rows"][0]["force_N"] else {}
        axes.plot(*1e3 * np.array([row["own"] for row in rows]).T, "-", color=OURS, **label)
        for name, marker, colour in (("ansys_beam", "o", THEIRS), ("ansys_solid", "x", PRINTED)):
            label = {"label": name.replace("_", ", ").replace("ansys", "ANSYS")} if label else {}
            axes.plot(*1e3 * np.array([row[name] for row in rows]).T, marker, color=colour,
                      fillstyle="none", **label)  # fmt: skip
        axes.annotate(f"{force:g} N", 1e3 * np.array(rows[3]["own"]), fontsize=8)
    axes.set_xlabel("tip along the width in mm")
    axes.set_ylabel("tip along the thickness in mm")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    keep(figure, "princeton")


def main(kept: dict[str, Any]) -> None:
    """Draw what can be drawn from the numbers kept."""
    for name, draw in (("sorosim_statics", statics), ("princeton", princeton)):
        if name in kept:
            draw(kept[name]["found"])
