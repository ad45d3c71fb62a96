"""The style of pictures: palette, lines, margins."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

# colours that stay apart for colour-blind readers (Okabe and Ito)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#5B5B5B", "#8C564B")
DASHES = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
TIME_COLOURS = "viridis"
INK = "#1d2733"
FAINT = "#d9dee4"
_LARGEST = 1e30  # its square is finite

RC: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#9aa5b1",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 9,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlecolor": INK,
    "figure.facecolor": "white",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "savefig.facecolor": "white",
    "svg.hashsalt": "soft_sim_ros",
    "text.color": INK,
    "text.parse_math": False,  # names come from anywhere, and a $ in them is a $
    "xtick.color": INK,
    "xtick.labelsize": 8,
    "ytick.color": INK,
    "ytick.labelsize": 8,
}


def look(index: int) -> dict:
    """Give colour and dashes of the line with this index: no two of the first 32 are alike."""
    return {
        "color": COLOURS[index % len(COLOURS)],
        "linestyle": DASHES[index // len(COLOURS) % len(DASHES)],
    }


def shown(values: NDArray) -> NDArray:
    """Give numbers that can be drawn: what is not finite, or beyond all reason, becomes a gap."""
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(values) < _LARGEST, values, np.nan)


def thin(time: NDArray, values: NDArray, limit: int = 1500) -> tuple[NDArray, NDArray]:
    """Thin a line (T,) out to about ``limit`` points so that its extremes stay.

    Every stretch of the line is replaced by its lowest and its highest point, in their order.
    """
    values = shown(values)
    if len(time) <= limit:
        return time, values
    edges = np.linspace(0, len(time), limit // 2 + 1).astype(int)
    kept = {0, len(time) - 1}
    for start, stop in itertools.pairwise(edges):
        part = values[start:stop]
        if np.isfinite(part).any():
            kept |= {start + int(np.nanargmin(part)), start + int(np.nanargmax(part))}
    chosen = np.array(sorted(kept))
    return time[chosen], values[chosen]


def stride(count: int, limit: int) -> NDArray:
    """Give at most ``limit`` evenly spread indices below ``count``, the ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, limit)).round().astype(int))
