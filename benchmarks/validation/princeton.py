"""The Princeton beam: a flat aluminium cantilever under a force that bends and twists it.

Experiment: Dowell and Traybar (1975). Compared are published solutions of the same set-up by other
programs, which differ in the torsion constant: Exudyn's example takes 0.198 (I_y + I_z) from the
paper, ANSYS's beam the rectangle's own.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import parse_scene

FILE = Path(__file__).parent / "data" / "princeton.csv"
LENGTH, WIDTH, THICKNESS = 0.508, 12.3777e-3, 3.2024e-3
YOUNG, POISSON = 71.7e9, 0.31
PAPER = 0.198  # torsion constant over I_y + I_z in the paper and in Exudyn's example


def points() -> list[dict[str, float]]:
    """Return the published points, by column."""
    lines = [line for line in FILE.read_text().splitlines() if not line.startswith("#")]
    return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def torsion_of_paper() -> float:
    """Return the torsional stiffness in N·m² that the paper and Exudyn's example take."""
    second = WIDTH * THICKNESS * (WIDTH**2 + THICKNESS**2) / 12.0
    return YOUNG / (2.0 * (1.0 + POISSON)) * PAPER * second


def tip(force: float, angle: float, torsion: float | None = None, order: int = 6) -> np.ndarray:
    """Return how far the tip goes (2,), along the width and the thickness, in m.

    force : N, at ``angle`` rad from the width
    torsion : N·m² instead of that of the rectangle
    """
    section: dict[str, Any] = {
        "name": "whole", "length": LENGTH, "material": "aluminium", "shear_correction": 1.0,
        "cross_section": {"shape": "rectangle", "width_y": WIDTH, "width_z": THICKNESS},
    }  # fmt: skip
    if torsion is not None:
        section["stiffness"] = {"torsion": torsion}
    document = {
        "gravity": [0.0, 0.0, 0.0],
        "materials": {
            "aluminium": {"young_modulus": YOUNG, "poisson_ratio": POISSON, "density": 2700.0}
        },
        "bodies": [{"rod": "beam", "sections": [section]}],
        "numerics": {"basis": {"order": order, "elements": 2}},
    }
    dynamics = Dynamics(parse_scene(yaml.safe_dump(document), "princeton.yaml"))
    wrench = np.array([0.0, 0.0, 0.0, 0.0, np.cos(angle), np.sin(angle)])
    q = equilibrium(dynamics, tip=force * wrench)
    place: np.ndarray = dynamics.node_poses(q)[-1][1:3, 3]
    return place


def compare(order: int = 6) -> dict[str, Any]:
    """Compare all points; errors are the distance of the tips over the length."""
    rows = []
    for point in points():
        force, angle = point["P_N"], np.radians(point["beta_deg"])
        own, paper = tip(force, angle, None, order), tip(force, angle, torsion_of_paper(), order)
        row: dict[str, Any] = {
            "force_N": force, "beta_deg": point["beta_deg"], "own": own.tolist(),
            "paper": paper.tolist(),
        }  # fmt: skip
        pairs = {"exudyn16": paper, "ansys_beam": own, "ansys_solid": own}
        for program, mine in pairs.items():
            theirs = np.array([point[f"uy_{program}"], point[f"uz_{program}"]])
            row[program] = theirs.tolist()
            row[f"error_{program}"] = float(np.linalg.norm(mine - theirs) / LENGTH)
        rows.append(row)
    worst = {
        program: max(float(row[f"error_{program}"]) for row in rows)
        for program in ("exudyn16", "ansys_beam", "ansys_solid")
    }
    return {"rows": rows, "worst": worst}
