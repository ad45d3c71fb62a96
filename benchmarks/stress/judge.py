"""Run one case and judge how it ended: accurate, refused, or wrong."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from soft_sim_ros.core.accuracy.estimate import Estimated
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import EnergyGained, Inaccurate, SolverError

from .passivity import Passivity, by_discrete_gradient
from .scenes import LENGTH, STEPS, Case

LIMIT = 0.1  # a run whose estimate is beyond this part of the length is refused
# Energy may be off by this part of all that was turned over, without being from nowhere.
FROM_NOWHERE = 0.1


def judge(case: Case, checked: bool, by_gradient: bool = False) -> dict[str, Any]:
    """Run a case with its own estimate of its error.

    ``checked``: compare it with refined runs; ``by_gradient``: run it by the discrete gradient too.
    """
    begin = time.perf_counter()
    entry: dict[str, Any] = case.as_dict() | {
        "real": case.real(), "outcome": "accurate", "why": None, "time_of_refusal": None,
        "estimate_rel": None, "difference_rel": None, "hidden_rel": None, "gained_rel": None,
        "ledger_gain_rel": None, "passivity_rel": None,
        "error_rel": None, "reference_rel": None,
        "gradient_outcome": None, "gradient_balance_rel": None, "gradient_passivity_rel": None,
    }  # fmt: skip
    pair = passivity = None
    try:
        simulation = Simulation(case.scene())
        sampler = simulation.sampler(2)
        pair, passivity = Estimated(simulation, LIMIT), Passivity(simulation.ledger()[:3])
        tip = np.zeros((STEPS, 3))
        for n, row in enumerate(case.efforts()):
            simulation.set_efforts(row)
            simulation.advance(1)
            ledger = simulation.ledger()
            passivity.look(ledger[:3], float(ledger[3:5].sum()), float(ledger[5]))
            pair.follow(1)
            tip[n] = sampler.poses()[-1, :3]
        if pair.gained_rel > FROM_NOWHERE:
            entry["outcome"], entry["why"] = "wrong", "energy from nowhere"
    except SolverError as error:
        entry["outcome"], entry["why"] = "refused", kind(error)
        entry["time_of_refusal"] = error.time
        checked = False
    if pair is not None:
        entry["estimate_rel"] = pair.error_rel
        for key in ("difference_rel", "hidden_rel", "gained_rel", "ledger_gain_rel"):
            entry[key] = getattr(pair, key)
    if passivity is not None:
        entry["passivity_rel"] = passivity.rel
    if by_gradient:
        entry |= by_discrete_gradient(case)
    if checked:
        entry |= compare(case, tip)
        # a reference is known no better than by its own refinement
        known = entry["reference_rel"] or 0.0
        if (entry["error_rel"] or 0.0) > entry["estimate_rel"] + known:
            entry["outcome"], entry["why"] = "wrong", "error beyond the estimate"
    return entry | {"wall_s": time.perf_counter() - begin}


def kind(error: SolverError) -> str:
    """Return an error's name and reason without its numbers."""
    numbers = isinstance(error, (Inaccurate, EnergyGained))
    return type(error).__name__ + ("" if numbers else f": {error.reason}")


def compare(case: Case, tip: Floats) -> dict[str, Any]:
    """Return the largest error of the tip, and how well the reference is known."""
    # the slowest vibration in at least 600 steps if that is not too many
    pieces = 40 if case.omega * case.step < 0.4 else 1000
    try:
        coarse, fine = (refined(case, count) for count in (pieces // 4, pieces))
    except SolverError as error:
        return {"why": f"reference: {error.reason}"}
    return {"error_rel": distance(tip, fine), "reference_rel": distance(coarse, fine)}


def refined(case: Case, pieces: int) -> Floats:
    """Return the tip (STEPS, 3) of a run with every step cut into pieces, at the same commands."""
    simulation = Simulation(case.scene(pieces))
    sampler = simulation.sampler(2)
    tip = np.zeros((STEPS, 3))
    for n, row in enumerate(case.efforts()):
        simulation.set_efforts(row)
        simulation.advance(pieces)
        tip[n] = sampler.poses()[-1, :3]
    return tip


def distance(a: Floats, b: Floats) -> float:
    """Return the largest distance of two tips over the length."""
    return float(np.linalg.norm(a - b, axis=1).max()) / LENGTH
