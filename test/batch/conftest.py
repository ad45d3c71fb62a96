"""A small arm, and runs of it."""

from __future__ import annotations

from pathlib import Path

import pytest

SCENE = """\
gravity: [0, 0, -9.81]
materials:
  rubber: &rubber {young_modulus: 1.0e+6, poisson_ratio: 0.45, density: 1000, viscosity: 1000}
  other: {<<: *rubber, density: 900}
bodies:
  - rod: reed
    strains: [bend_y, bend_z]
    sections:
      - {name: root, length: 0.1, material: rubber, cross_section: {shape: circle, radius: 0.01}}
      - {name: tip, length: 0.1, material: other, cross_section: {shape: circle, radius: 0.01}}
actuators:
  - {moment: y, rod: reed, section: root, strain: bend_y, limits: [-0.1, 0.1]}
numerics:
  step: 0.002
  basis: {order: 1}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Scene file of a clamped reed of two sections."""
    file = tmp_path / "reed.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def sweep(tmp_path: Path, scene: Path):
    """Write a sweep of the reed and return its file."""

    def write(text: str) -> Path:
        file = tmp_path / "sweep.yaml"
        file.write_text(f"scenes: {scene.name}\nduration: 0.1\n" + text)
        return file

    return write
