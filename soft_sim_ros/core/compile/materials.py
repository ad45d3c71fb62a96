"""What the materials of rods, and springs and dampers of joints, are in a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.model.model import Fibres
from soft_sim_ros.core.model.packing import floats, ints

from .chain import Chain
from .stations import flatten_fibres


def of_materials(chain: Chain, seg_block: Ints, fibres: Fibres | None = None) -> dict[str, Any]:
    """Return the fields of Model in which materials and masses are, and nothing else is."""
    law = _sparse_law(chain)
    return {
        "inertia": floats(chain.inertia_with()),
        "law_ptr": law[0],
        "law_col": law[1],
        "stiffness": law[2],
        "damping": law[3],
        "branch": law[4],
        "branch_time": floats(chain.branch_time() if len(law[4]) else []),
        "fibres": flatten_fibres(chain, seg_block) if fibres is None else fibres,
        "mass_damping": floats(
            chain.mass_damping if np.any(chain.mass_damping) else np.zeros((0, 4))
        ),
    }


def _sparse_law(chain: Chain) -> tuple:
    """Return stiffness, damping and branches of all blocks by rows.

    Zeros and round-off are left out. Without any branch, the arrays for branches are empty.
    """
    counts: list[Ints] = [ints([])]
    columns: list[Ints] = [ints([])]
    laws: list[Floats] = [np.zeros((3, 0))]
    for block in chain.blocks:
        matrices = np.stack([block.stiffness, block.damping, block.branch])
        keep = np.zeros(block.stiffness.shape, dtype=bool)
        for matrix in matrices:
            # products of orthogonal functions integrate to round-off, not to zero
            keep |= np.abs(matrix) > 1e-14 * np.sqrt(np.outer(*2 * [np.diag(matrix)]))
        counts.append(keep.sum(axis=1))
        columns.append(block.begin + np.nonzero(keep)[1])
        laws.append(matrices[:, keep])
    stiffness, damping, branch = np.concatenate(laws, axis=1)
    ptr = ints([0, *np.cumsum(np.concatenate(counts)).tolist()])
    branches = floats(branch if branch.any() else [])
    return ptr, ints(np.concatenate(columns)), floats(stiffness), floats(damping), branches
