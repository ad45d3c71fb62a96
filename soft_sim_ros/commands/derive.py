"""Derive the scalar equations of motion of a rod for a rotation sequence and a reference curve."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_sim_ros.commands.shell import DONE, verb

SCREEN = "-"


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Derive what the command line asks for."""
    parser = argparse.ArgumentParser(prog="derive", description=__doc__)
    parser.add_argument(
        "--rotations",
        default="zyx",
        help="axes of the angles psi1, psi2, psi3, such as zyx or zxz (default: zyx)",
    )
    parser.add_argument(
        "--reference",
        default="straight",
        help="straight (default), general, or strains of the reference curve: three curvatures, "
        "or six with stretch and shears, as expressions in s, such as '0, 0, 1/R'",
    )
    for name, what in (("latex", "LaTeX"), ("python", "a numpy module")):
        parser.add_argument(
            f"--{name}",
            nargs="?",
            const=SCREEN,
            metavar="FILE",
            help=f"as {what}, into a file or on the screen",
        )
    options = parser.parse_args(argv)
    from soft_sim_ros.derive import as_latex, as_python, as_text, derive

    derivation = derive(options.rotations, options.reference)
    wanted = {as_latex: options.latex, as_python: options.python}
    if not any(wanted.values()):
        wanted = {as_text: SCREEN}
    for write, where in wanted.items():
        if where == SCREEN:
            print(write(derivation), end="")
        elif where:
            Path(where).write_text(write(derivation), encoding="utf-8")
            print(where)
    return DONE
