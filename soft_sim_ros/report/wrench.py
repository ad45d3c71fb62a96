"""The internal wrench along the arm, with its jumps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from soft_sim_ros.report.page import drawn
from soft_sim_ros.report.style import look

if TYPE_CHECKING:
    from soft_sim_ros.core.compile.scene import Compiled
    from soft_sim_ros.core.mechanics.wrench import InternalWrench

MOMENTS = ("torsion moment M_x", "bending moment M_y", "bending moment M_z")
WHOLE = {"": slice(None)}
FORCES = ("axial force N_x", "shear force N_y", "shear force N_z")


def internal_wrench(wrench: InternalWrench, limbs: Mapping[str, slice] = WHOLE) -> Figure:
    """Draw moment and force in section axes over arc length; jumps are upright lines.

    Parameters
    ----------
    wrench : of all nodes
    limbs : name → nodes of what is drawn side by side
    """
    figure = Figure(figsize=(5.0 + 5.0 * len(limbs), 5.5), layout="constrained")
    columns = figure.subplots(2, len(limbs), sharex="col", sharey="row", squeeze=False).T
    for (limb, nodes), (upper, lower) in zip(limbs.items(), columns, strict=True):
        s = np.repeat(wrench.s[nodes], 2)
        values = np.stack([wrench.before[nodes], wrench.after[nodes]], axis=1).reshape(-1, 6)
        # beyond the tip there is nothing, and before the base there is no rod
        s, values = s[1:-1], values[1:-1]
        for axes, names, first in ((upper, MOMENTS, 0), (lower, FORCES, 3)):
            for i, name in enumerate(names):
                axes.plot(s, values[:, first + i], label=name, **look(i))
            axes.legend(loc="best")
        of = f" of {limb}" if limb else ""
        upper.set(title=f"Internal moment{of}", ylabel="N·m")
        lower.set(title=f"Internal force{of}", ylabel="N", xlabel="arc length (m)")
    return figure


def wrench_picture(
    wrench: InternalWrench, path: str | Path, limbs: Mapping[str, slice] = WHOLE
) -> Path:
    """Write one PNG of an internal wrench; ``limbs`` as for ``internal_wrench``."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(drawn(lambda: internal_wrench(wrench, limbs), "png"))
    return path


def limbs_drawn(compiled: Compiled) -> Mapping[str, slice]:
    """Return the nodes of every backbone by its name; all of them where there is only one."""
    branches = compiled.backbones
    if len(compiled.chain.branches) == 1 or not branches:
        return WHOLE
    return {name: slice(b.first_node, b.last_node + 1) for name, b in branches.items()}
