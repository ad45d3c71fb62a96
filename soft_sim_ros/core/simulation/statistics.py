"""Counters of the solver."""

from typing import NamedTuple


class Statistics(NamedTuple):
    """Counters since construction.

    steps : steps of the method: those of the grid or pieces of them, or its own
    evaluations : of the residual (nfev elsewhere)
    factorisations : of the Newton matrix, each after a tangent (njev, nlu)
    iterations : of Newton's method
    refused : steps that failed and were tried again smaller
    rejected : steps of the adaptive method whose error was too large
    """

    steps: int
    evaluations: int
    factorisations: int
    iterations: int
    refused: int
    rejected: int
