"""Compare this package with others' results: ``python -m benchmarks.validation [--bank DIR]``.

Writes benchmarks/results/validation.json, pictures, and the tables of docs/validation.md and
README.md. What is not run keeps its entries. SoRoSim's bank is read from a directory that the
caller has, see benchmarks/validation/bank.py for where it comes from.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import machine
from ..reference import RESULTS
from . import bank, bathe, pages, pictures, princeton, sorosim, third_party, vu_quoc

FILE = RESULTS / "validation.json"


def statics_of(where: Path) -> dict[str, Any]:
    """Compare SoRoSim's static shapes."""
    return sorosim.statics(bank.shapes(where))


def releases_of(where: Path) -> dict[str, Any]:
    """Compare SoRoSim's releases."""
    releases = bank.releases(where)
    found, tips = sorosim.motions(releases)
    pictures.release(releases[0], tips[0])
    return found


def elbow() -> dict[str, Any]:
    """Compare the elbow, and draw it."""
    found, mine, theirs = vu_quoc.compare_elbow()
    pictures.elbow(mine, theirs)
    return found


def jobs(where: Path | None) -> dict[str, Callable[[], Any]]:
    """Return everything that can be compared, by name."""
    out: dict[str, Callable[[], Any]] = {
        "princeton": princeton.compare, "bathe": bathe.compare,
        "flight": vu_quoc.compare_flight, "elbow": elbow, "cosseratbench": third_party.scores,
    }  # fmt: skip
    if where:
        out["sorosim_statics"] = lambda: statics_of(where)
        out["sorosim_releases"] = lambda: releases_of(where)
    return out


def kept() -> dict[str, Any]:
    """Return what was found so far, by name, in the order of the comparisons."""
    found: dict[str, Any] = json.loads(FILE.read_text()) if FILE.is_file() else {}
    return {name: found[name] for name in jobs(Path()) if name in found}


def main() -> None:
    """Parse, compare, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.validation", description=__doc__)
    parser.add_argument("--bank", type=Path, help="directory of SoRoSim's bank")
    parser.add_argument("--only", nargs="*", choices=list(jobs(Path())), help="these only")
    given = parser.parse_args()
    todo = jobs(given.bank)
    chosen = list(todo) if given.only is None else given.only
    for name in chosen:
        if name not in todo:
            parser.error(f"{name} needs --bank DIR")
    RESULTS.mkdir(exist_ok=True)
    for name in chosen:
        begin = time.monotonic()
        entry = {"found": todo[name](), "machine": machine.facts()}
        FILE.write_text(json.dumps(kept() | {name: entry}, indent=1) + "\n")
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    if not given.bank:
        print("SoRoSim's bank: not given (--bank DIR), its entries are those of an earlier run")
    pictures.main(kept())
    pages.main(kept())


if __name__ == "__main__":
    main()
