"""What a step costs: percentiles of the last second, histogram and worst of the whole run."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

# 10 bins per decade from 100 ns to 10 s, and one below and above.
EDGES_NS = np.logspace(2.0, 10.0, 8 * 10 + 1)


class Window(NamedTuple):
    """Costs of the steps since the last look, in ns per step; nan without any."""

    steps: int
    p50: float
    p99: float
    worst: float


class StepCosts:
    """Filled by the physics thread, read by anyone else (one reader)."""

    def __init__(self) -> None:
        self._fresh: deque[tuple[int, int, int]] = deque()
        self.histogram = np.zeros(len(EDGES_NS) + 1, dtype=np.int64)
        self.steps = 0
        self.total_ns = 0
        self.worst_ns = 0.0
        self.worst_time_ns = 0

    def add(self, steps: int, cost_ns: int, time_ns: int) -> None:
        """Note that ``steps`` up to simulation time ``time_ns`` cost ``cost_ns`` of real time."""
        self._fresh.append((steps, cost_ns, time_ns))

    def look(self) -> Window:
        """Percentiles of what came since the last call, which also goes into the totals."""
        fresh = [self._fresh.popleft() for _ in range(len(self._fresh))]
        if not fresh:
            return Window(0, np.nan, np.nan, np.nan)
        steps, cost, time_ns = np.array(fresh, dtype=np.int64).T
        per_step = cost / steps
        np.add.at(self.histogram, np.searchsorted(EDGES_NS, per_step), steps)
        self.steps += int(steps.sum())
        self.total_ns += int(cost.sum())
        worst = int(per_step.argmax())
        if per_step[worst] > self.worst_ns:
            self.worst_ns, self.worst_time_ns = float(per_step[worst]), int(time_ns[worst])
        p50, p99 = np.percentile(np.repeat(per_step, steps), (50, 99))
        return Window(int(steps.sum()), float(p50), float(p99), float(per_step[worst]))

    def _percentile(self, share: float) -> float | None:
        """Cost in µs that a share of all steps stays below, interpolated inside its bin."""
        if not self.steps:
            return None
        counts = np.cumsum(self.histogram)
        bin = int(np.searchsorted(counts, share * self.steps))
        if bin == 0 or bin == len(EDGES_NS):
            return EDGES_NS[min(bin, len(EDGES_NS) - 1)] * 1e-3
        low, high = EDGES_NS[bin - 1] * 1e-3, EDGES_NS[bin] * 1e-3
        before = counts[bin] - self.histogram[bin]
        part = (share * self.steps - before) / self.histogram[bin]
        return float(low * (high / low) ** part)

    def summary(self) -> dict:
        """Totals as plain numbers: µs per step, and the bins that are not empty."""
        self.look()
        filled = np.flatnonzero(self.histogram)
        edges = np.concatenate([[0.0], EDGES_NS, [np.inf]]) * 1e-3
        return {
            "steps": self.steps,
            "mean_us": self.total_ns / self.steps * 1e-3 if self.steps else None,
            "p50_us": self._percentile(0.50),
            "p99_us": self._percentile(0.99),
            "worst_us": self.worst_ns / 1e3,
            "worst_at_s": self.worst_time_ns / 1e9,
            "histogram": [
                {
                    "from_us": round(float(edges[i]), 3),
                    "to_us": _finite(round(float(edges[i + 1]), 3)),
                    "steps": int(self.histogram[i]),
                }
                for i in filled
            ],
        }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
