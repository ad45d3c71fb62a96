"""Static load cases that the discretisation of an arm must resolve: loads and actuators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.tips import tip_ways
from soft_sim_ros.core.refine.space_error import Forcing, newton, static_error

# An actuator without limits is assumed to turn the tip by half a turn, or to move it by this part
# of the length, in linear theory; a wrench not known beforehand is assumed to move it by PUSH.
TURN, WAY, PUSH = np.pi, 1.5, 0.3
DRAWN = 2  # corners beside the highest and the lowest
TIMES = 3  # at which loads act differently, at most
# Loads grow in this many steps; a case not reached by them is dropped. Coordinates without
# stiffness are held by their inertia, as in a motion of PERIOD s.
PARTS, PERIOD = (1, 4, 16), 2.0


@dataclass
class Case:
    """One state of rest.

    Parameters
    ----------
    forcing : loads, efforts and tip wrench
    q : (n,) the equilibrium of some model of the scene
    """

    forcing: Forcing
    q: Floats


def cases(dynamics: Dynamics) -> list[Forcing]:
    """Return the forcings that may act on an arm, the same ones at every call.

    At rest with safe efforts, whenever scheduled loads act; all actuators at their upper and lower
    limits and at corners drawn between; a push at the tip in two directions.
    """
    scene = dynamics.compiled.scene
    safe = np.array([actuator.safe for actuator in scene.actuators], dtype=float)
    times = [0.0]
    for load in scene.scheduled_loads:
        begin, end = load.schedule.start + load.schedule.ramp, load.schedule.end
        times.append(begin if np.isinf(end) else max(begin, 0.5 * (begin + end)))
    times = sorted(set(times))[-TIMES:]
    out = [Forcing(safe, time) for time in times]
    turns, ways = _responses(dynamics)
    if len(safe):
        signs = np.random.default_rng(2).choice([-1.0, 1.0], (DRAWN, len(safe)))
        corners = np.vstack([np.ones(len(safe)), -np.ones(len(safe)), signs])
        out += [Forcing(_corner(dynamics, row, turns, ways), times[-1]) for row in corners]
    out += [Forcing(safe, times[-1], 1.0, tip) for tip in _pushes(dynamics)]
    return out


def settle(dynamics: Dynamics, forcing: Forcing, q: Floats | None = None) -> Floats | None:
    """Return an equilibrium (n,) from q or from the reference shape, loads growing; or None."""
    if q is not None and (found := newton(dynamics, q, forcing)) is not None:
        return found
    for parts in PARTS:
        state: Floats | None = np.zeros(dynamics.n)
        for k in range(1, parts + 1):
            now = forcing._replace(share=forcing.share * k / parts)
            state = None if state is None else newton(dynamics, state, now)
        if state is not None:
            return state
    return None


def error_of(dynamics: Dynamics, forcing: Forcing) -> tuple[float, Floats | None]:
    """Return the error in space of a case over the length, and its equilibrium, if there is one."""
    q = settle(dynamics, forcing)
    return (0.0, None) if q is None else (static_error(dynamics, q, forcing), q)


def _responses(dynamics: Dynamics) -> tuple[Floats, Floats]:
    """Return by how much unit efforts turn and move tips by small motion (T, 3, A), rad and m."""
    if not dynamics.actuators or not dynamics.n:
        none = np.zeros((len(dynamics.compiled.tips), 3, dynamics.actuators))
        return none, none
    zero = np.zeros(dynamics.n)
    free, efforts = dynamics.free, dynamics.effort_matrix(zero)
    moves = np.zeros(efforts.shape)
    moves[free] = np.linalg.solve(_held(dynamics)[np.ix_(free, free)], efforts[free])
    return tip_ways(dynamics, moves, zero)


def _held(dynamics: Dynamics) -> Floats:
    """Return a stiffness (n, n) that holds every coordinate: inertia helps where there is none."""
    mass = dynamics.mass_matrix(np.zeros(dynamics.n))
    return dynamics.stiffness_matrix() + mass * (2.0 * np.pi / PERIOD) ** 2


def _corner(dynamics: Dynamics, signs: Floats, turns: Floats, ways: Floats) -> Floats:
    """Return efforts (A,) at the limits, or without limits, those that move the tip enough."""
    length = dynamics.compiled.length

    def most(how: Floats) -> Floats:
        """Return the part of what may be that tips turn or move by: columns of how (A, k)."""
        parts = [np.linalg.norm(x @ how, axis=1).max(axis=0) for x in (turns, ways)]
        return np.maximum(parts[0] / TURN, parts[1] / (WAY * length))

    reach = most(np.eye(len(signs)))
    efforts, open_ended = np.zeros(len(signs)), np.zeros(len(signs), dtype=bool)
    for i, actuator in enumerate(dynamics.compiled.scene.actuators):
        limit = actuator.limits[1 if signs[i] > 0.0 else 0]
        open_ended[i] = not np.isfinite(limit)
        efforts[i] = signs[i] / max(reach[i], 1e-300) if open_ended[i] else limit
    together = np.where(open_ended, efforts, 0.0)
    return np.where(open_ended, efforts / max(1.0, float(most(together[:, None])[0])), efforts)


def _pushes(dynamics: Dynamics) -> list[Floats]:
    """Return wrenches (6,) at the tip, along world axes: two oblique forces that move it by PUSH.

    None for an arm that is rigid.
    """
    if not dynamics.n:
        return []
    jacobian = dynamics.tip_jacobian(np.zeros(dynamics.n))[3:]
    frame = dynamics.node_poses(np.zeros(dynamics.n))[-1][:3, :3]
    free = dynamics.free
    jacobian = jacobian[:, free]
    yields = jacobian @ np.linalg.solve(_held(dynamics)[np.ix_(free, free)], jacobian.T)
    out = []
    for direction in ([0.2, 1.0, 0.3], [-0.1, -0.3, 1.0]):
        unit = np.array(direction) / np.linalg.norm(direction)
        way = float(np.linalg.norm(yields @ unit))
        if way > 0.0:
            force = frame @ (PUSH * dynamics.compiled.length / way * unit)
            out.append(np.concatenate([np.zeros(3), force]))
    return out
