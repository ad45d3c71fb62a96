"""Linearise a scene about an equilibrium: A, B, C, D for scipy.signal and python-control."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
from scipy.io import savemat

from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.core.analysis.linearisation import Linearisation, linearise
from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import CommandError
from soft_sim_ros.scene import Scene, load_scene

SUFFIXES = (".npz", ".mat", ".json")
SHOWN = 6
DRIFT = 1e-6  # arm lengths per s²


def at_rest(scene: Scene, orders: Sequence[str] = ()) -> Simulation:
    """Return the scene at rest in its equilibrium, under its safe efforts but for some others.

    Parameters
    ----------
    scene : joints with a position in ``initial`` are held there
    orders : ``NAME=VALUE`` each, in the units of the commands

    Raises
    ------
    CommandError
        for an unknown name, or a value that is no number or beyond the limits of the actuator
    StaticsFailed
        if there is no equilibrium
    """
    names, values = [], []
    for given in orders:
        name, _, text = given.partition("=")
        try:
            values.append(float(text))
        except ValueError:
            raise CommandError("efforts", f"{given!r}: expected NAME=NUMBER") from None
        names.append(name)
    at_reference = replace(scene, initial=replace(scene.initial, state="reference"))
    if names:
        order = Inputs(Simulation(at_reference), 0.0, 0.0).joint_order(names, values)
        if order.clamped:
            raise CommandError("efforts", f"beyond the limits: {', '.join(order.clamped)}")
        held = dict(zip(names, order.values.tolist(), strict=True))
        actuators = tuple(replace(a, safe=held.get(a.name, a.safe)) for a in scene.actuators)
        scene = replace(scene, actuators=actuators)
    return Simulation(replace(scene, initial=replace(scene.initial, state="equilibrium")))


def save(system: Linearisation, path: Path) -> None:
    """Write a system under the names of its fields, as ``.npz``, ``.mat`` or ``.json``."""
    content = {field.name: getattr(system, field.name) for field in fields(system)}
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".json":
        plain = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in content.items()}
        path.write_text(json.dumps(plain, allow_nan=False) + "\n")
        return
    texts = {k: v for k, v in content.items() if isinstance(v, tuple)}
    if path.suffix == ".mat":
        # cell arrays of texts, and vectors as columns
        cells = {k: np.array(v, dtype=object).reshape(-1, 1) for k, v in texts.items()}
        savemat(path, content | cells, oned_as="column")
    else:
        np.savez_compressed(path, **(content | {k: np.array(v) for k, v in texts.items()}))


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Linearise the scene named on the command line."""
    options = _parser().parse_args(argv)
    scene = load_scene(options.scene)
    warm_up(scene)
    simulation = at_rest(scene, options.effort)
    dynamics, q = simulation.dynamics, simulation.q
    efforts = simulation.ports()[2]
    follows = options.wrench_frame == "tip"
    system = linearise(dynamics, q, efforts, tip_follows=follows)
    modes = complex_modes(dynamics, q, efforts)
    drifts = np.abs(system.drift[dynamics.n :] * dynamics.model.weight).max(initial=0.0) > DRIFT
    if options.sample is not None:
        system = system.discrete(options.sample)
    kind = f"sampled every {system.step:g} s" if system.step else "in continuous time"
    print(f"{scene.name}: {len(system.A)} states, {kind}")
    print(f"inputs   {', '.join(system.inputs)}")
    print(f"outputs  {', '.join(system.outputs)}")
    print(f"growth   {modes.growth:.4g} 1/s" + (": unstable" if modes.growth > 0.0 else ""))
    table = zip(modes.values, modes.frequencies, modes.damping_ratios, strict=True)
    for s, hertz, ratio in list(table)[:SHOWN]:
        print(f"pole     {s:.4g} 1/s: {hertz:.4g} Hz, damping ratio {ratio:.3g}")
    if dynamics.model.branch.any():
        print("warning: Maxwell branches are left out: the system is that of the relaxed arm")
    if drifts:
        print(
            "warning: joints held by initial.positions would move by themselves; "
            "how fast is in the field drift"
        )
    if options.out is not None:
        save(system, options.out)
        print(options.out)
    return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="linearise", description=__doc__)
    parser.add_argument("scene", help="scene file, or the name of one in the config folder")
    parser.add_argument(
        "--effort",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="command of an actuator in the equilibrium, in its unit (default: safe); repeat",
    )
    parser.add_argument(
        "--sample", type=_step, metavar="S", help="sampled every S s, with inputs held: exact"
    )
    parser.add_argument(
        "--wrench-frame",
        choices=("world", "tip"),
        default="world",
        help="axes of the wrench at the tip, among the inputs",
    )
    parser.add_argument(
        "--out", type=_file, metavar="FILE", help="the system, as .npz, .mat or .json"
    )
    return parser


def _step(text: str) -> float:
    value = float(text)
    if not 0.0 < value < np.inf:
        raise argparse.ArgumentTypeError(f"{text}: expected a finite number above zero")
    return value


def _file(text: str) -> Path:
    path = Path(text)
    if path.suffix not in SUFFIXES:
        raise argparse.ArgumentTypeError(f"{text}: expected a name in {', '.join(SUFFIXES)}")
    return path
