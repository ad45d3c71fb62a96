"""The internal wrench along the arm, with its jumps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from soft_sim_ros.report.page import drawn
from soft_sim_ros.report.style import look

if TYPE_CHECKING:
    from soft_sim_ros.core.mechanics.wrench import InternalWrench

MOMENTS = ("torsion moment M_x", "bending moment M_y", "bending moment M_z")
FORCES = ("axial force N_x", "shear force N_y", "shear force N_z")


def internal_wrench(wrench: InternalWrench) -> Figure:
    """Draw moment and force in section axes over arc length; jumps are upright lines."""
    figure = Figure(figsize=(10.0, 5.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    s = np.repeat(wrench.s, 2)
    values = np.stack([wrench.before, wrench.after], axis=1).reshape(-1, 6)
    # beyond the tip there is nothing, and before the base there is no rod
    s, values = s[1:-1], values[1:-1]
    for axes, names, first in ((upper, MOMENTS, 0), (lower, FORCES, 3)):
        for i, name in enumerate(names):
            axes.plot(s, values[:, first + i], label=name, **look(i))
        axes.legend(loc="best")
    upper.set(title="Internal moment", ylabel="N·m")
    lower.set(title="Internal force", ylabel="N", xlabel="arc length (m)")
    return figure


def wrench_picture(wrench: InternalWrench, path: str | Path) -> Path:
    """Write one PNG of an internal wrench."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(drawn(lambda: internal_wrench(wrench), "png"))
    return path
