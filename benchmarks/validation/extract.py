"""Take rows out of SoRoSim's bank for tests: ``python -m benchmarks.validation.extract BANK``.

Three static shapes and the first quarter of a second of one release, unchanged, with the licence.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from .bank import STATICS

OUT = Path(__file__).resolve().parents[2] / "test" / "validation" / "data"
SHAPES = (0, 1, 250)
RELEASE, ROWS = "TPURodMuJoCo_1.txt", 2 + 51


def main() -> None:
    """Write the extract."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.validation.extract")
    parser.add_argument("bank", type=Path)
    bank: Path = parser.parse_args().bank
    for part in ("statics", "dynamics"):
        (OUT / part).mkdir(parents=True, exist_ok=True)
    lines = (bank / "statics" / STATICS).read_text().splitlines(keepends=True)
    kept = lines[:2] + [line for k in SHAPES for line in lines[2 + 6 * k : 8 + 6 * k]]
    (OUT / "statics" / STATICS).write_text("".join(kept))
    lines = (bank / "dynamics" / RELEASE).read_text().splitlines(keepends=True)
    (OUT / "dynamics" / RELEASE).write_text("".join(lines[:ROWS]))
    shutil.copyfile(bank / "LICENSE", OUT / "LICENSE")
    (OUT / "LICENSE").chmod(0o644)


if __name__ == "__main__":
    main()
