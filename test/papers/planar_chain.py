"""Hinged planar beams in absolute coordinates: finite elements of Simo and Vu-Quoc's beam.

Unknowns are the positions and section angles of nodes, in the world's axes: no strains as
coordinates, no joints' angles, no recursion. Linear elements with one point of quadrature, lumped
masses, explicit integration; second order in the element size, so two meshes are extrapolated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass
class Beams:
    """p equal beams in a row, hinged at their ends, the first one to the ground at the origin."""

    lengths: tuple[float, ...]
    axial: float  # EA in N
    shear: float  # GA in N
    bending: float  # EI in N·m²
    line: float  # ρA in kg/m
    rotary: float  # ρI in kg·m
    gravity: float  # along −y
    torques: tuple[float, ...]  # of the hinges, on the beam after from the one before
    retardation: float  # s, Kelvin and Voigt's: wrench = stiffness (strain + retardation · rate)

    def motion(self, angles, time: float, n: int):
        """Return ends of all beams (p, 2) and section angles at their starts after ``time``.

        From rest, straight, at absolute angles.
        """
        p = len(self.lengths)
        x, theta = [np.zeros(2)], []
        for length, angle in zip(self.lengths, angles, strict=True):
            along = np.array([np.cos(angle), np.sin(angle)])
            first = x[-1]
            x += [first + length * k / n * along for k in range(1, n + 1)]
            theta += [np.full(n + 1, angle)]
        count = p * n + 1
        y0 = np.concatenate([np.array(x).ravel(), np.concatenate(theta)])
        h = np.repeat(np.array(self.lengths) / n, n)
        mass = np.zeros(count)
        mass[:-1] += 0.5 * self.line * h
        mass[1:] += 0.5 * self.line * h
        half = 0.5 * self.rotary * h.reshape(p, n)
        inertia = np.zeros((p, n + 1))
        inertia[:, :-1] += half
        inertia[:, 1:] += half

        def along_elements(y):
            r, t = y[: 2 * count].reshape(count, 2), y[2 * count :].reshape(p, n + 1)
            middle, bend = 0.5 * (t[:, :-1] + t[:, 1:]).ravel(), np.diff(t, axis=1).ravel() / h
            return middle, bend, np.diff(r, axis=0) / h[:, None]

        def accelerations(y, rate):
            middle, bend, slope = along_elements(y)
            turning, bending, sloping = along_elements(rate)
            c, s = np.cos(middle), np.sin(middle)
            e1, e2 = c * slope[:, 0] + s * slope[:, 1], c * slope[:, 1] - s * slope[:, 0]
            d1 = c * sloping[:, 0] + s * sloping[:, 1] + turning * e2
            d2 = c * sloping[:, 1] - s * sloping[:, 0] - turning * e1
            n1 = self.axial * (e1 - 1.0 + self.retardation * d1)
            n2 = self.shear * (e2 + self.retardation * d2)
            force = np.stack([c * n1 - s * n2, s * n1 + c * n2], axis=1)
            push = np.zeros((count, 2))
            push[:-1] += force
            push[1:] -= force
            push[:, 1] -= mass * self.gravity
            push[0] = 0.0
            turn = 0.5 * (h * (n2 * e1 - n1 * e2)).reshape(p, n)
            moment = (self.bending * (bend + self.retardation * bending)).reshape(p, n)
            spin = np.zeros((p, n + 1))
            spin[:, :-1] += turn + moment
            spin[:, 1:] += turn - moment
            for j, torque in enumerate(self.torques):
                spin[j, 0] += torque
                if j > 0:
                    spin[j - 1, -1] -= torque
            return np.concatenate([(push / mass[:, None]).ravel(), (spin / inertia).ravel()])

        size = len(y0)

        def rates(t, y):
            return np.concatenate([y[size:], accelerations(y[:size], y[size:])])

        start = np.concatenate([y0, np.zeros(size)])
        y = solve_ivp(rates, (0, time), start, method="DOP853", rtol=1e-7, atol=1e-8).y[:, -1]
        return y[: 2 * count].reshape(count, 2)[n::n], y[2 * count : size].reshape(p, n + 1)[:, 0]

    def extrapolated(self, angles, time: float, n: int):
        """Return ``motion`` for element size zero, by Richardson's extrapolation."""
        coarse, fine = self.motion(angles, time, n), self.motion(angles, time, 2 * n)
        return tuple((4.0 * b - a) / 3.0 for a, b in zip(coarse, fine, strict=True))
