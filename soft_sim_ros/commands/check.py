"""Validate a scene and print the numbers an engineer looks at first."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from soft_sim_ros.commands.felt import felt_lines
from soft_sim_ros.commands.progress import Line, compiling
from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.core.accuracy.contract import settle
from soft_sim_ros.core.accuracy.survey import survey
from soft_sim_ros.core.accuracy.unwritten import is_unwritten, settle_unwritten
from soft_sim_ros.core.analysis.modes import frequencies, long_step, recommended_step
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.contacts import ContactReader
from soft_sim_ros.core.mechanics.wrench import InternalWrench
from soft_sim_ros.core.refine.refinement import words
from soft_sim_ros.core.refine.space_error import UNWRITTEN, WRITTEN
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import NotResolved, StaticsFailed
from soft_sim_ros.scene import Scene, load_scene, summary, total_mass
from soft_sim_ros.scene.limbs import limbs_of
from soft_sim_ros.scene.summary import elastic, in_fluid

# heading, field of the summary
COLUMNS = (
    ("EI_y N·m²", "EI_y"),
    ("EI_z N·m²", "EI_z"),
    ("GJ N·m²", "GJ"),
    ("EA N", "EA"),
    ("GA_y N", "GA_y"),
    ("GA_z N", "GA_z"),
)
MODES = 6
ZERO = 1e-6  # Hz; a free joint has no frequency, but round-off


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Check the scene named on the command line."""
    parser = argparse.ArgumentParser(prog="check", description=__doc__)
    parser.add_argument("scene", help="scene file, or the name of one in the config folder")
    parser.add_argument(
        "--wrench", type=Path, metavar="FILE.png", help="draw the internal wrench along the arm"
    )
    options = parser.parse_args(argv)
    scene = load_scene(options.scene)
    for line in sections(scene):
        print(line)
    for warning in doubts(scene):  # first: they may explain why the rest fails
        print(f"warning: {warning}")
    progress = Line()
    with compiling():
        chosen = settle(scene, progress.show)
        progress.clear()
        simulation = Simulation(chosen)
        q, state = rest(simulation)
        lines = [
            *numbers(simulation, q, state),
            *felt(simulation, q),
            *accuracy(scene, simulation, q, state),
        ]
    for line in lines:
        print(line)
    if options.wrench:
        from soft_sim_ros.report.wrench import by_backbone, wrench_picture

        poses = simulation.dynamics.node_poses(q)
        limbs = by_backbone(simulation.compiled, carried(simulation, q), poses)
        print(f"{wrench_picture(limbs, options.wrench)} (in {state})")
    return DONE


def doubts(scene: Scene) -> Iterator[str]:
    """Give what is allowed but looks like another unit, or like no rod."""
    for body in elastic(scene):
        for section in body.sections:
            where = f"{body.name}/{section.name}"
            area = float(np.max(section.cross_section.area(np.array([0.0, 1.0]))))
            width = 2.0 * np.sqrt(area / np.pi)
            if width > 1.0 or section.length > 20.0:
                size = f"{width:.3g} m wide and {section.length:g} m long"
                yield f"{where} is {size}: lengths are in m"
            if section.length < 1e-3:
                yield f"{where} is {section.length:g} m long: lengths are in m"
            if body.length < 5.0 * width:
                yield f"{where} is {width:.3g} m wide in a rod of {body.length:g} m: not slender"
            material = section.material
            if not 10.0 <= material.density <= 25000.0:
                yield f"{where} has {material.density:g} kg/m³: densities are in kg/m³"
            if not 1e3 <= material.young_modulus <= 1.5e12:
                yield f"{where} has {material.young_modulus:g} Pa: moduli are in Pa"


def sections(scene: Scene) -> Iterator[str]:
    """Give the table of sections: start and end of each, where they differ."""
    rows = summary(scene)
    length = sum(rod.length for rod in elastic(scene))
    yield f"{scene.file}: valid"
    yield (
        f"{scene.name}: {total_mass(scene):.4g} kg, {length:g} m of rod; "
        f"bodies {len(scene.bodies)}, sections {len(rows)}, "
        f"actuators {len(scene.actuators)}, loads {len(scene.loads)}"
    )
    if surrounded := in_fluid(scene):
        yield surrounded
    limbs = limbs_of(scene)
    if limbs.branched:
        yield f"branches {len(limbs.backbones)}: {', '.join(map(' → '.join, limbs.rows)) or 'none'}"
        yield f"tips     {len(limbs.tips)}: {', '.join(limbs.tips)}; wrenches act on the last one"
    for one in scene.sensors:
        late = f", {one.latency:g} s late" if one.latency else ""
        noisy = ", with noise" if one.noise.any() else ""
        yield f"sensor {one.name}: {one.kind} of {one.of} at {one.rate:g} Hz{late}{noisy}"
    if not rows:
        return
    heads = ["section", "length m", "mass kg", *(head for head, _ in COLUMNS), "slenderness"]
    table = [
        [
            f"{row.rod}/{row.section}",
            f"{row.length:g}",
            f"{row.mass:.4g}",
            *(_ends(getattr(row, name)) for _, name in COLUMNS),
            f"{row.slenderness:.3g}",
        ]
        for row in rows
    ]
    widths = [max(map(len, column)) for column in zip(heads, *table, strict=True)]
    for cells in [heads, *table]:
        first, *others = (cell for cell in zip(cells, widths, strict=True))
        yield "  ".join([first[0].ljust(first[1]), *(text.rjust(w) for text, w in others)])


def rest(simulation: Simulation) -> tuple[np.ndarray, str]:
    """Give coordinates (n,) about which the arm swings, and what they are, in words."""
    dynamics, initial = simulation.dynamics, simulation.scene.initial
    if initial.state == "equilibrium":
        return simulation.q, "the initial equilibrium"
    efforts = np.array([actuator.safe for actuator in simulation.scene.actuators])
    try:
        q = equilibrium(dynamics, efforts=efforts, check=False)
    except StaticsFailed:
        return simulation.q, "the initial state, which is not at rest"
    return q, "the equilibrium under weight and loads"


def carried(simulation: Simulation, q: np.ndarray) -> InternalWrench:
    """Give what the sections carry when the arm is let go at coordinates q (n,)."""
    dynamics = simulation.dynamics
    efforts = np.array([actuator.safe for actuator in simulation.scene.actuators])
    rest = np.zeros_like(q)
    return dynamics.internal_wrench(q, rest, dynamics.forward_dynamics(q, rest, efforts))


def felt(simulation: Simulation, q: np.ndarray) -> Iterator[str]:
    """Give what constraints and contacts carry at coordinates q (n,)."""
    dynamics, scene = simulation.dynamics, simulation.scene
    if not (scene.constraints or scene.touches):
        return
    efforts = np.array([actuator.safe for actuator in scene.actuators])
    reactions = dynamics.reactions_of_constraints(q, efforts=efforts) if scene.constraints else {}
    redundant = dynamics.redundant_constraints(q) if scene.constraints else {}
    contacts = ContactReader(simulation.compiled).near(q, np.zeros_like(q))
    yield from felt_lines(scene, reactions, contacts, redundant)


def numbers(simulation: Simulation, q: np.ndarray, state: str) -> Iterator[str]:
    """Give what the compiled scene says about size, speed and stiffness about a state (n,)."""
    dynamics, numerics = simulation.dynamics, simulation.scene.numerics
    hertz = frequencies(dynamics, q, MODES)
    hertz[abs(hertz) < ZERO] = 0.0
    yield f"coordinates       {simulation.n_coordinates}"
    yield f"frequencies       {', '.join(f'{f:.4g}' for f in hertz)} Hz (about {state})"
    if (hertz < 0.0).any():
        yield "                  negative: the arm leaves this state by itself"
    yield f"memory            {_size(simulation.nbytes)} for model, state and solver"
    yield f"step              {numerics.step:g} s, {numerics.integrator}"
    if numerics.tolerance is not None:
        yield f"for tolerance     {numerics.tolerance:g}: {words(numerics)}"
    yield f"recommended step  {recommended_step(dynamics, q):g} s"
    if warning := long_step(dynamics, q, numerics):
        yield f"warning: {warning}"


def accuracy(scene: Scene, simulation: Simulation, q: np.ndarray, state: str) -> Iterator[str]:
    """Give what is known of the tip's error, and a warning if that is too much."""
    if is_unwritten(scene):
        chosen = settle_unwritten(scene)
        error, limit = chosen.error_rel, UNWRITTEN
        yield f"numerics          chosen, none are written: {words(chosen.scene.numerics)}"
        yield f"error of the tip  {error:.2g} of the length, in the states and the motion tried"
    elif scene.numerics.tolerance is None:
        found = survey(simulation, q if "equilibrium" in state else None)
        if found is None:
            return
        error, limit = found.certain, WRITTEN
        beyond = " (too coarse for these)" if found.corners > limit else ""
        if found.missed:
            beyond += f" ({found.missed} of these states of rest not found)"
        yield (
            f"error in space    of the length: {found.rest:.2g} at rest, {found.corners:.2g} at "
            f"the limits of loads and actuators{beyond}, {found.motion:.2g} in a second of motion"
        )
    else:
        return
    if not error <= limit:
        yield f"warning: {NotResolved(scene.name, error, limit)}"


def _size(count: int) -> str:
    return f"{count / 1024:.0f} KiB" if count < 10 * 1024**2 else f"{count / 1024**2:.1f} MiB"


def _ends(pair: tuple[float, float]) -> str:
    """Give both ends of a section, or one number where they are the same."""
    first, last = (f"{value:.4g}" for value in pair)
    return first if first == last else f"{first} … {last}"
