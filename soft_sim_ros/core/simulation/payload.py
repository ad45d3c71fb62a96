"""Payloads: rigid bodies that are attached and dropped while the arm moves."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.backend.interrupts import wholly
from soft_sim_ros.core.integrators.problem import (
    DISSIPATED,
    GRAVITY,
    KINETIC,
    LOAD_WORK,
    REFERENCE,
    forget,
)
from soft_sim_ros.errors import BadArgument

from .held import Holding


class Carrying(Holding):
    """A Simulation whose payloads come and go; both take no time."""

    def attach(self, name: str, at_rest: bool = False) -> None:
        """Attach a payload (a rigid body with ``attached`` in its scene); nothing if it is there.

        Parameters
        ----------
        name : of the payload
        at_rest : it rested in space and is caught: momentum is kept, energy is lost. Otherwise it
            moved with the arm already, and brings its energy with it

        Notes
        -----
        In the ledger, the energy that it brings counts as there from the beginning, what is lost as
        dissipated, the work of driven joints while it is caught as that of loads.
        """
        self._change(name, True, at_rest)

    def drop(self, name: str) -> None:
        """Let go of a payload; the arm moves on as it moved. Nothing if it is not there."""
        self._change(name, False, False)

    @property
    def payloads(self) -> dict[str, bool]:
        """Whether each payload of the scene is attached."""
        names = (body.name for body in self.scene.payloads)
        return dict(zip(names, self.dynamics.attached, strict=True))

    def _change(self, name: str, there: bool, at_rest: bool) -> None:
        payloads = self.payloads
        if name not in payloads:
            expected = f"one of the payloads {', '.join(payloads) or '(none)'}"
            raise BadArgument("name", name, expected)
        if payloads[name] == there:
            return
        if at_rest and len(self.dynamics.constraints):
            raise BadArgument("at_rest", at_rest, "False for an arm with constraints")
        wanted = list((payloads | {name: there}).values())

        def change() -> None:
            dynamics, state, n = self.dynamics, self._state, self.n_coordinates
            self._entry.take_stock()
            before = state.account.copy()
            momentum = dynamics.mass_matrix(self.q) @ self.v if at_rest else np.zeros(n)
            dynamics.carry(wanted)
            given = 0.0
            if at_rest:
                free, mass = dynamics.free, dynamics.mass_matrix(self.q)
                left = momentum[free] - mass[np.ix_(free, ~free)] @ self.v[~free]
                self._v[:n][free] = np.linalg.solve(mass[np.ix_(free, free)], left)
                given = float(self.v[~free] @ (mass @ self.v - momentum)[~free])
            self._entry.take_stock()
            brought = state.account - before
            if at_rest:
                state.ledger[LOAD_WORK] += given
                state.ledger[DISSIPATED] += given - brought[KINETIC]
                state.account[REFERENCE] += brought[GRAVITY]
            else:
                state.account[REFERENCE] += brought[GRAVITY] + brought[KINETIC]
            forget(self._work)

        wholly(change)
