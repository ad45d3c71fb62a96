"""Contacts of a state as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.compile.cells import moving_shapes
from soft_sim_ros.core.compile.contact import Station, fixed_shapes, stations
from soft_sim_ros.core.compile.pairs import cells_by_name
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.contact import rows as columns
from soft_sim_ros.core.contact.rows import COLUMNS, contact_rows
from soft_sim_ros.core.contact.settling import pair_reports
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model import pairs as reported
from soft_sim_ros.core.model.model import new_data


@dataclass(frozen=True, eq=False)
class Contact:
    """One station of a body on one shape, or on another body.

    Attributes
    ----------
    body, shape : names; of another body its own
    s : m along the body; 0 on rigid bodies
    point : (3,) m, of the body's surface, in the world
    normal : (3,) from the shape to the body, along world axes
    gap : m, below zero by the depth
    normal_force : N, that pushes the body along the normal
    friction : (3,) N on the body, along world axes
    sticks : whether friction holds it; False where there is none
    slip : (3,) m/s, velocity of the point along the surface
    radius : m of the body there
    length : m of the body that the station stands for; forces over it are forces per length
    s_there : m along the other body, 0 on rigid ones; None: what it touches is a shape
    """

    body: str
    shape: str
    s: float
    point: Floats
    normal: Floats
    gap: float
    normal_force: float
    friction: Floats
    sticks: bool
    slip: Floats
    radius: float
    length: float
    # of what is another body: m along it; None: a shape of the environment
    s_there: float | None = None

    @property
    def force(self) -> Floats:
        """The whole force (3,) in N on the body, along world axes."""
        return self.normal_force * self.normal + self.friction


class ContactReader:
    """Reads contacts off states of a compiled scene."""

    def __init__(self, compiled: Compiled) -> None:
        self._compiled, self._model = compiled, compiled.model
        self._data = new_data(self._model)
        self._stations: list[Station] = stations(compiled.scene, compiled.chain)
        shapes = fixed_shapes(compiled.scene)
        self._shapes = [shape.name for shape in shapes]
        self._rows = np.zeros((len(self._stations), len(shapes), COLUMNS))
        self._zero = np.zeros(len(compiled.coordinate_names))
        self._cells = cells_by_name(compiled.scene, compiled.chain)
        self._moving = {shape.name for shape in moving_shapes(compiled.scene)}

    def near(
        self, q: Floats, v: Floats, gap: float = 0.0, bristles: Floats | None = None
    ) -> tuple[Contact, ...]:
        """Return pairs that are not further apart than a gap in m, in the order of the bodies.

        q, v : (n,)
        bristles : as Touch has them; None: there is no friction
        """
        self._data.touch.bristle[:] = 0.0 if bristles is None else bristles
        contact_rows(self._model, self._data, q, v, self._zero, self._rows)
        turn, origin = self._compiled.base[:3, :3], self._compiled.base[:3, 3]
        found = []
        for e, m in np.argwhere(self._rows[:, :, columns.GAP] <= gap).tolist():
            row, station = self._rows[e, m], self._stations[e]
            normal, point, pull, slide = (
                turn @ row[at : at + 3]
                for at in (columns.NORMAL, columns.POINT, columns.PULL, columns.SLIDE)
            )
            found.append(
                Contact(
                    body=station.body,
                    shape=self._shapes[m],
                    s=station.s,
                    point=origin + point,
                    normal=normal,
                    gap=float(row[columns.GAP]),
                    normal_force=float(row[columns.PUSH]),
                    friction=pull,
                    sticks=bool(row[columns.STICKS]),
                    slip=slide,
                    radius=station.radius,
                    length=station.share,
                )
            )
        if self._cells:
            found += self._between(q, v)
        return tuple(found)

    def _between(self, q: Floats, v: Floats) -> list[Contact]:
        """Return where bodies press on one another, or on shapes that move."""
        pairs, meet = self._model.pairs, self._data.meet
        pair_reports(self._model, self._data, q, v, self._zero)
        turn, origin = self._compiled.base[:3, :3], self._compiled.base[:3, 3]
        found = []
        for i in range(int(meet.counts[1])):
            station, cell = meet.hit[i, :2].tolist()
            row = meet.report[i]
            normal, point, pull, slide = (
                turn @ row[at : at + 3]
                for at in (reported.NORMAL, reported.POINT, reported.PULL, reported.SLIDE)
            )
            body, begins = self._cells[int(pairs.cell[station])]
            other, starts = self._cells[cell]
            rod = self._model.pairs.kind[pairs.cell[station]] == reported.CURVE
            there: float | None = None
            if other not in self._moving:
                begin, end = pairs.reach[cell].tolist()
                there = begin + float(meet.spot[i]) * (end - begin) - starts
                there = there if pairs.kind[cell] == reported.CURVE else 0.0
            found.append(
                Contact(
                    body=body,
                    shape=other,
                    s=float(pairs.arc[station]) - begins if rod else 0.0,
                    point=origin + point,
                    normal=normal,
                    gap=float(row[reported.GAP]),
                    normal_force=float(row[reported.PUSH]),
                    friction=pull,
                    sticks=bool(row[reported.STICKS]),
                    slip=slide,
                    radius=float(pairs.radius[station]),
                    length=float(pairs.share[station]),
                    s_there=there,
                )
            )
        return found


def resultants(contacts: Sequence[Contact]) -> dict[tuple[str, str], Floats]:
    """Return for each pair (body, shape) that touches the wrench on the body (6,).

    Moment in N·m about the origin of the world, force in N, along world axes. Of two bodies that
    touch one another there are both: (one, other) and, opposite, (other, one).
    """
    out: dict[tuple[str, str], Floats] = {}
    for contact in contacts:
        pair = contact.body, contact.shape
        wrench = np.concatenate([np.cross(contact.point, contact.force), contact.force])
        out[pair] = out.get(pair, np.zeros(6)) + wrench
        if contact.s_there is not None and contact.body != contact.shape:
            back = contact.shape, contact.body
            out[back] = out.get(back, np.zeros(6)) - wrench
    return out
