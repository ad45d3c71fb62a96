"""What the entries say: the cheapest run for every error, and the cost at a given error."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

Entries = list[dict[str, Any]]


def cost(entry: dict[str, Any]) -> float:
    """Return the CPU time in s where there is one, else the wall time.

    Everything runs on one core: on an idle machine the two are the same, on a shared one the CPU
    time says what the wall time would have been.
    """
    return float(entry.get("cpu_s") or entry["wall_s"])


def front(entries: Entries) -> list[tuple[float, float]]:
    """Return (error, s) of the runs that no other run beats in both, error falling."""
    points = sorted(
        (cost(e), e["error_rel"]) for e in entries if e["outcome"] == "completed" and e["error_rel"]
    )
    out: list[tuple[float, float]] = []
    for wall, error in points:
        if not out or error < out[-1][0]:
            out.append((error, wall))
    return out


def cost_at(entries: Entries, error: float) -> float | None:
    """Return the time in s at an error, between runs by straight lines in the logarithms.

    None where no run gets there. Where the cheapest run is better already, its cost counts.
    """
    points = front(entries)
    if not points or points[-1][0] > error:
        return None
    if points[0][0] <= error:
        return points[0][1]
    for (e0, w0), (e1, w1) in itertools.pairwise(points):
        if e1 <= error < e0:
            share = np.log(e0 / error) / np.log(e0 / e1)
            return float(np.exp(np.log(w0) + share * np.log(w1 / w0)))
    return None


def beyond(entries: Entries, error: float) -> float | None:
    """Return the time in s at an error that no run reaches, by the order of the best runs.

    The order is that of the line through the runs of the front within a decade of its end; None
    where that is fewer than two runs, where it is below one half or above six, or where the error
    is more than a hundred times smaller than the least.
    """
    points = front(entries)
    if not points or not points[-1][0] > error > 0.01 * points[-1][0]:
        return None
    near = np.log([point for point in points if point[0] <= 10.0 * points[-1][0]])
    if len(near) < 2:
        return None
    slope = float(np.polyfit(near[:, 0], near[:, 1], 1)[0])
    if not -2.0 < slope < -1.0 / 6.0:
        return None
    return float(np.exp(near[-1, 1] + slope * (np.log(error) - near[-1, 0])))


def of(entries: Entries, case: str, program: str) -> Entries:
    """Return the entries of one program on one case."""
    return [e for e in entries if e["case"] == case and e["program"] == program]
