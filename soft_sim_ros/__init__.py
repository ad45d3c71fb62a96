"""Soft manipulators as Cosserat rods: simulate, command through ROS 2, record to MCAP, replay.

Importing the package costs nothing: what it offers is loaded when it is first asked for, so
reading a recording needs no solver and checking a scene needs no ROS.

The public interface is what ``__all__`` lists, and the public attributes of these classes. All
else is private, whatever its name: it may change between any two versions.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from soft_sim_ros.version import __version__

if TYPE_CHECKING:  # what type checkers see of what follows
    from soft_sim_ros.batch import Rollout as Rollout
    from soft_sim_ros.batch import read_sweep as read_sweep
    from soft_sim_ros.batch import run_batch as run_batch
    from soft_sim_ros.core.accuracy.contract import settle as settle
    from soft_sim_ros.core.analysis.continuation import Branch as Branch
    from soft_sim_ros.core.analysis.continuation import follow as follow
    from soft_sim_ros.core.analysis.continuation import switch as switch
    from soft_sim_ros.core.analysis.inverse_kinematics import (
        inverse_kinematics as inverse_kinematics,
    )
    from soft_sim_ros.core.analysis.linearisation import Linearisation as Linearisation
    from soft_sim_ros.core.analysis.linearisation import linearise as linearise
    from soft_sim_ros.core.analysis.modes import complex_modes as complex_modes
    from soft_sim_ros.core.analysis.modes import frequencies as frequencies
    from soft_sim_ros.core.analysis.modes import modes as modes
    from soft_sim_ros.core.analysis.statics import equilibrium as equilibrium
    from soft_sim_ros.core.compile.scene import Compiled as Compiled
    from soft_sim_ros.core.compile.scene import compile_scene as compile_scene
    from soft_sim_ros.core.settled import Dynamics as Dynamics
    from soft_sim_ros.core.settled import Simulation as Simulation
    from soft_sim_ros.core.simulation.start import initial_state as initial_state
    from soft_sim_ros.core.simulation.state import SimulationState as SimulationState
    from soft_sim_ros.core.terms.custom import register_load as register_load
    from soft_sim_ros.errors import CommandError as CommandError
    from soft_sim_ros.errors import OtherModel as OtherModel
    from soft_sim_ros.errors import RecordingError as RecordingError
    from soft_sim_ros.errors import SceneError as SceneError
    from soft_sim_ros.errors import SoftSimError as SoftSimError
    from soft_sim_ros.errors import SolverError as SolverError
    from soft_sim_ros.errors import StateError as StateError
    from soft_sim_ros.experiments import Comparison as Comparison
    from soft_sim_ros.experiments import Measured as Measured
    from soft_sim_ros.experiments import Recorded as Recorded
    from soft_sim_ros.experiments import identify as identify
    from soft_sim_ros.experiments import read_motion as read_motion
    from soft_sim_ros.experiments import rerun as rerun
    from soft_sim_ros.recording.reader import read_run as read_run
    from soft_sim_ros.report import write_report as write_report
    from soft_sim_ros.scene import Scene as Scene
    from soft_sim_ros.scene import load_scene as load_scene
    from soft_sim_ros.scene import packaged_scenes as packaged_scenes
    from soft_sim_ros.scene import parse_scene as parse_scene
    from soft_sim_ros.scene import register_law as register_law
    from soft_sim_ros.scene import register_profile as register_profile


# module → public names in it
_HOMES = {
    "batch": ("Rollout", "read_sweep", "run_batch"),
    "core.analysis.continuation": ("Branch", "follow", "switch"),
    "core.accuracy.contract": ("settle",),
    "core.analysis.inverse_kinematics": ("inverse_kinematics",),
    "core.analysis.linearisation": ("Linearisation", "linearise"),
    "core.analysis.modes": ("complex_modes", "frequencies", "modes"),
    "core.compile.scene": ("Compiled", "compile_scene"),
    "core.settled": ("Dynamics", "Simulation"),
    "core.simulation.start": ("initial_state",),
    "core.terms.custom": ("register_load",),
    "core.simulation.state": ("SimulationState",),
    "core.analysis.statics": ("equilibrium",),
    "errors": (
        *("CommandError", "OtherModel", "RecordingError", "SceneError", "SoftSimError"),
        *("SolverError", "StateError"),
    ),
    "experiments": (
        *("Comparison", "Measured", "Recorded"),
        *("identify", "read_motion", "rerun"),
    ),
    "recording.reader": ("read_run",),
    "report": ("write_report",),
    "scene": (
        *("Scene", "load_scene", "packaged_scenes", "parse_scene"),
        *("register_law", "register_profile"),
    ),
}
_HOME = {name: f"{__name__}.{module}" for module, names in _HOMES.items() for name in names}
__all__ = [
    "__version__",
    *_HOME,
]


if not TYPE_CHECKING:  # for them, a name that is not above does not exist

    def __getattr__(name: str) -> Any:
        """Import the module that holds a public name when the name is first used."""
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
