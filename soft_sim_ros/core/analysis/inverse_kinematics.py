"""Efforts under which the arm at rest holds its tip at a target.

The tip follows the efforts τ through equilibria r(q, τ) = 0, so with y the tip's pose

    dq/dτ = K⁻¹ B,    dy/dτ = J K⁻¹ B,

K the exact stiffness under all loads and B the generalised forces of unit efforts, both in the
directions that constraints leave free. Gauss–Newton steps with these sensitivities, bounded by
limits and by a trust region, meet the target; steps that keep it to first order, each followed by
steps back to it, then make the effort least.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from soft_sim_ros.core.arguments import vector
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.refine.space_error import Forcing, tell_if_coarse
from soft_sim_ros.errors import StaticsFailed, TargetUnreachable

from .tip_target import Point, Reach, Task, make_task, tip_sensitivity

__all__ = ["Reach", "inverse_kinematics", "tip_sensitivity"]

FIRST_RADIUS, LEAST_RADIUS, LARGEST_RADIUS = 0.2, 1e-9, 1.0  # arm lengths that one effort may move
APPROACHES, EASINGS = 80, 200


def inverse_kinematics(
    dynamics: Dynamics,
    position: Floats | None = None,
    rotation: Floats | None = None,
    *,
    start: Floats | None = None,
    limits: Floats | None = None,
    weights: Floats | None = None,
    time: float = 0.0,
    tip: Floats | None = None,
    tip_follows: bool = False,
    tolerance: float = 1e-8,
    tries: int = 6,
    exact: bool = True,
    check: bool | None = None,
    frame: str | None = None,
) -> Reach:
    """Return the least efforts that hold a frame, at rest, at a position and in an orientation.

    Parameters
    ----------
    dynamics : the arm
    position : (3,) in m, world; None leaves it open
    rotation : (3, 3) rotation matrix of the frame in the world; None leaves it open
    start : (A,) efforts to begin from; safe efforts by default
    limits : (2, A) least and largest efforts; those of the scene by default
    weights : (A,) an effort costs (weight · effort)². By default an effort is measured by its
        largest limit, if it has one
    time, tip, tip_follows : loads as in ``statics.equilibrium``
    tolerance : largest error that counts as reached, arm lengths and rad
    tries : how many starts: after the first, random ones within finite limits, always the same
    exact : whether a target out of reach is an error; otherwise the nearest pose is the result
    frame : name of a body, whose end is held; the tip, the last of all ends, by default
    check : whether to ask a finer basis, once, how far off the tip of the result is, and to warn;
        by default, where the scene's author wrote no basis

    Warns
    -----
    NotResolved
        if basis and nodes are too coarse for the result (``check``, as in ``statics.equilibrium``)

    Raises
    ------
    TargetUnreachable
        (``exact``) if no efforts within the limits were found that lead there; it says how near
        the tip came, and its ``closest`` is the Reach
    StaticsFailed
        if the arm has no equilibrium to begin from.

    Notes
    -----
    Which of several solutions is found depends on the start. If both position and orientation
    are asked for, an arm length counts as much as a radian.
    """
    task = make_task(dynamics, position, rotation, limits, weights, tolerance, frame)
    task.loads = {"time": time, "tip": tip, "tip_follows": tip_follows}
    best: Point | None = None
    starts = _starts(task, start, tries)
    for efforts in starts:
        try:
            point = _approach(task, task.at(efforts, None))
        except StaticsFailed:
            continue
        if best is None or point.size < best.size:
            best = point
        if best.size <= tolerance:
            break
    if best is None:  # it returns a point or raises the reason
        best = _approach(task, task.at(starts[0], None, thorough=True))
    if best.size <= tolerance:
        reach = task.result(_ease(task, best))
    else:
        reach = task.result(best)
        if exact:
            raise TargetUnreachable(reach.distance, reach.angle, reach)
    if check or (check is None and not dynamics.compiled.scene.numerics.space_written):
        tell_if_coarse(dynamics, reach.q, Forcing(reach.efforts, time, 1.0, tip, tip_follows))
    return reach


def _starts(task: Task, start: Floats | None, tries: int) -> list[Floats]:
    """Return efforts to begin from."""
    actuators = task.dynamics.compiled.scene.actuators
    safe = [actuator.safe for actuator in actuators]
    first = vector("start", safe if start is None else start, len(actuators))
    low, high = task.bounds
    rng = np.random.default_rng(0)
    starts = [np.clip(first, low, high)]
    if np.isfinite(task.bounds).all():
        starts += [low + rng.uniform(0.1, 0.9, len(low)) * (high - low) for _ in range(tries - 1)]
    return starts


def _bounded_step(
    matrix: Floats, right: Floats, task: Task, efforts: Floats, reach: Floats, radius: float
) -> Floats:
    """Return argmin |matrix δ − right| within limits and trust region; reach: see sensitivities."""
    room = radius / reach
    low = np.maximum(task.bounds[0] - efforts, -room)
    high = np.minimum(task.bounds[1] - efforts, room)
    free = high > low
    step = np.zeros(len(efforts))
    if free.any():
        # in units in which every effort moves the arm alike
        unit = 1.0 / reach[free]
        scaled = lsq_linear(
            matrix[:, free] * unit, right, (low[free] / unit, high[free] / unit), tol=1e-14
        )
        step[free] = scaled.x * unit
    return np.clip(step, low, high)


def _approach(task: Task, point: Point, radius: float = FIRST_RADIUS) -> Point:
    """Return a point at the target, or one that no small change of the efforts brings nearer."""
    for _ in range(APPROACHES):
        if point.size <= 1e-3 * task.tolerance:
            break
        moved, radius = _nearer(task, point, radius)
        if moved is None:
            moved, radius = _pulled_in(task, point), FIRST_RADIUS
        if moved is None:
            break
        point = moved
    return point


def _nearer(task: Task, point: Point, radius: float) -> tuple[Point | None, float]:
    """Return a point nearer to the target that a step leads to, if any, and the next radius."""
    try:
        slope, reach = task.sensitivities(point)
    except np.linalg.LinAlgError:
        return None, radius
    slack = 1e-6 * np.diag(reach)  # of all steps that do, the one that moves the arm least
    matrix = np.vstack([slope, slack])
    right = np.concatenate([point.error, np.zeros(len(slack))])
    while radius > LEAST_RADIUS:
        step = _bounded_step(matrix, right, task, point.efforts, reach, radius)
        expected = point.size - float(np.linalg.norm(point.error - slope @ step))
        if expected <= 1e-9 * point.size:
            break
        moved = _moved(task, point, step)
        gain = (point.size - moved.size) / expected if moved is not None else -1.0
        if gain >= 0.1:
            return moved, min(2.0 * radius, LARGEST_RADIUS) if gain > 0.7 else radius
        radius *= 0.3
    return None, radius


def _pulled_in(task: Task, point: Point) -> Point | None:
    """Return a point nearer to the target, reached by pulling in one slack tendon.

    Of those whose pull brings the tip nearer, the one that does so most directly.
    """
    best, step = None, 0.0
    for i, taut in task.slack(point).items():
        try:
            slope, reach = task.pulling(point, i, taut)
        except np.linalg.LinAlgError:
            continue
        gain = float(slope @ point.error)
        directness = gain / (np.linalg.norm(slope) * point.size + 1e-300)
        if directness > 1e-3 and (best is None or directness > best[0]):
            best = (directness, i, taut)
            step = min(gain / float(slope @ slope), FIRST_RADIUS / reach)
    while best is not None and step > 0.0:
        efforts = point.efforts.copy()
        efforts[best[1]] = np.clip(best[2] + step, *task.bounds[:, best[1]])
        moved = _moved(task, point, efforts - point.efforts)
        if moved is not None and moved.size < (1.0 - 1e-3) * point.size:
            return moved
        step = 0.3 * step if step > 1e-7 * task.dynamics.compiled.length else 0.0
    return None


def _moved(task: Task, point: Point, step: Floats) -> Point | None:
    try:
        return task.at(point.efforts + step, point.q)
    except StaticsFailed:
        return None


def _ease(task: Task, point: Point) -> Point:
    """Return the point at the target with the least weighted effort near ``point``."""
    radius = FIRST_RADIUS
    for _ in range(EASINGS):
        cost = float(np.linalg.norm(task.weights * point.efforts))
        slope, reach = task.sensitivities(point)
        # keeping the target counts far more than the effort
        stress = 1e5 * np.linalg.norm(task.weights / reach)
        matrix = np.vstack([stress * slope, np.diag(task.weights)])
        right = np.concatenate([stress * point.error, -task.weights * point.efforts])
        eased = None
        while eased is None and radius > LEAST_RADIUS:
            step = _bounded_step(matrix, right, task, point.efforts, reach, radius)
            if np.abs(step * reach).max() <= task.tolerance:
                return point
            moved = _moved(task, point, step)
            if moved is not None:
                moved = _approach(task, moved)
            lighter = (
                moved is not None
                and moved.size <= task.tolerance
                and (np.linalg.norm(task.weights * moved.efforts) < cost)
            )
            if lighter:
                eased, radius = moved, min(2.0 * radius, LARGEST_RADIUS)
            else:
                radius *= 0.3
        if eased is None:
            break
        point = eased
    return point
