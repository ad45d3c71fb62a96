"""A small arm, and verbs called in this process."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

SCENE = """\
name: reed
gravity: [0, 0, -9.81]
materials:
  rubber: {young_modulus: 1.0e+6, poisson_ratio: 0.45, density: 1000, viscosity: 1000}
bodies:
  - rod: reed
    strains: [bend_y, bend_z]
    sections:
      - {name: all, length: 0.3, material: rubber, cross_section: {shape: circle, radius: 0.01}}
actuators:
  - {moment: y, rod: reed, section: all, strain: bend_y, limits: [-0.1, 0.1]}
  - {moment: z, rod: reed, section: all, strain: bend_z, limits: [-0.1, 0.1]}
numerics:
  step: 0.002
  basis: {order: {bend_y: 1, bend_z: 1}}
"""
COMMANDS = "time,y,z\n0.1,0.05,0\n0.1451,0.05,-0.02\n0.2,0,0.5\n"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Scene file of a clamped reed with two bending moments."""
    file = tmp_path / "reed.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def call():
    """Call a verb as the shell does."""

    def run(verb, *arguments):
        return import_module(f"soft_sim_ros.commands.{verb}").main([str(a) for a in arguments])

    return run


@pytest.fixture
def recording(scene, call, tmp_path) -> Path:
    """Recording of 0.4 s of the reed under commands."""
    commands = tmp_path / "commands.csv"
    commands.write_text(COMMANDS)
    directory = tmp_path / "recording"
    code = call("rollout", scene, "--duration", 0.4, "--commands", commands, "--out", directory)
    assert code == 0
    return directory
