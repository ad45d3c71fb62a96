"""Soft manipulators as Cosserat rods: simulate, command through ROS 2, record to MCAP, replay.

Importing the package costs nothing: what it offers is loaded when it is first asked for, so
reading a recording needs no solver and checking a scene needs no ROS.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what type checkers see of what follows
    from soft_sim_ros.core.settled import Simulation as Simulation
    from soft_sim_ros.recording.reader import read_run as read_run
    from soft_sim_ros.scene import load_scene as load_scene

__version__ = "0.1.0"
__all__ = ["Simulation", "__version__", "load_scene", "read_run"]

_HOME = {
    "load_scene": "soft_sim_ros.scene",
    "read_run": "soft_sim_ros.recording.reader",
    "Simulation": "soft_sim_ros.core.settled",
}


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
