"""The coordinates that a scene begins in, and whether motion can go on from there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.pairs import asked_pairs
from soft_sim_ros.core.compile.start import given_coordinates
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.contacts import ContactReader
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.errors import SceneError, StaticsFailed

# Beyond this many coordinates the mass matrix is not looked at as a whole.
MASS_CHECKED = 600
DEEPEST = 0.05  # of the radius: bodies may begin deeper in a shape than they rest on it
VANISHING = 1e-14  # the least eigenvalue of a mass matrix with ones on its diagonal


def initial_coordinates(dynamics: Dynamics, efforts: Floats) -> tuple[Floats, Floats]:
    """Return coordinates and rates (n,) of the scene's initial state.

    efforts : (A,) what the actuators hold in an equilibrium

    Raises
    ------
    StaticsFailed
        if an equilibrium is asked for and not found
    """
    model, chain = dynamics.model, dynamics.compiled.chain
    initial = dynamics.compiled.scene.initial
    q, given = given_coordinates(chain, initial)
    v = np.zeros(dynamics.n)
    for name, value in initial.velocities.items():
        v[chain.columns(name)] = value
    for first in model.chart:
        # what is given is the angular velocity in the frame after the joint
        tangent = se3.right_tangent(np.concatenate([q[first : first + 3], np.zeros(3)]))[:3, :3]
        v[first : first + 3] = np.linalg.solve(tangent, v[first : first + 3])
    for _, first, _ in model.free.tolist():
        turn = se3.exp(np.concatenate([q[first : first + 3], np.zeros(3)]))[:3, :3]
        v[first + 3 : first + 6] = turn @ v[first + 3 : first + 6]
    refuse_overlaps(dynamics, q)
    if initial.state == "equilibrium":
        # joints with a given position hold it: what is asked for is the shape around them
        try:
            q = equilibrium(dynamics, q, efforts=efforts, free=~given, check=False)
        except StaticsFailed as failure:
            raise _explained(dynamics, failure, given) from None
    return q, v


def refuse_overlaps(dynamics: Dynamics, q: Floats) -> None:
    """Refuse bodies that begin, at q (n,), in shapes that do not allow it.

    Raises
    ------
    SceneError
        which names the pair that overlaps most
    """
    if not len(dynamics.model.contact.node):
        return
    scene = dynamics.compiled.scene
    allowed = {shape.name for shape in scene.environment if shape.overlap}
    worst = None
    pairs = {pair.bodies: pair for pair in asked_pairs(scene)}
    for contact in ContactReader(dynamics.compiled).near(q, np.zeros(dynamics.n)):
        pair = pairs.get((contact.body, contact.shape)) or pairs.get((contact.shape, contact.body))
        if pair is not None and pair.overlap:
            continue
        if contact.shape in allowed or contact.gap >= -DEEPEST * contact.radius:
            continue
        if worst is None or contact.gap < worst.gap:
            worst = contact
    if worst is not None and worst.s_there is not None:
        pair = pairs.get((worst.body, worst.shape)) or pairs[worst.shape, worst.body]
        expected = (
            f"bodies that do not begin in one another: {worst.body} at s = {worst.s:.4g} m is "
            f"{-worst.gap:.3g} m in {worst.shape} at s = {worst.s_there:.4g} m (overlap: true "
            "allows it)"
        )
        raise SceneError(scene.file, pair.key, " and ".join(pair.bodies), expected)
    if worst is not None:
        i = [shape.name for shape in scene.environment].index(worst.shape)
        expected = (
            f"a shape that does not overlap what begins beside it: {worst.body} is "
            f"{-worst.gap:.3g} m in it at s = {worst.s:.4g} m (overlap: true allows it)"
        )
        kind = scene.environment[i].kind
        raise SceneError(scene.file, f"environment[{i}].{kind}", worst.shape, expected)


def _explained(
    dynamics: Dynamics, failure: StaticsFailed, given: NDArray[np.bool_]
) -> StaticsFailed:
    """Return the failure with the joints that nothing holds, or what else may be done."""
    diagonal = np.diag(dynamics.stiffness_matrix())
    loose = [
        name
        for name, columns in dynamics.compiled.chain.joints.items()
        if np.any((diagonal[columns] == 0.0) & ~given[columns])
    ]
    advice = "start from initial.state: reference and let it fall"
    if loose:
        keys = ", ".join(f"initial.positions.{name}" for name in loose)
        advice = f"joints without stiffness can be held by {keys}"
    why = f"{failure.why}; {advice}" if failure.why else advice
    return StaticsFailed(failure.load_factor, failure.residual, failure.time, why)


def check_mass(dynamics: Dynamics, q: Floats) -> None:
    """Refuse coordinates (n,) that move no mass: their motion has no equation.

    Driven ones need none.

    Raises
    ------
    SceneError
        which names one of them
    """
    if not 0 < dynamics.n <= MASS_CHECKED:
        return
    own = np.flatnonzero(dynamics.free)  # driven ones need none
    if not len(own):
        return
    mass = dynamics.mass_matrix(q)[np.ix_(own, own)]
    diagonal = np.diag(mass)
    worst = int(np.argmin(diagonal))
    vanishes = not diagonal[worst] > 0.0
    if not vanishes:
        # in these units every coordinate has unit mass: what vanishes is a combination of them
        scaled = mass / np.sqrt(np.outer(diagonal, diagonal))
        if _clearly_positive(scaled):
            return
        values, shapes = np.linalg.eigh(scaled)
        worst, vanishes = int(np.argmax(np.abs(shapes[:, 0]))), not values[0] > VANISHING
    if vanishes:
        name = dynamics.compiled.coordinate_names[own[worst]]
        expected = f"a mass that its coordinate {name!r} moves (more nodes, or a body after it)"
        scene = dynamics.compiled.scene
        raise SceneError(scene.file, "bodies", scene.name, expected)


def _clearly_positive(matrix: Floats) -> bool:
    """Return whether all eigenvalues are far above VANISHING: to tell takes less than they do."""
    try:
        np.linalg.cholesky(matrix - 100.0 * VANISHING * np.eye(len(matrix)))
    except np.linalg.LinAlgError:
        return False
    return True
