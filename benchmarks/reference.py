"""References: two refined, different discretisations that have to agree.

``first``: Legendre elements, integrated by ``adaptive`` with a very small error. ``second``: a
Chebyshev basis with other elements, integrated by scipy's adaptive Radau IIA on the model's
forward dynamics, which shares no integrator with the package. On hinges and in the chirp, where
nearly undamped waves or hundreds of jumps would keep Radau busy for hours, it is sdirk4 with small
fixed steps. On hinges both have many short elements, which waves need, and the strains of the plane
only. All put many more nodes into an element than a run would. The more accurate one is the
reference: the second, or without Radau the first. The largest distance between the two, over the
length, is the agreement reached.

    python -m benchmarks.reference [case …]     makes benchmarks/results/reference_<case>.npz
    python -m benchmarks.reference --first [case …]   only the first again, the second is kept
"""

from __future__ import annotations

import itertools
import sys
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from soft_sim_ros.core.mechanics.scipy_adapter import FirstOrder
from soft_sim_ros.core.settled import Simulation

from .cases import CASES, Case
from .programs.ours import run, scene_of
from .programs.settings import dividing, plane_of

RESULTS = Path(__file__).parent / "results"

# Fixed steps of the second discretisation, in s, where it is not Radau.
STEPS = {"chirp": 5e-5, "slender_swing": 5e-5, "spin_up": 5e-5}


def first_settings(case: Case) -> dict[str, Any]:
    """Return the settings of the first discretisation."""
    out: dict[str, Any] = {"kind": "legendre", "integrator": "adaptive"}
    out |= {"step": dividing(case, case.output_period), "options": {"error": 1e-10}}
    if case.hinge:
        return out | {"order": 8, "elements": 8, "nodes": 24} | plane_of(case)
    return out | {"order": 6, "elements": 4 if len(case.sections) == 1 else 2, "nodes": 30}


def second_settings(case: Case) -> dict[str, Any]:
    """Return the settings of the second discretisation; Radau does not use its step."""
    single = len(case.sections) == 1
    if case.hinge:
        orders = {"kind": "chebyshev", "order": 6, "elements": 14, "nodes": 20}
        method = {"integrator": "sdirk4", "newton_tolerance": 1e-12}
        return orders | method | {"step": STEPS[case.name]} | plane_of(case)
    if without_radau(case):
        orders = {"kind": "chebyshev", "order": 7, "elements": 3, "nodes": 30}
        method = {"integrator": "sdirk4", "newton_tolerance": 1e-12}
        return orders | method | {"step": STEPS[case.name]}
    return {
        "kind": "chebyshev",
        "order": 7,
        "elements": 2 if single else 1,
        "nodes": 70 if single else 60,
        "step": case.output_period,
    }


def by_radau(
    case: Case, settings: dict[str, Any], rtol: float = 1e-8, atol: float = 1e-9
) -> np.ndarray:
    """Return the tip (outputs, 3) by scipy's Radau on the forward dynamics of a discretisation."""
    simulation = Simulation(scene_of(case, settings))
    dynamics, n = simulation.dynamics, simulation.n_coordinates
    efforts = np.zeros(simulation.n_actuators)

    system = FirstOrder(dynamics, efforts)
    outputs = case.output_period * np.arange(1, case.outputs + 1)
    tip = np.zeros((case.outputs, 3))
    y = np.concatenate([simulation.q, simulation.v])
    if case.tendon:
        efforts[:] = case.tendon.tension
    for begin, end, values in pieces(case):
        if values is not None:
            efforts[:] = values
        inside = (outputs > begin + 1e-12) & (outputs <= end + 1e-12)
        times = np.unique(np.append(outputs[inside], end))
        solution = solve_ivp(
            system, (begin, end + 1e-15), y, method="Radau", jac=system.jacobian, t_eval=times,
            rtol=rtol, atol=atol / simulation.length, first_step=1e-6,
        )  # fmt: skip
        if not solution.success:
            raise RuntimeError(f"{case.name}: Radau stopped at {begin} s: {solution.message}")
        for t, state in zip(solution.t, solution.y.T, strict=True):
            k = round(t / case.output_period) - 1
            if abs(t - (k + 1) * case.output_period) < 1e-9:
                tip[k] = dynamics.node_poses(state[:n])[-1][:3, 3]
        y = solution.y[:, -1].copy()
    return tip


def pieces(case: Case) -> list[tuple[float, float, Any]]:
    """Return (begin, end, efforts or None) of the stretches in which the loads are smooth."""
    if case.moments:
        period = case.moments.period
        count = round(case.duration / period)
        rows = case.moments.values
        return [(k * period, (k + 1) * period, rows[k]) for k in range(count)]
    if case.hub:
        marks = [0.0, case.hub.ramp, case.hub.end - case.hub.ramp, case.hub.end, case.duration]
        return [(a, b, None) for a, b in itertools.pairwise(marks)]
    return [(0.0, case.duration, None)]


def make(case: Case, keep_second: bool = False) -> float:
    """Make and keep the reference of a case; return the agreement reached."""
    begin = time.perf_counter()
    one = run(case, first_settings(case), repeats=1).tip
    middle = time.perf_counter()
    fixed = without_radau(case)
    if keep_second:
        with np.load(path_of(case)) as kept:
            two = kept["other" if fixed else "tip"]
    elif fixed:
        two = run(case, second_settings(case), repeats=1).tip
    else:
        two = by_radau(case, second_settings(case))
    agreement = distance(one, two, case.length)
    print(
        f"{case.name}: the two discretisations agree to {agreement:.1e} of the length "
        f"({middle - begin:.0f} s and {time.perf_counter() - middle:.0f} s)",
        flush=True,
    )
    times = case.output_period * np.arange(1, case.outputs + 1)
    tip, other = (one, two) if fixed else (two, one)
    np.savez_compressed(path_of(case), times=times, tip=tip, other=other, agreement=agreement)
    return agreement


def without_radau(case: Case) -> bool:
    """Whether Radau would take hours: nearly undamped waves to follow, or hundreds of restarts."""
    return bool(case.hinge) or bool(case.moments and len(case.moments.values) > 10)


def distance(tip: np.ndarray, reference: np.ndarray, length: float) -> float:
    """Return the largest tip position error over the run, over the length."""
    return float(np.max(np.linalg.norm(tip - reference, axis=1)) / length)


@cache
def coarse_tip(case: Case) -> np.ndarray:
    """Return the tip of the published model, one constant strain per section, exact in time."""
    settings = {"kind": "constant", "nodes": 30, "step": 5e-4, "integrator": "sdirk4"}
    return run(case, settings, repeats=1).tip


def path_of(case: Case) -> Path:
    """Return where the reference of a case is kept."""
    return RESULTS / f"reference_{case.name}.npz"


def load(case: Case) -> tuple[np.ndarray, float]:
    """Return (tip (outputs, 3), agreement), making them first where they are missing."""
    if not path_of(case).is_file():
        print(f"{case.name}: no reference yet, making it", flush=True)
        RESULTS.mkdir(exist_ok=True)
        make(case)
    with np.load(path_of(case)) as kept:
        return kept["tip"], float(kept["agreement"])


if __name__ == "__main__":
    RESULTS.mkdir(exist_ok=True)
    only_first = "--first" in sys.argv
    for name in [given for given in sys.argv[1:] if given != "--first"] or CASES:
        make(CASES[name], only_first)
