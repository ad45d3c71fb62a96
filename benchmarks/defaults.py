"""Is anything off without a word? Curled arms without numerics and with coarse ones, against truth.

    python -m benchmarks.defaults [beginning of a scene's name …]

Every scene of curled.py is solved as nobody writes numerics, and with three coarse written bases. A
result that is off in space by more than its limit (1e-3 of the length without numerics, 1e-2 with
written ones) and says nothing is a silent one. Fails if there is one. Truth is another kind of
basis on three elements with many nodes; motions of the same integrator (sdirk2, 1 ms) differ in
space only, those without numerics are judged in time, too (sdirk4). Writes
benchmarks/results/defaults.json.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.accuracy.space_watch import AccompaniedInputs, LookedInputs, SpaceInputs
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.refine.space_error import UNWRITTEN, WRITTEN, Forcing, static_error
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import NotResolved, SolverError
from soft_sim_ros.scene import Scene, parse_scene

from . import machine, reference
from .curled import LENGTH, Curled, at_rest, moving

LOOK = 0.02  # s between two looks at a motion
FINE = {"kind": "chebyshev", "order": 8, "elements": 3, "nodes": 16}
WAYS: dict[str, dict[str, Any]] = {
    "none": {},
    "order 1": {"order": 1},
    "torsion 1, bending 3": {"order": {"torsion": 1, "bend_y": 3, "bend_z": 3, "stretch": 1,
                                       "shear_y": 1, "shear_z": 1}},
    "constant, 4": {"kind": "constant", "elements": 4},
}  # fmt: skip
RESULT = reference.RESULTS / "defaults.json"


def scene_of(case: Curled, numerics: dict[str, Any]) -> Scene:
    """Return the scene of a case with numerics, or without."""
    strains = case.document["bodies"][0].get("strains")
    order = numerics.get("basis", {}).get("order")
    if strains and isinstance(order, dict):
        known = {name: order[name] for name in strains}
        numerics = numerics | {"basis": numerics["basis"] | {"order": known}}
    document = case.document | ({"numerics": numerics} if numerics else {})
    plain = json.loads(json.dumps(document, default=float))
    return parse_scene(yaml.safe_dump(plain), f"{case.name}.yaml")


def numerics_of(case: Curled, basis: dict[str, Any]) -> dict[str, Any]:
    """Return the written numerics of a basis; none for none."""
    if not basis:
        return {}
    return {"basis": basis} | ({"step": 0.001} if case.duration else {})


def resting_tip(case: Curled, scene: Scene, warn: bool) -> tuple[np.ndarray, float, bool]:
    """Return the tip (3,) at rest, the estimate over the length, and whether a word was said."""
    arm, tip = Dynamics(scene), None if case.tip is None else np.array(case.tip)
    efforts = np.array(case.efforts) if case.efforts else None
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        q = equilibrium(
            arm, efforts=efforts, tip=tip, tip_follows=case.follows, stable=False, check=warn
        )
    estimate = np.nan
    if warn:
        estimate = static_error(arm, q, Forcing(efforts, 0.0, 1.0, tip, case.follows))
    told = any(isinstance(one.message, NotResolved) for one in said)
    return arm.node_poses(q)[-1][:3, 3], estimate, told


def moving_tips(case: Curled, scene: Scene, how: str) -> tuple[np.ndarray, float, bool]:
    """Return tips (looks, 3), the estimate over the length, and whether a word was said."""
    simulation = Simulation(scene)
    kinds = {"companion": AccompaniedInputs, "looks": LookedInputs, "plain": Inputs}
    more = {"beat": LOOK} if how == "looks" else {}
    said: list[str] = []
    if how != "plain":
        more["complain"] = said.append
    inputs = kinds[how](simulation, command_timeout=0.0, ramp=0.0, **more)
    if case.efforts:
        inputs.command(np.array(case.efforts))
    steps = round(LOOK * 1e9 / simulation.step_ns)
    sampler, tips = simulation.sampler(2), []
    for _ in range(round(case.duration / LOOK)):
        inputs.advance(steps)
        tips.append(sampler.poses()[-1, :3].copy())
    estimate = inputs.space_rel if isinstance(inputs, SpaceInputs) else np.nan
    return np.array(tips), estimate, bool(said)


def entries_of(case: Curled) -> Iterator[dict[str, Any]]:
    """Solve a case in every way, and compare."""
    exact: dict[bool, np.ndarray] = {}

    def truth(exactly_in_time: bool) -> np.ndarray:
        if exactly_in_time not in exact:
            numerics: dict[str, Any] = {"basis": FINE}
            if not case.duration:
                exact[exactly_in_time] = resting_tip(case, scene_of(case, numerics), False)[0]
            else:
                method = "sdirk4" if exactly_in_time else "sdirk2"
                numerics |= {"step": 0.001, "integrator": method}
                exact[exactly_in_time] = moving_tips(case, scene_of(case, numerics), "plain")[0]
        return exact[exactly_in_time]

    for way, basis in WAYS.items():
        scene = scene_of(case, numerics_of(case, basis))
        limit = WRITTEN if basis else UNWRITTEN
        hows = ["statics"] if not case.duration else ["companion", "looks"] if basis else ["looks"]
        for how in hows:
            entry = {"case": case.name, "numerics": way, "how": how, "limit": limit}
            try:
                if case.duration:
                    tips, estimate, told = moving_tips(case, scene, how)
                else:
                    tips, estimate, told = resting_tip(case, scene, True)
            except SolverError as error:
                yield entry | {"outcome": type(error).__name__, "silent": False}
                continue
            apart = np.atleast_2d(tips - truth(not basis))
            error = float(np.linalg.norm(apart, axis=-1).max()) / LENGTH
            silent = error > limit and not told
            yield entry | {"outcome": "completed", "error_rel": error, "estimate_rel": estimate,
                           "told": told, "silent": silent}  # fmt: skip


def keep(entries: list[dict[str, Any]]) -> None:
    """Write the entries; those of other cases stay."""
    known = json.loads(RESULT.read_text())["entries"] if RESULT.exists() else []
    names = {entry["case"] for entry in entries}
    others = [entry for entry in known if entry["case"] not in names]
    result = {"machine": machine.facts(), "entries": [*others, *entries]}
    RESULT.write_text(json.dumps(result, indent=1) + "\n")


def main(words: Sequence[str]) -> int:
    """Measure some scenes, all by default; print, write, judge."""
    entries: list[dict[str, Any]] = []
    print("scene                        numerics              how        error    estimate  said")
    for case in [*at_rest(), *moving()]:
        if words and not case.name.startswith(tuple(words)):
            continue
        for entry in entries_of(case):
            entries.append(entry)
            said = "SILENT" if entry["silent"] else "warned" if entry.get("told") else ""
            numbers = entry["outcome"]
            if numbers == "completed":
                numbers = f"{entry['error_rel']:.1e}  {entry['estimate_rel']:.1e}"
            print(f"{case.name:28} {entry['numerics']:21} {entry['how']:10} {numbers:18} {said}",
                  flush=True)  # fmt: skip
    for way in WAYS:
        own = [entry for entry in entries if entry["numerics"] == way]
        done = [entry for entry in own if entry["outcome"] == "completed"]
        worst = max((entry["error_rel"] for entry in done), default=0.0)
        told, silent = (sum(bool(e.get(key)) for e in own) for key in ("told", "silent"))
        print(f"{way:21} {len(own)} results, worst {worst:.1e}, warned {told}, silent {silent}")
    keep(entries)
    return 1 if any(entry["silent"] for entry in entries) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
