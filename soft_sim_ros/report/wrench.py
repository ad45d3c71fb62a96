"""The internal wrench along the arm, with its jumps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from soft_sim_ros.report.page import drawn
from soft_sim_ros.report.style import look
from soft_sim_ros.scene.taper import Floats

if TYPE_CHECKING:
    from soft_sim_ros.core.compile.scene import Compiled
    from soft_sim_ros.core.mechanics.wrench import InternalWrench

MOMENTS = ("torsion moment M_x", "bending moment M_y", "bending moment M_z")
FORCES = ("axial force N_x", "shear force N_y", "shear force N_z")


def internal_wrench(limbs: Mapping[str, InternalWrench]) -> Figure:
    """Draw moment and force in section axes over arc length; jumps are upright lines.

    Parameters
    ----------
    limbs : what is drawn side by side, by name; one alone is called ``""``
    """
    figure = Figure(figsize=(5.0 + 5.0 * len(limbs), 5.5), layout="constrained")
    columns = figure.subplots(2, len(limbs), sharex="col", sharey="row", squeeze=False).T
    for (limb, wrench), (upper, lower) in zip(limbs.items(), columns, strict=True):
        s = np.repeat(wrench.s, 2)
        values = np.stack([wrench.before, wrench.after], axis=1).reshape(-1, 6)
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


def wrench_picture(limbs: Mapping[str, InternalWrench], path: str | Path) -> Path:
    """Write one PNG of internal wrenches, as ``internal_wrench`` draws them."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(drawn(lambda: internal_wrench(limbs), "png"))
    return path


def by_backbone(
    compiled: Compiled, wrench: InternalWrench, poses: Floats
) -> dict[str, InternalWrench]:
    """Return the wrench along each backbone by its name; all of it where there is only one.

    Where another branch leaves, what that one carries is not part of ``after``: there is a jump.

    Parameters
    ----------
    compiled : the arm
    wrench : of all nodes
    poses : (N, 4, 4) of all nodes, in any frame
    """
    branches = compiled.chain.branches
    if len(branches) == 1:
        return {"": wrench}
    after = wrench.after.copy()
    for branch in branches[1:]:
        node = branch.first_node
        origin = compiled.chain.segments[node - 1].origin
        step = np.linalg.inv(poses[origin]) @ poses[node]
        moment, force = (step[:3, :3] @ part for part in wrench.before[node].reshape(2, 3))
        after[origin] -= np.concatenate([moment + np.cross(step[:3, 3], force), force])
    found = {}
    for name, branch in compiled.backbones.items():
        nodes = slice(branch.first_node, branch.last_node + 1)
        found[name] = wrench._replace(
            s=wrench.s[nodes], before=wrench.before[nodes], after=after[nodes]
        )
    return found or {"": wrench}
