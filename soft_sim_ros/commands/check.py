"""Validate a scene and print the numbers an engineer looks at first."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from soft_sim_ros.commands.progress import compiling
from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.core.modes import frequencies, recommended_step
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.scene import Rod, Scene, load_scene, summary, total_mass

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
    options = parser.parse_args(argv)
    scene = load_scene(options.scene)
    for line in sections(scene):
        print(line)
    with compiling():
        simulation = Simulation(scene)
        rest = list(numbers(simulation))
    for line in rest:
        print(line)
    return DONE


def sections(scene: Scene) -> Iterator[str]:
    """Give the table of sections: start and end of each, where they differ."""
    rows = summary(scene)
    length = sum(body.length for body in scene.bodies if isinstance(body, Rod))
    yield f"{scene.file}: valid"
    yield (
        f"{scene.name}: {total_mass(scene):.4g} kg, {length:g} m of rod; "
        f"bodies {len(scene.bodies)}, sections {len(rows)}, "
        f"actuators {len(scene.actuators)}, loads {len(scene.loads)}"
    )
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


def numbers(simulation: Simulation) -> Iterator[str]:
    """Give what the compiled scene says about size, speed and stiffness."""
    dynamics, numerics = simulation.dynamics, simulation.scene.numerics
    hertz = frequencies(dynamics, simulation.q, MODES)
    hertz[abs(hertz) < ZERO] = 0.0
    state = simulation.scene.initial.state
    yield f"coordinates       {simulation.n_coordinates}"
    yield f"frequencies       {', '.join(f'{f:.4g}' for f in hertz)} Hz (at the {state})"
    if (hertz < 0.0).any():
        yield "                  negative: no stable rest here"
    yield f"memory            {_size(simulation.nbytes)} for model, state and solver"
    yield f"step              {numerics.step:g} s, {numerics.integrator}"
    yield f"recommended step  {recommended_step(dynamics, simulation.q):g} s"


def _size(count: int) -> str:
    return f"{count / 1024:.0f} KiB" if count < 10 * 1024**2 else f"{count / 1024**2:.1f} MiB"


def _ends(pair: tuple[float, float]) -> str:
    """Give both ends of a section, or one number where they are the same."""
    first, last = (f"{value:.4g}" for value in pair)
    return first if first == last else f"{first} … {last}"
