"""The state of a simulation as a value: all that decides how it goes on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from soft_sim_ros.core.floats import Floats, Ints

from .mark import ModelMark
from .memory import SolverMemory
from .value import Value
from .value_file import load, save

FORMAT = "soft_sim_ros state 3"


@dataclass(frozen=True, eq=False)
class SimulationState(Value):
    """All that decides how a simulation goes on: an immutable value.

    It can be compared (bit by bit), hashed, pickled, kept and put into a file. Put back with
    `Simulation.restore` it goes on with the same bits, in any simulation of the same model.

    Attributes
    ----------
    model : what a simulation must be of to take it
    step_index : steps made
    q, v : (n,) coordinates and their rates
    dashpots : (2, n) coordinates and rates of the dashpots of Maxwell branches; (2, 0) without any
    efforts : (A,) held, in N·m, N or Pa; m of a tendon whose length is commanded
    wrench : (6,) held at the tip, moment in N·m and force in N, along the axes of the base or, if
        ``wrench_follows``, of the tip
    wrench_follows : whether it turns with the tip
    pushes : (W, 6) wrenches at places of their own, in the order of the loads, likewise
    pushes_follow : (W,) 1: along the axes of the section
    courses : (D, 9) what driven coordinates were last commanded, as in ``Live.course``
    attached : (P,) 1: a payload of the scene is attached, 0: it is not
    dissipated, load_work : J since the ledger began
    actuator_work : J, up to the last change of an effort
    reference : J, the energy that the ledger began with
    ports : (A,) port positions at the last change of an effort
    held : (K, 13) of constraints: 0 released, 1 held, 2 by schedule; the second frame in that of
        its node, rotation by rows and position in m
    acts : (K,) 1 if it acted in the last step
    multipliers : (R,) of the rows of all constraints, N along an axis or N·m about one
    solver : what the solver remembers
    bristles : (4 B,) of friction in contact, B numbers of all stations: deflections in m and what
        they hold on to; at both ends of the present step of the adaptive method; their rates at
        its end. (0,) without contact
    sensed : (R,) readings of sensors, in their order, each row the index of a step (-1: none) and
        its numbers. (0,) without sensors

    Notes
    -----
    Friction in contact sticks, so it has a state (docs/contact.md). That of tendons is a function
    of shape, rates and tension (a regularised law), and needs none.
    """

    model: ModelMark
    step_index: int
    q: Floats
    v: Floats
    dashpots: Floats
    efforts: Floats
    wrench: Floats
    wrench_follows: bool
    pushes: Floats
    pushes_follow: Ints
    courses: Floats
    attached: Ints
    dissipated: float
    load_work: float
    actuator_work: float
    reference: float
    ports: Floats
    held: Floats
    acts: Floats
    multipliers: Floats
    solver: SolverMemory
    bristles: Floats
    sensed: Floats

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.model.scene

    @property
    def step_ns(self) -> int:
        """Size of a step in ns."""
        return self.model.step_ns

    @property
    def time_ns(self) -> int:
        """Simulation time in ns."""
        return self.step_index * self.step_ns

    @property
    def time(self) -> float:
        """Simulation time in s."""
        return self.time_ns / 1e9

    def save(self, path: str | Path) -> None:
        """Write it to a file, whole or not at all; the same state makes the same bytes.

        path : ends with ``.npz`` by custom; numpy reads it, no pickle is in it
        """
        save(self, FORMAT, path)

    @classmethod
    def load(cls, path: str | Path) -> SimulationState:
        """Read it from a file.

        Raises
        ------
        StateError
            which names the file, and the key that is missing or not as expected
        UnfitFile, OSError
            if it is no such file at all, or cannot be read
        """
        return load(cls, FORMAT, path)

    def __repr__(self) -> str:
        return (
            f"<state of {self.scene!r} at t = {self.time:.9g} s, {len(self.q)} coordinates, "
            f"{len(self.efforts)} actuators>"
        )
