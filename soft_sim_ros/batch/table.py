"""The results of a batch as a table."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from soft_sim_ros.version import __version__

# after run, scene, seed and the parameters
COLUMNS = (
    "outcome", "simulated_s", "tip_x", "tip_y", "tip_z", "error_rel", "gained_rel",
    "energy_residual_J", "wall_s", "reason",
)  # fmt: skip


def write_tables(results: Sequence[dict[str, Any]], out: Path) -> None:
    """Write results.json and results.csv into a folder; readers never see half a table."""
    text = json.dumps({"package": f"soft_sim_ros {__version__}", "runs": results}, indent=1)
    new = out / "results.json.new"
    new.write_text(text + "\n")
    os.replace(new, out / "results.json")
    parameters = list(dict.fromkeys(key for result in results for key in result["parameters"]))
    new = out / "results.csv.new"
    with open(new, "w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(["run", "scene", "seed", *parameters, *COLUMNS])
        for result in results:
            tip = dict(zip(("tip_x", "tip_y", "tip_z"), result.get("tip_m") or (), strict=False))
            rows.writerow(
                [result["run"], result["scene"], result["seed"]]
                + [result["parameters"].get(key) for key in parameters]
                + [(result | tip).get(key) for key in COLUMNS]
            )
    os.replace(new, out / "results.csv")
