"""Numerics for scenes without any: the tip is right to 1e-3 of the length.

They are chosen once: by equilibria in the load cases of cases.py, each against a finer model, and
by a short motion against a companion that is finer in space and time. The integrator is
``adaptive``: it controls its error for any stiffness, while a fixed step would have to be searched
for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.sampler import Frames
from soft_sim_ros.core.mechanics.tips import apart
from soft_sim_ros.core.refine.prolong import finer, finer_scene, prolong, reference_turn, shown
from soft_sim_ros.core.refine.refinement import STEP_ERROR, Refinement, source_with
from soft_sim_ros.core.refine.space_error import UNWRITTEN, newton, tips_apart, trust
from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.errors import SolverError
from soft_sim_ros.scene import Free, Numerics, Scene

from .cases import cases, settle
from .drive import Drive, probe
from .search import top_orders

GOAL = UNWRITTEN  # of the tip's position over the length
SHARE = 0.4  # of it for statics, so that something is left for motion
BENDING, OTHER = 3, 1  # first orders of torsion and bending, and of stretch and shear
ROUNDS, MOTIONS = 6, 3  # of refinement: by statics, by motion
WORK = 600  # steps of the solver after which a motion has been looked at for long enough
MOST = 300  # coordinates beyond which nothing is refined
SHORT = 1.0  # s of the motion that is looked at


@dataclass(frozen=True)
class Settled:
    """The numerics chosen for a scene without numerics.

    scene : with complete numerics, also in its source
    error_rel : estimate of the tip's error over the length, in all that was tried
    """

    scene: Scene
    error_rel: float


_KNOWN: WeakKeyDictionary[Scene, Settled] = WeakKeyDictionary()


def is_unwritten(scene: Scene) -> bool:
    """Whether a scene names neither numerics nor a tolerance."""
    return bool(scene.numerics.free) and scene.numerics.tolerance is None


def first_guess(scene: Scene) -> Scene:
    """Return a scene with the numerics that a search begins with: its kernels are the same."""
    return replace(scene, numerics=replace(_first(scene), free=Free()))


def settle_unwritten(scene: Scene) -> Settled:
    """Choose the numerics of a scene that has none."""
    if scene not in _KNOWN:
        _KNOWN[scene] = _search(scene)
    return _KNOWN[scene]


def _search(scene: Scene) -> Settled:
    rules = Refinement(scene, GOAL)
    numerics, static = _by_statics(scene, rules, _first(scene))
    numerics, moving = _by_motion(scene, rules, numerics)
    fixed = replace(numerics, free=Free())
    chosen = replace(scene, numerics=fixed, source=source_with(scene, fixed))
    return Settled(chosen, max(static, moving))


def _first(scene: Scene) -> Numerics:
    """Return the first guess: fewer orders for rods of many sections."""
    numerics, rods = scene.numerics, {}
    sections = {body.name: len(getattr(body, "sections", ())) for body in scene.bodies}
    for name, basis in numerics.rods.items():
        high = max(1, BENDING - round(np.log2(max(1, sections[name]))))
        orders = {
            strain: high if strain in ("torsion", "bend_y", "bend_z") else min(high, OTHER)
            for strain in basis.order
        }
        rods[name] = replace(basis, order=orders)
    error = {"error": STEP_ERROR * GOAL}
    return replace(numerics, rods=rods, integrator="adaptive", options=error)


def _by_statics(scene: Scene, rules: Refinement, numerics: Numerics) -> tuple[Numerics, float]:
    """Return numerics that resolve the equilibria, and their estimated error."""
    if not numerics.rods:  # links and joints have nothing to choose
        return numerics, 0.0
    found: dict[int, tuple[Dynamics, Floats]] = {}
    worst = 0.0
    for _ in range(ROUNDS):
        model = Dynamics(_fixed(scene, numerics))
        fine = finer(model)
        worst, largest = 0.0, np.zeros(fine.n)
        for i, forcing in enumerate(cases(model)):
            guess = None
            if i in found:
                guess = prolong(found[i][0].compiled, model.compiled, found[i][1])
            q = settle(model, forcing, guess)
            start = None if q is None else prolong(model.compiled, fine.compiled, q)
            p = settle(fine, forcing) if start is None else newton(fine, start, forcing)
            if p is not None:
                np.maximum(largest, np.abs(p), out=largest)
                found[i] = fine, p
            if q is not None and p is not None:
                worst = max(worst, tips_apart(model, q, fine, p))
            elif q is not None or p is not None:
                worst = np.inf
        if worst <= SHARE * GOAL or model.n > MOST:
            break
        refined = _finer_space(rules, numerics, top_orders(fine, largest), worst)
        if refined == numerics:
            break
        numerics = refined
    return numerics, worst


def _by_motion(scene: Scene, rules: Refinement, numerics: Numerics) -> tuple[Numerics, float]:
    """Return numerics that resolve a short motion, and their estimated error."""
    drive: Drive | None = None
    best = numerics, np.inf
    for _ in range(MOTIONS):
        one = Simulation(_fixed(scene, numerics))
        other = Simulation(_finer(rules, one))
        drive = short(probe(one), one) if drive is None else drive
        error, largest = companions_apart(one, other, drive)
        if error < best[1]:
            best = numerics, error
        if error <= GOAL or one.n_coordinates > MOST:
            break
        numerics = rules.more_time(numerics, 4.0 * min(error / GOAL, 4.0))
        numerics = _finer_space(rules, numerics, top_orders(other, largest), error)
    return best


class _Enough(Exception):
    """A motion has used up its budget."""


def companions_apart(one: Simulation, other: Simulation, drive: Drive) -> tuple[float, Floats]:
    """Return the estimate of a tip's error over the length, by a finer companion, in a drive.

    Both are looked at as far as either comes within WORK steps of its method. Infinite where one
    of them gave up. Also the largest size of every coordinate (n,) of the companion.
    """
    largest = np.zeros(other.n_coordinates)
    runs: list[list[Floats]] = []
    for simulation in (one, other):
        sampler = simulation.tips()
        tips: list[Floats] = []
        first = simulation.statistics().steps

        def see(
            simulation: Simulation = simulation,
            sampler: Frames = sampler,
            tips: list[Floats] = tips,
            first: int = first,
        ) -> None:
            tips.append(sampler.poses()[:, :3].copy())
            if simulation is other:
                np.maximum(largest, np.abs(simulation.q), out=largest)
                if len(tips) == len(runs[0]):
                    raise _Enough
            if simulation.statistics().steps - first > WORK:
                raise _Enough

        try:
            drive.tip(simulation, see)
        except _Enough:
            pass
        except SolverError:
            return np.inf, largest
        runs.append(tips)
    looks = min(map(len, runs))
    away = apart(np.array(runs[0][:looks]), np.array(runs[1][:looks]), one.compiled)
    return trust(one.dynamics) * float(away.max()), largest


def short(drive: Drive, simulation: Simulation) -> Drive:
    """Return a drive that takes no longer than SHORT."""
    last = min(drive.last, max(1, round(SHORT * 1e9 / simulation.step_ns)))
    steps = drive.steps * last // max(1, drive.last)
    return Drive(steps, drive.efforts, last, max(1, last // 100))


def _finer_space(
    rules: Refinement, numerics: Numerics, top: Mapping[tuple[str, str], float], error: float
) -> Numerics:
    """Return numerics with higher orders where they are needed, or more nodes where they are not.

    top : (rod, strain) → how far over the length the two highest orders may move the tip
    """
    goal = 0.5 * SHARE * GOAL
    excess = {key: way / goal for key, way in top.items()}
    if max(excess.values(), default=0.0) > 1.0:
        return rules.more_space(numerics, excess)
    return rules.more_nodes(numerics, min(error / goal, 40.0))


def _finer(rules: Refinement, one: Simulation) -> Scene:
    """Return the companion's scene: finer in space, for what turns, and in time."""
    scene = finer_scene(one.scene, shown(reference_turn(one.compiled)))
    return replace(scene, numerics=rules.finer_time(scene.numerics))


def _fixed(scene: Scene, numerics: Numerics) -> Scene:
    return replace(scene, numerics=replace(numerics, free=Free()))
