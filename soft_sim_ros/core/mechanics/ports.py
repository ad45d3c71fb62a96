"""Actuators of a scene as ports: positions, rates and efforts, and the forces per effort."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.arguments import vector_or_zeros, whole
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.recursion.output import ports
from soft_sim_ros.core.terms.friction import TENSION

from .equations import Equations


class Ports(Equations):
    """The actuators of the equations of motion of a scene.

    Parameters
    ----------
    scene : Scene or Compiled
    """

    def effort_matrix(self, q: Floats, efforts: Floats | None = None) -> Floats:
        """Return the generalised force per unit effort (n, A) at rest.

        The residual is linear in the efforts, so finite differences are exact. They are small,
        because a tendon whose length is commanded may be close to slack.
        """
        level = vector_or_zeros("efforts", efforts, self.actuators)
        still = self.residual(q, self._zero, self._zero, self.forcing(level))
        length = self.model.length_control[:, 0] != 0.0
        size = np.where(length, 1e-6, 1.0)
        columns = [
            (still - self.residual(q, self._zero, self._zero, self.forcing(level + move)))
            / move.sum()
            for move in np.diag(size)
        ]
        return np.stack(columns, axis=1) if columns else np.zeros((self.n, 0))

    def ports(self, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return position and velocity (A,) of the actuator ports.

        Effort · velocity is power into the arm.
        """
        return self._ports(q, v)[:2]

    def port_efforts(self, q: Floats, v: Floats, efforts: Floats) -> Floats:
        """Return the efforts (A,) that act: those given, but tensions where lengths are given."""
        self.forcing(efforts)
        return self._ports(q, v)[2]

    def _ports(self, q: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        position, velocity, effort = np.zeros((3, self.actuators))
        state = self.coordinates(q), self.coordinates(v, "v")
        ports(self.model, self._data, *state, self._zero, position, velocity, effort)
        return position, velocity, effort

    def tensions(self, q: Floats, v: Floats, efforts: Floats, actuator: int) -> Floats:
        """Return the tension in N along a tendon (2 P,), start to end, at its P segments' points.

        It changes along the tendon only where there is friction, and only while it slips.
        """
        actuator = whole("actuator", actuator, 0, self.actuators - 1)
        self.residual(q, v, self._zero, self.forcing(efforts))
        begin, end = self.model.tendon_ptr[actuator : actuator + 2]
        if self.model.friction[actuator, 0] != 0.0:
            return self._data.station[begin:end, :, TENSION].ravel()
        return np.full(2 * (end - begin), self.port_efforts(q, v, efforts)[actuator])
