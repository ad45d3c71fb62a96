"""Refuses scenes whose valid numbers lead to infinite or undefined ones (overflow)."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Loads, Model
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.numerics import LONGEST_STEP

LATEST = 2**63 - 1  # ns: times are signed 64-bit numbers
# array of the model or of the loads → its meaning, and the key of the scene behind it
SOURCES = {
    "half": ("the length of a segment", "bodies"),
    "kappa": ("the square of a length", "bodies"),
    "xi0": ("a reference strain", "bodies"),
    "entry_phi": ("a trial function", "numerics.basis"),
    "inertia": ("a mass or a moment of inertia", "bodies"),
    "mass_damping": ("a mass or a moment of inertia times rayleigh.mass", "materials"),
    "stiffness": ("a stiffness", "materials"),
    "damping": ("a damping", "materials"),
    "branch": ("the stiffness of a Maxwell branch", "materials"),
    "branch_time": ("the time of a Maxwell branch", "materials"),
    "points": ("a fibre of a section", "materials"),
    "laws": ("a law of a material", "materials"),
    "knots": ("a law of a material", "materials"),
    "weight": ("how far a coordinate moves the tip", "bodies"),
    "port_gain": ("the gain of an actuator", "actuators"),
    "tendon_path": ("the path of a tendon or a chamber", "actuators"),
    "tendon_rest": ("the length of a tendon or a chamber", "actuators"),
    "length_control": ("the stiffness or damping of a tendon", "actuators"),
    "friction": ("the friction of a tendon", "actuators"),
    "wrench": ("a wrench on a node", "loads"),
    "added": ("an added mass", "fluid"),
    "displaced": ("the mass of displaced fluid", "fluid"),
    "quadratic": ("a drag", "fluid"),
    "viscous": ("a drag", "fluid"),
    "lift": ("a lift", "fluid"),
    "end": ("the pressure on an end", "fluid"),
    "law": ("the law of a contact", "contact"),
    "bound": ("the size of a shape", "environment"),
    "centre": ("the place of a shape", "environment"),
}


def refuse_overflow(scene: Scene, model: Model, loads: Loads) -> None:
    """Refuse a scene whose numbers are allowed one by one but overflow when combined.

    Raises
    ------
    SceneError
        which names the quantity that is not finite
    """
    for part in (model, model.fibres, model.fluid, model.contact, model.pairs, loads):
        for name, array in part._asdict().items():
            if name not in SOURCES or np.isfinite(array).all():
                continue
            what, key = SOURCES[name]
            wrong = float(array[~np.isfinite(array)][0])
            expected = f"numbers of more usual size: {what}, made of them, is {wrong}"
            raise SceneError(scene.file, key, scene.name, expected)


def refuse_energy(scene: Scene, ledger: Floats) -> None:
    """Refuse a scene whose initial energies (7,) in J are not finite.

    Raises
    ------
    SceneError
        which gives them
    """
    if not np.isfinite(ledger).all():
        kinetic, elastic, gravity = ledger[:3].tolist()
        energies = f"kinetic {kinetic:g} J, elastic {elastic:g} J, of the weight {gravity:g} J"
        expected = f"numbers of more usual size: the energies that it begins with are {energies}"
        raise SceneError(scene.file, "initial", scene.name, expected)


def whole_nanoseconds(scene: Scene) -> int:
    """Return the step of a scene in ns, checked: scenes may be built in Python, unchecked.

    Raises
    ------
    SceneError
        if it is not a positive number, or is longer than LONGEST_STEP
    """
    step = scene.numerics.step
    if not 0.5e-9 < step <= LONGEST_STEP:
        expected = f"a time in s that is a whole number of nanoseconds, at most {LONGEST_STEP:g}"
        raise SceneError(scene.file, "numerics.step", step, expected)
    return round(step * 1e9)
