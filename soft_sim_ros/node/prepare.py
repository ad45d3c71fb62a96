"""What has to be there before the arm can move: compiled kernels, and numerics that are chosen."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import contextmanager

from soft_sim_ros.core.accuracy.contract import choose, draft
from soft_sim_ros.core.accuracy.unwritten import is_unwritten, settle_unwritten
from soft_sim_ros.core.analysis.modes import long_step
from soft_sim_ros.core.backend.compilation import compilations
from soft_sim_ros.core.refine.refinement import words
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.node.parameters import Settings
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.limbs import limbs_of


def warm_up(scene: Scene, settings: Settings, say) -> str | None:
    """Compile everything the run needs with another arm; return what is doubtful about its step."""

    def what() -> str:
        if compiled.going_on():
            return f"compiling kernels (kept for the next start), {len(compiled.names)} so far"
        return "loading the kernels"

    with compilations() as compiled, _patience(say, what):
        arm = Simulation(draft(scene))
        arm.advance(1)
        limbs = limbs_of(arm.scene)
        telemetry = Telemetry(arm, settings.poses, settings.frame_id, "/warm_up", limbs=limbs)
        for build in telemetry.builders.values():
            build()
        return long_step(arm.dynamics, arm.q, arm.scene.numerics)


def simulation_of(scene: Scene, say: Callable[[str], None]) -> Simulation:
    """Make the simulation; say what is chosen where the scene leaves something free."""
    if not scene.numerics.free:
        return Simulation(scene)
    if is_unwritten(scene):
        with _patience(say, lambda: "choosing numerics, since none are written"):
            chosen = settle_unwritten(scene)
        say(f"numerics chosen, since none are written: {words(chosen.scene.numerics)}")
        return Simulation(chosen.scene)
    with _patience(say, lambda: "choosing what meets the tolerance"):
        choice = choose(scene, say=say)
    say(f"meets the tolerance in a probe: {words(choice.scene.numerics)}")
    return Simulation(choice.scene)


@contextmanager
def _patience(say, what: Callable[[], str], period: float = 5.0):
    """Say every few seconds what is being waited for."""
    done = threading.Event()
    begin = time.monotonic()

    def report() -> None:
        while not done.wait(period):
            say(f"{what()}: {time.monotonic() - begin:.0f} s")

    reporter = threading.Thread(target=report, daemon=True)
    reporter.start()
    try:
        yield
    finally:
        done.set()
        reporter.join()
