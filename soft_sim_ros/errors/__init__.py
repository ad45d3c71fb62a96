"""Every error this package raises on purpose: each keeps its numbers and prints them."""

from .accuracy import NotResolved, SearchSpent, ToleranceMissed
from .base import SoftSimError
from .call import BadArgument, CommandError, DeriveError, MissingExtra, NoSuchPlace, NotCopied
from .recording import RecordingError, TornRecording, UnfitFile
from .scene import SceneError
from .solver import (
    Diverged,
    EnergyGained,
    Inaccurate,
    NewtonFailed,
    NoBranch,
    NotMet,
    SolverError,
    StaticsFailed,
    TargetUnreachable,
    UndampedFlutter,
)
from .state import OtherModel, StateError

__all__ = [
    "BadArgument",
    "CommandError",
    "DeriveError",
    "Diverged",
    "EnergyGained",
    "Inaccurate",
    "MissingExtra",
    "NewtonFailed",
    "NoBranch",
    "NoSuchPlace",
    "NotCopied",
    "NotMet",
    "NotResolved",
    "OtherModel",
    "RecordingError",
    "SceneError",
    "SearchSpent",
    "SoftSimError",
    "SolverError",
    "StateError",
    "StaticsFailed",
    "TargetUnreachable",
    "ToleranceMissed",
    "TornRecording",
    "UndampedFlutter",
    "UnfitFile",
]
