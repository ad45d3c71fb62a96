"""The stability map as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from .scenes import COMMANDS, SLENDERNESS, STEP, YOUNG

SHARES = (
    ("accurate", "#0072b2", "accurate: inside its own estimate, below 0.1 of the length"),
    ("coarse", "#e69f00", "refused: it says that the step is too long (Inaccurate, EnergyGained)"),
    ("stopped", "#999999", "refused: the solver does not go on (Diverged)"),
    ("wrong", "#d00000", "wrong"),
)


def share(entry: dict[str, Any]) -> str:
    """Return which of SHARES an entry counts for."""
    if entry["outcome"] != "refused":
        return str(entry["outcome"])
    return "stopped" if entry["why"].startswith("Diverged") else "coarse"


def draw(entries: list[dict[str, Any]], file: Path) -> None:
    """Draw, for every command and step, a map of stiffness and slenderness; a cell is a pie."""
    on_grid = [e for e in entries if e["young"] in YOUNG and e["slenderness"] in SLENDERNESS]
    figure, grid = plt.subplots(
        len(COMMANDS), len(STEP), figsize=(13, 9.2), sharex=True, sharey=True, layout="constrained"
    )
    for axes, command in zip(grid, COMMANDS, strict=True):
        for panel, step in zip(axes, STEP, strict=True):
            mine = [e for e in on_grid if e["command"] == command and e["step"] == step]
            _panel(panel, mine)
            if command == COMMANDS[0]:
                panel.set_title(f"step {step:g} s", fontsize=10)
            if step == STEP[0]:
                panel.set_ylabel(command, fontsize=10)
    grid[-1][len(STEP) // 2].set_xlabel("Young's modulus in Pa", fontsize=10)
    figure.supylabel("length / diameter, by command", fontsize=10)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for _, colour, _ in SHARES]
    figure.legend(handles, [text for _, _, text in SHARES], loc="outside lower center", ncols=2,
                  fontsize=9)  # fmt: skip
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _panel(panel: plt.Axes, entries: list[dict[str, Any]]) -> None:
    """Draw one bar of shares per cell."""
    for x, young in enumerate(YOUNG):
        for y, slenderness in enumerate(SLENDERNESS):
            cell = [e for e in entries if e["young"] == young and e["slenderness"] == slenderness]
            left = 0.0
            for name, colour, _ in SHARES:
                part = float(np.mean([share(e) == name for e in cell])) if cell else 0.0
                panel.add_patch(
                    plt.Rectangle((x - 0.46 + 0.92 * left, y - 0.44), 0.92 * part, 0.88,
                                  color=colour, linewidth=0)
                )  # fmt: skip
                left += part
    panel.set_xlim(-0.6, len(YOUNG) - 0.4)
    panel.set_ylim(-0.6, len(SLENDERNESS) - 0.4)
    panel.set_xticks(range(0, len(YOUNG), 3), [f"$10^{{{k}}}$" for k in range(3, 13, 3)])
    panel.set_yticks(range(len(SLENDERNESS)), [f"{s:g}" for s in SLENDERNESS], fontsize=7)
    panel.tick_params(length=2)
