"""Fit numbers of a scene, such as stiffness, damping, density, to a measured motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from soft_sim_ros.core.analysis.identification import Fit, fit
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import CommandError
from soft_sim_ros.experiments.motions import Experiment
from soft_sim_ros.scene.edit import number_at, with_numbers


def identify(
    experiment: Experiment,
    parameters: Mapping[str, float | None],
    *,
    confidence: float = 0.95,
    progress: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Return the numbers of a scene with which its motion is nearest to the one measured.

    Parameters
    ----------
    experiment : ``Recorded`` or ``Measured``
    parameters : key path in the scene, as ``materials.rubber.density`` → first guess; None = what
        the scene says
    confidence : probability of the intervals
    progress : called with the number of every simulation

    Raises
    ------
    SceneError
        if a key path leads to no number
    SolverError
        if the scene cannot be simulated with the first guesses
    """
    names = list(parameters)
    start = [
        number_at(experiment.text, experiment.file, name) if guess is None else guess
        for name, guess in parameters.items()
    ]
    for name, guess in zip(names, start, strict=True):
        if guess == 0.0 or not np.isfinite(guess):
            raise CommandError(name, f"cannot be fitted from {guess:g}: give another first guess")
    count = 0

    def predict(values: Floats, instants: int) -> Floats:
        nonlocal count
        count += 1
        progress(count)
        changes = dict(zip(names, values.tolist(), strict=True))
        return experiment.predict(with_numbers(experiment.text, experiment.file, changes), instants)

    return fit(names, np.array(start), predict, experiment.measured, confidence=confidence)
